//! Changes between frames: transforms of instances, shapes of meshes.

use super::{InstanceIndex, MeshIndex, Scene, SceneError};
use crate::layout::{Kind, Node};
use crate::scene::Mesh;
use crate::scene::bvh::{Bounds, refit};
use crate::scene::place::{InstanceMaterial, Stored, matrix, place, place_in, sphere};
use alloc::vec;
use glam::{DVec3, Mat4};

impl Scene {
    /// Moves an instance; one that was hidden is seen again.
    ///
    /// # Errors
    /// As for [`Scene::add_instance`]; the instance then stays where it was.
    pub fn set_transform(&mut self, instance: InstanceIndex, to_world: Mat4) -> Result<(), SceneError> {
        self.set_transforms([(instance, to_world)])
    }

    /// Moves many instances. The time does not depend on the others, but for their logarithm.
    ///
    /// # Errors
    /// As for [`Scene::add_instance`], for the first instance that cannot be moved; it and those
    /// after it then stay where they were.
    pub fn set_transforms(
        &mut self,
        moved: impl IntoIterator<Item = (InstanceIndex, Mat4)>,
    ) -> Result<(), SceneError> {
        let result =
            moved.into_iter().try_for_each(|(instance, to_world)| self.place_again(instance, to_world));
        self.moved([]);
        result
    }

    /// Moves an instance. [`Scene::moved`] must follow.
    fn place_again(&mut self, instance: InstanceIndex, to_world: Mat4) -> Result<(), SceneError> {
        let index = self.instance(instance)?;
        let levels = self.moved_levels(index, to_world)?;
        let stored = &self.meshes[self.object_meshes[index] as usize];
        let placed = &mut self.instances[index];
        place_in(placed, stored, InstanceMaterial::of(placed), to_world)?;
        if let Some((light, _)) = self.shown.iter().find(|(_, sphere)| **sphere == instance.number) {
            placed.kind = Kind::Light as u32 + light;
        }
        self.places.set(index, &Bounds { low: placed.low, high: placed.high });
        if let Some(levels) = levels {
            self.levels.insert(instance.number, levels);
        }
        Ok(())
    }

    /// Hides an instance until it gets a transform again.
    ///
    /// # Errors
    /// There is no such instance.
    pub fn hide(&mut self, instance: InstanceIndex) -> Result<(), SceneError> {
        let index = self.instance(instance)?;
        let stored = self.mesh(self.object_meshes[index])?;
        // The empty leaf beside the mesh's root: no ray hits it.
        let nothing = Stored {
            kind: Kind::Mesh,
            root: stored.root - 1,
            triangles: 0,
            bounds: Bounds { low: [0.0; 3], high: [0.0; 3] },
            center: DVec3::ZERO,
            radius: 0.0,
            ..*stored
        };
        let placed = &mut self.instances[index];
        place_in(placed, &nothing, InstanceMaterial::of(placed), Mat4::IDENTITY)?;
        self.moved([index]);
        Ok(())
    }

    /// Gives a mesh another shape: the same triangles with their corners elsewhere. `shape`
    /// has the triangles of the mesh that was added, in the same order, with other positions,
    /// normals and tangents; other attributes stay. The boxes of the mesh's BVH are refitted, its links stay,
    /// and its instances keep their transforms.
    ///
    /// # Errors
    /// There is no such mesh, `shape` has more or fewer triangles, or an instance would be out
    /// of range. The scene then stays as it was.
    pub fn reshape(&mut self, mesh: MeshIndex, shape: &Mesh) -> Result<(), SceneError> {
        let mut stored = *self.indexed_mesh(mesh)?;
        let (triangles, expected) = (shape.triangles(), stored.triangles as usize);
        if triangles != expected {
            return Err(SceneError::Shape { triangles, expected });
        }
        if stored.triangles == 0 {
            return Ok(());
        }
        stored.bounds = Bounds::of(shape.indices().iter().map(|&i| shape.positions()[i as usize]));
        (stored.center, stored.radius) = sphere(shape.positions(), &stored.bounds);
        let mut placed = vec![];
        for (index, instance) in self.instances.iter().enumerate() {
            if self.object_meshes[index] == mesh.number && instance.root == stored.root {
                placed.push((index, place(&stored, InstanceMaterial::of(instance), matrix(instance))?));
            }
        }
        let levels = self.reshaped_levels(mesh, &stored)?;
        for triangle in 0..stored.triangles as usize {
            let source = 3 * self.sources[stored.first_source + triangle] as usize;
            for corner in 0..3 {
                let vertex = self.mesh_data[stored.first_index as usize + 3 * triangle + corner];
                let from = shape.indices()[source + corner] as usize;
                let to = (stored.first_vertex + vertex) as usize;
                self.positions[to] = shape.positions()[from];
                self.attributes[to].normal = shape.attributes()[from].normal;
                if stored.first_tangent != 0
                    && let Some(&tangent) = shape.tangents().get(from)
                {
                    self.mesh_data[(stored.first_tangent + vertex) as usize] = tangent;
                }
            }
        }
        let nodes: &mut [Node] = bytemuck::cast_slice_mut(&mut self.nodes);
        let nodes = &mut nodes[stored.root as usize..][..stored.nodes as usize];
        let (mesh_data, positions) = (&self.mesh_data, &self.positions);
        refit(nodes, |vertex| {
            positions[(stored.first_vertex + mesh_data[stored.first_index as usize + vertex]) as usize]
        });
        stored.shape_version += 1;
        self.meshes[mesh.number as usize] = stored;
        for &(index, instance) in &placed {
            self.instances[index] = instance;
        }
        self.replace_levels(levels);
        self.versions.geometry += 1;
        self.moved(placed.into_iter().map(|(index, _)| index));
        Ok(())
    }
}

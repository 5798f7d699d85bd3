//! What changes between frames: where objects are, and the shapes of meshes.

use super::{MeshIndex, ObjectIndex, Scene, SceneError};
use crate::layout::{Kind, Node};
use crate::scene::Mesh;
use crate::scene::place::{Coat, Stored, matrix, place, sphere};
use crate::scene::tree::{Bounds, refit};
use alloc::vec;
use glam::{DVec3, Mat4};

impl Scene {
    /// Moves an object; one that was hidden is seen again.
    ///
    /// # Errors
    /// As for [`Scene::add_object`]; the object then stays where it was.
    pub fn set_transform(&mut self, object: ObjectIndex, to_world: Mat4) -> Result<(), SceneError> {
        self.set_transforms([(object, to_world)])
    }

    /// Moves many objects at the cost of going through all of them once.
    ///
    /// # Errors
    /// As for [`Scene::add_object`], for the first object that cannot be moved; it and those
    /// after it then stay where they were.
    pub fn set_transforms(
        &mut self,
        moved: impl IntoIterator<Item = (ObjectIndex, Mat4)>,
    ) -> Result<(), SceneError> {
        let result = moved.into_iter().try_for_each(|(object, to_world)| {
            let (index, old) = self.object(object)?;
            let stored = self.mesh(self.object_meshes[index])?;
            let mut placed = place(stored, Coat::of(&old), to_world)?;
            if let Some((light, _)) = self.shown.iter().find(|(_, sphere)| **sphere == object.0) {
                placed.kind = Kind::Light as u32 + light;
            }
            let levels = self.moved_levels(index, to_world)?;
            self.objects[index] = placed;
            if !levels.is_empty() {
                self.levels.insert(object.0, levels);
            }
            Ok(())
        });
        self.objects_changed();
        result
    }

    /// Takes an object out of the picture, until it is given a transform again.
    ///
    /// # Errors
    /// There is no such object.
    pub fn hide(&mut self, object: ObjectIndex) -> Result<(), SceneError> {
        let (index, old) = self.object(object)?;
        let stored = self.mesh(self.object_meshes[index])?;
        // The empty leaf beside the mesh's root: no ray meets it, wherever it is.
        let nothing = Stored {
            kind: Kind::Mesh,
            root: stored.root - 1,
            triangles: 0,
            bounds: Bounds { low: [0.0; 3], high: [0.0; 3] },
            center: DVec3::ZERO,
            radius: 0.0,
            ..*stored
        };
        self.objects[index] = place(&nothing, Coat::of(&old), Mat4::IDENTITY)?;
        self.objects_changed();
        Ok(())
    }

    /// Gives a mesh another shape: the same triangles with their corners elsewhere. `shape`
    /// has the triangles of the mesh that was added, in the same order, with other positions,
    /// normals and tangents; other attributes stay as they were. The mesh's tree keeps its form,
    /// its boxes are refitted, and the mesh's objects stay where they are.
    ///
    /// # Errors
    /// There is no such mesh, `shape` has more or fewer triangles, or an object would be out
    /// of range; nothing has changed then.
    pub fn reshape(&mut self, mesh: MeshIndex, shape: &Mesh) -> Result<(), SceneError> {
        let mut stored = *self.mesh(mesh.0)?;
        if shape.triangles() != stored.triangles as usize {
            return Err(SceneError::Index { what: "triangle", index: shape.triangles() as u32 });
        }
        if stored.triangles == 0 {
            return Ok(());
        }
        stored.bounds = Bounds::of(shape.indices().iter().map(|&i| shape.positions()[i as usize]));
        (stored.center, stored.radius) = sphere(shape, &stored.bounds);
        let mut placed = vec![];
        for (index, object) in self.objects.iter().enumerate() {
            if self.object_meshes[index] == mesh.0 && object.root == stored.root {
                placed.push((index, place(&stored, Coat::of(object), matrix(object))?));
            }
        }
        let levels = self.reshaped_levels(mesh, &stored)?;
        for triangle in 0..stored.triangles as usize {
            let source = 3 * self.sources[stored.first_source + triangle] as usize;
            for corner in 0..3 {
                let vertex = self.words[stored.first_index as usize + 3 * triangle + corner];
                let from = shape.indices()[source + corner] as usize;
                let to = (stored.first_vertex + vertex) as usize;
                self.positions[to] = shape.positions()[from];
                self.attributes[to].normal = shape.attributes()[from].normal;
                if stored.first_tangent != 0
                    && let Some(&tangent) = shape.tangents().get(from)
                {
                    self.words[(stored.first_tangent + vertex) as usize] = tangent;
                }
            }
        }
        let nodes: &mut [Node] = bytemuck::cast_slice_mut(&mut self.nodes);
        let nodes = &mut nodes[stored.root as usize..][..stored.nodes as usize];
        let (words, positions) = (&self.words, &self.positions);
        refit(nodes, |vertex| {
            positions[(stored.first_vertex + words[stored.first_index as usize + vertex]) as usize]
        });
        self.meshes[mesh.0 as usize] = stored;
        for (index, object) in placed {
            self.objects[index] = object;
        }
        self.replace_levels(levels);
        self.versions.geometry += 1;
        self.objects_changed();
        Ok(())
    }
}

//! Meshes that stay where the caller has them.

use super::source::{MeshNodes, MeshVersion, Parts};
use crate::kernel::triangle::Intersection;
use crate::layout::{Attribute, Instance};
use crate::scene::{
    Bounds, Bvh, COORDINATE_LIMIT, Identity, InstanceIndex, InstanceMaterial, Join, MaterialIndex, Mesh,
    MeshError, MeshIndex, Places, SceneError, Sequential, Stored, Tag, place,
};
use alloc::vec::Vec;
use glam::Mat4;

/// Meshes that rays can be asked of and that stay where the caller has them. (The leaves of a
/// [`Tree`](super::Tree) have the corners of their triangles as well.)
///
/// They have no materials. Both sides of a triangle are drawn. A [`Scene`](crate::scene::Scene) has those, and
/// spheres.
///
/// ```
/// use glam::Mat4;
/// use rtrt_core::query::{Ray, Shapes, Tree};
/// use rtrt_core::scene::Sequential;
///
/// let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
/// let mut shapes = Shapes::new();
/// let mesh = shapes.add_mesh(&positions, &[0, 1, 2], &Sequential)?;
/// shapes.add_instance(mesh, Mat4::from_translation([0.0, 0.0, -5.0].into()))?;
/// let mut tree = Tree::default();
/// let hit = tree.world(&shapes).closest(&Ray::new([0.25, 0.25, 0.0], [0.0, 0.0, -1.0]))?;
/// assert!(hit.is_some_and(|hit| (hit.t - 5.0).abs() < 1e-5));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// A clone is other shapes, of which the same indices name the same things.
#[derive(Debug, Clone)]
pub struct Shapes<'a> {
    identity: Identity,
    meshes: Vec<Shape<'a>>,
    /// So many meshes were added or removed.
    mesh_changes: u32,
    instances: Vec<Instance>,
    mesh_numbers: Vec<u32>,
    places: Places,
    tags: Vec<Tag>,
    /// The numbers of meshes and of instances that were removed; the next one gets the last.
    free_meshes: Vec<u32>,
    free_instances: Vec<u32>,
}

/// One mesh.
#[derive(Debug, Clone)]
struct Shape<'a> {
    positions: &'a [[f32; 3]],
    indices: &'a [u32],
    tree: Bvh,
    stored: Stored,
}

impl Default for Shapes<'_> {
    fn default() -> Self {
        Self::new()
    }
}

impl<'a> Shapes<'a> {
    /// Nothing yet.
    pub fn new() -> Self {
        Self {
            identity: Identity::new(),
            meshes: Vec::new(),
            mesh_changes: 0,
            instances: Vec::new(),
            mesh_numbers: Vec::new(),
            places: Places::default(),
            tags: Vec::new(),
            free_meshes: Vec::new(),
            free_instances: Vec::new(),
        }
    }

    /// Adds the triangles between these positions (object space), three indices each, and builds their tree.
    ///
    /// # Errors
    /// A coordinate is NaN or beyond [`COORDINATE_LIMIT`], an index names no position, or the indices do not make
    /// whole triangles.
    pub fn add_mesh(
        &mut self,
        positions: &'a [[f32; 3]],
        indices: &'a [u32],
        join: &impl Join,
    ) -> Result<MeshIndex, MeshError> {
        check(positions, indices)?;
        Ok(self.push(positions, indices, Bvh::of_triangles(positions, indices, join)))
    }

    /// [`Shapes::add_mesh`] with a BVH that was built before, as of [`Shapes::bvh`] or
    /// [`Bvh::from_bytes`].
    ///
    /// # Errors
    /// As for [`Shapes::add_mesh`], or the BVH is not one of these triangles.
    pub fn add_mesh_with(
        &mut self,
        positions: &'a [[f32; 3]],
        indices: &'a [u32],
        bvh: Bvh,
    ) -> Result<MeshIndex, MeshError> {
        check(positions, indices)?;
        bvh.check_shape(positions, indices)?;
        Ok(self.push(positions, indices, bvh))
    }

    /// The BVH of a mesh; `None` if there is no such mesh.
    pub fn bvh(&self, mesh: MeshIndex) -> Option<&Bvh> {
        self.shape(mesh).ok().map(|shape| &shape.tree)
    }

    fn shape(&self, mesh: MeshIndex) -> Result<&Shape<'a>, SceneError> {
        let (family, missing) =
            (self.identity.family, SceneError::Index { what: "mesh", index: mesh.number });
        let is_here = |shape: &&Shape<'_>| (mesh.scene, mesh.generation) == (family, shape.stored.generation);
        self.meshes.get(mesh.number as usize).filter(is_here).ok_or(missing)
    }

    fn push(&mut self, positions: &'a [[f32; 3]], indices: &'a [u32], tree: Bvh) -> MeshIndex {
        let number = self.free_meshes.pop().unwrap_or(self.meshes.len() as u32);
        self.put(number, positions, indices, tree);
        let generation = self.meshes[number as usize].stored.generation;
        MeshIndex { number, generation, scene: self.identity.family }
    }

    /// Puts a mesh where there is none, or in place of one.
    fn put(&mut self, number: u32, positions: &'a [[f32; 3]], indices: &'a [u32], tree: Bvh) {
        self.mesh_changes += 1;
        let mut stored = Stored::of_shape(number, &tree, positions);
        match self.meshes.get_mut(number as usize) {
            Some(old) => {
                stored.generation = old.stored.generation.wrapping_add(1);
                *old = Shape { positions, indices, tree, stored };
            }
            None => self.meshes.push(Shape { positions, indices, tree, stored }),
        }
    }

    /// Places a mesh in the world. `to_world` takes object to world space.
    ///
    /// # Errors
    /// As for [`Scene::add_instance`](crate::scene::Scene::add_instance).
    pub fn add_instance(&mut self, mesh: MeshIndex, to_world: Mat4) -> Result<InstanceIndex, SceneError> {
        let instance = place(&self.shape(mesh)?.stored, InstanceMaterial::NONE, to_world)?;
        if let Some(number) = self.free_instances.pop() {
            let index = number as usize;
            (self.instances[index], self.mesh_numbers[index]) = (instance, mesh.number);
            self.tags[index] = self.tags[index].next();
            self.places.set(index, &Bounds { low: instance.low, high: instance.high });
            self.places.update();
            return Ok(self.numbered(number));
        }
        let number = u32::try_from(self.instances.len())
            .ok()
            .filter(|&number| number < u32::MAX / 4)
            .ok_or(SceneError::TooLarge { what: "instances" })?;
        self.places.push(&Bounds { low: instance.low, high: instance.high });
        self.instances.push(instance);
        self.mesh_numbers.push(mesh.number);
        self.tags.push(Tag::default());
        Ok(self.numbered(number))
    }

    /// See [`Scene::remove_instance`](crate::scene::Scene::remove_instance).
    ///
    /// # Errors
    /// There is no such instance.
    pub fn remove_instance(&mut self, instance: InstanceIndex) -> Result<(), SceneError> {
        let index = self.index(instance)?;
        self.tags[index] = self.tags[index].next();
        self.places.set(index, &Bounds::EMPTY);
        self.places.update();
        self.free_instances.push(instance.number);
        Ok(())
    }

    /// Removes a mesh, and lets go of its slices. Its index names nothing from now on.
    ///
    /// # Errors
    /// There is no such mesh, or an instance has it.
    pub fn remove_mesh(&mut self, mesh: MeshIndex) -> Result<(), SceneError> {
        self.shape(mesh)?;
        let own = self.mesh_numbers.iter().zip(&self.tags);
        let instances = own.filter(|(number, tag)| **number == mesh.number && tag.is_live()).count();
        if instances > 0 {
            return Err(SceneError::InUse { index: mesh.number, instances });
        }
        self.put(mesh.number, &[], &[], Bvh::of_triangles(&[], &[], &Sequential));
        self.free_meshes.push(mesh.number);
        Ok(())
    }

    /// Moves an instance.
    ///
    /// # Errors
    /// As for [`Shapes::add_instance`]; the instance then stays where it was.
    pub fn set_transform(&mut self, instance: InstanceIndex, to_world: Mat4) -> Result<(), SceneError> {
        self.set_transforms([(instance, to_world)])
    }

    /// Moves many instances.
    ///
    /// # Errors
    /// As for [`Shapes::add_instance`], for the first instance that cannot be moved; it and those after it
    /// then stay where they were.
    pub fn set_transforms(
        &mut self,
        moved: impl IntoIterator<Item = (InstanceIndex, Mat4)>,
    ) -> Result<(), SceneError> {
        let result = moved.into_iter().try_for_each(|(instance, to_world)| {
            let index = self.index(instance)?;
            let stored = &self.meshes[self.mesh_numbers[index] as usize].stored;
            let placed = place(stored, InstanceMaterial::NONE, to_world)?;
            self.places.set(index, &Bounds { low: placed.low, high: placed.high });
            self.instances[index] = placed;
            Ok(())
        });
        self.places.update();
        result
    }

    /// See [`Scene::set_ray_mask`](crate::scene::Scene::set_ray_mask).
    ///
    /// # Errors
    /// There is no such instance.
    pub fn set_ray_mask(&mut self, instance: InstanceIndex, mask: u32) -> Result<(), SceneError> {
        let index = self.index(instance)?;
        self.tags[index].mask = mask;
        let bounds = *self.places.bounds(index);
        self.places.set(index, &bounds);
        self.places.update();
        Ok(())
    }

    /// See [`Scene::set_user_data`](crate::scene::Scene::set_user_data).
    ///
    /// # Errors
    /// There is no such instance.
    pub fn set_user_data(&mut self, instance: InstanceIndex, user: u32) -> Result<(), SceneError> {
        let index = self.index(instance)?;
        self.tags[index].user = user;
        Ok(())
    }

    /// The instance with a number; `None` where there is none.
    pub fn instance_index(&self, number: u32) -> Option<InstanceIndex> {
        self.tags.get(number as usize).filter(|tag| tag.is_live()).map(|_| self.numbered(number))
    }

    /// The place of an instance in the arrays.
    fn index(&self, instance: InstanceIndex) -> Result<usize, SceneError> {
        self.place_of(instance).ok_or(SceneError::Index { what: "instance", index: instance.number })
    }
}

/// Refuses what are no triangles.
fn check(positions: &[[f32; 3]], indices: &[u32]) -> Result<(), MeshError> {
    if !indices.len().is_multiple_of(3) {
        return Err(MeshError::Ragged { count: indices.len() });
    }
    if indices.len() / 3 > Mesh::MAX_TRIANGLES {
        return Err(MeshError::TooLarge { triangles: indices.len() / 3 });
    }
    for (vertex, position) in positions.iter().enumerate() {
        let is_wrong = |c: &&f32| c.is_nan() || c.abs() > COORDINATE_LIMIT;
        if let Some(&value) = position.iter().find(is_wrong) {
            return Err(MeshError::Coordinate { vertex, value });
        }
    }
    let vertices = positions.len();
    if let Some(index) = indices.iter().position(|&i| i as usize >= vertices) {
        return Err(MeshError::Index { index, value: indices[index], vertices });
    }
    Ok(())
}

impl Parts for Shapes<'_> {
    fn id(&self) -> u32 {
        self.identity.own
    }
    fn family(&self) -> u32 {
        self.identity.family
    }
    fn meshes(&self) -> usize {
        self.meshes.len()
    }
    fn mesh_changes(&self) -> u32 {
        self.mesh_changes
    }
    fn nodes(&self, mesh: usize) -> MeshNodes<'_> {
        let shape = &self.meshes[mesh];
        let version = MeshVersion { generation: shape.stored.generation, shape: 0 };
        MeshNodes { nodes: &shape.tree.nodes, version }
    }
    #[inline(always)]
    fn instances(&self) -> &[Instance] {
        &self.instances
    }
    #[inline(always)]
    fn mesh_of(&self, instance: usize) -> usize {
        self.mesh_numbers[instance] as usize
    }
    #[inline(always)]
    fn places(&self) -> &Places {
        &self.places
    }
    #[inline(always)]
    fn tags(&self) -> &[Tag] {
        &self.tags
    }
    fn mesh_triangle(&self, mesh: usize, triangle: u32) -> [[f32; 3]; 3] {
        let shape = &self.meshes[mesh];
        let first = 3 * shape.tree.triangles[triangle as usize] as usize;
        [0, 1, 2].map(|corner| shape.positions[shape.indices[first + corner] as usize])
    }
    fn corners(&self, instance: &Instance, triangle: u32) -> [u32; 3] {
        let shape = &self.meshes[instance.root as usize];
        let first = 3 * shape.tree.triangles[triangle as usize] as usize;
        [shape.indices[first], shape.indices[first + 1], shape.indices[first + 2]]
    }
    fn position(&self, instance: &Instance, vertex: u32) -> [f32; 3] {
        self.meshes[instance.root as usize].positions[vertex as usize]
    }
    fn attribute(&self, _: u32) -> Option<Attribute> {
        None
    }
    fn is_hole(&self, _: u32, _: u32, _: &Intersection<f32>) -> bool {
        false
    }
    fn material(&self, _: &Instance) -> Option<MaterialIndex> {
        None
    }
    fn source_triangle(&self, instance: usize, triangle: u32) -> u32 {
        let shape = &self.meshes[self.mesh_numbers[instance] as usize];
        shape.tree.triangles.get(triangle as usize).copied().unwrap_or(triangle)
    }
}

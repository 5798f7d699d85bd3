//! The scene: all arrays that a backend reads.

mod change;
mod materials;
mod meshes;
mod remove;
mod textures;
mod transparency;

use crate::kernel::texture::Maps;
use crate::layout::{AlphaKind, Attribute, Backdrop, COLOR_LIMIT, Instance, Kind, MaterialRecord, Node, Sky};
use crate::scene::bvh::Bounds;
use crate::scene::levels::LodLevel;
use crate::scene::place::{Stored, place};
use crate::scene::places::{Places, Tag};
use crate::scene::{
    Bvh, BvhError, CubeError, ImageError, Light, LightKind, Material, Mesh, Mip, Occluders, PanoramaError,
    Sequential, Structure,
};
use alloc::collections::BTreeMap;
use alloc::vec;
use alloc::vec::Vec;
use bytemuck::{Pod, Zeroable};
use core::sync::atomic::{AtomicU32, Ordering};
use glam::{Mat4, Vec3};

/// A mesh of one scene; other scenes refuse it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MeshIndex {
    pub(crate) number: u32,
    /// [`Stored::generation`].
    pub(crate) generation: u32,
    /// [`Identity::family`].
    pub(crate) scene: u32,
}
/// A material of one scene; other scenes refuse it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MaterialIndex {
    pub(super) number: u32,
    /// [`Identity::family`].
    pub(super) scene: u32,
}
impl MaterialIndex {
    /// The number of the material, from 0 in the order in which materials were added: its place in
    /// [`Scene::materials`].
    pub fn number(self) -> u32 {
        self.number
    }
}

/// An instance of one scene; other scenes refuse it. Equal hits are decided by it: the lower one wins.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct InstanceIndex {
    pub(crate) number: u32,
    /// [`Tag::generation`].
    pub(crate) generation: u32,
    /// [`Identity::family`].
    pub(crate) scene: u32,
}

impl InstanceIndex {
    /// The number of the instance, from 0 in the order in which instances were added: that of
    /// [`Hit::instance`](crate::layout::Hit::instance). After [`Scene::remove_instance`] the next one that is added
    /// has the number of the one that was removed.
    pub fn number(self) -> u32 {
        self.number
    }
}

/// Why something could not be added to a scene.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// The transform has no inverse, is not affine, or is not finite.
    #[error("the transform of the instance has a number that is not finite, or cannot be inverted")]
    Transform,
    /// The instance would reach beyond [`COORDINATE_LIMIT`](super::COORDINATE_LIMIT).
    #[error("the instance reaches to {value}, which is not within ±2^30")]
    Coordinate {
        /// The coordinate.
        value: f32,
    },
    /// An array would have more elements than 32 bits can number.
    #[error("the scene has too many {what}")]
    TooLarge {
        /// The array.
        what: &'static str,
    },
    /// An index does not belong to this scene.
    #[error("{what} {index} is not in the scene")]
    Index {
        /// The kind of index.
        what: &'static str,
        /// The index.
        index: u32,
    },
    /// A mesh that is to be removed is that of instances, or a level of detail of them.
    #[error("mesh {index} cannot be removed: it is in use, number of instances: {instances}")]
    InUse {
        /// The number of the mesh.
        index: u32,
        /// How many instances have it.
        instances: usize,
    },
    /// A distance from which on an instance has another mesh is not a number above 0.
    #[error("{value} is not a distance from which on an instance may have another mesh")]
    Distance {
        /// What it is.
        value: f32,
    },
    /// A number of a material is NaN, infinite, or out of its range.
    #[error("the {what} of a material is {value}, which is not within {low:e} ..= {high:e}")]
    Material {
        /// The number's name.
        what: &'static str,
        /// What it is.
        value: f32,
        /// The least that it may be.
        low: f32,
        /// The most.
        high: f32,
    },
    /// The tree is not one of the mesh.
    #[error(transparent)]
    Tree(#[from] BvhError),
    /// A shape has another number of triangles than the mesh that it is meant for.
    #[error("the shape has {triangles} triangles, and the mesh has {expected}")]
    Shape {
        /// Those of the shape.
        triangles: usize,
        /// Those of the mesh.
        expected: usize,
    },
    /// The texture was refused.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// The environment was refused.
    #[error(transparent)]
    Panorama(#[from] PanoramaError),
    /// The environment was refused.
    #[error(transparent)]
    Cube(#[from] CubeError),
}

/// Counts the changes of each part of a scene, so that a backend that keeps copies renews
/// only what changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Versions {
    /// Nodes, mesh data, positions, attributes.
    pub geometry: u32,
    /// Texels.
    pub texels: u32,
    /// Materials.
    pub materials: u32,
    /// Instances.
    pub instances: u32,
}

/// Two children in one cache line.
#[repr(C, align(64))]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
struct Pair([Node; 2]);

/// Which scene one is.
#[derive(Debug)]
pub(crate) struct Identity {
    /// A number that nothing else has.
    pub own: u32,
    /// The number of the scene that it is a clone of, or a clone of a clone, and so on; else its own. Indices carry it, so
    /// those of a scene and of its clones are good in each other.
    pub family: u32,
}

impl Identity {
    pub fn new() -> Self {
        let own = unique_id();
        Self { own, family: own }
    }
}

impl Clone for Identity {
    fn clone(&self) -> Self {
        Self { own: unique_id(), family: self.family }
    }
}

/// A scene.
///
/// A clone has all that the scene has, and an [`id`](Self::id) of its own. An index of one names the same thing in the
/// other; what is added afterwards has an index that only its own scene knows the meaning of.
#[derive(Debug, Clone)]
pub struct Scene {
    identity: Identity,
    versions: Versions,
    nodes: Vec<Pair>,
    mesh_data: Vec<u32>,
    sources: Vec<u32>,
    positions: Vec<[f32; 3]>,
    attributes: Vec<Attribute>,
    texels: Vec<u32>,
    materials: Vec<Material>,
    material_records: Vec<MaterialRecord>,
    instances: Vec<Instance>,
    object_meshes: Vec<u32>,
    meshes: Vec<Stored>,
    /// The numbers of meshes and of instances that were removed; the next one gets the last.
    free_meshes: Vec<u32>,
    free_instances: Vec<u32>,
    /// A mesh without triangles, once a mesh was removed: what numbers stand for that are free.
    nothing: Option<u32>,
    /// The mesh of all spheres, once there is one.
    sphere: Option<MeshIndex>,
    /// The places of transparency records in `mesh_data`, by mesh and material.
    transparencies: BTreeMap<(u32, u32), u32>,
    /// The instances that show lights, by the number of the light.
    shown: BTreeMap<u32, u32>,
    lights: Vec<Light>,
    /// Counts what may have changed the lights.
    light_changes: u32,
    sky: Sky,
    see_through: AlphaKind,
    /// The bounds of the instances, and which of them have moved.
    places: Places,
    /// What rays ask of the instances.
    tags: Vec<Tag>,
    /// The levels of detail of instances that have any.
    pub(super) levels: BTreeMap<u32, Vec<LodLevel>>,
    /// How mip levels are chosen.
    pub mip: Mip,
    /// The structure that limits the instances a ray is tested against.
    pub structure: Structure,
    /// Which instances cast shadows of suns.
    pub occluders: Occluders,
    /// Ambient light, linear RGB; an environment replaces it.
    pub ambient: Vec3,
    /// How far the environment is turned around y, radians: a ray toward `d` sees what it had toward
    /// `d` turned by this from z toward x, so that at 90° it sees toward z what was toward x.
    pub environment_rotation: f32,
    /// What the environment's light is multiplied by, 0 to 2³².
    pub environment_intensity: f32,
    /// How blurred the environment is behind all surfaces, 0 to 1; surfaces reflect it in each case.
    pub environment_blur: f32,
    /// What the light of the environment is multiplied by where it is the background, on top of its intensity: 0 to 65,536.
    /// Surfaces reflect it and are lit by it all the same.
    pub backdrop_strength: f32,
    /// The color behind all surfaces, linear RGB. It is the color of pixels, neither exposed nor tone mapped.
    pub background: Vec3,
    /// Whether an environment, the background's color or nothing is behind all surfaces. Surfaces reflect
    /// the environment in each case.
    pub backdrop: Backdrop,
}

/// A number that no other call in this process returns. On a processor without compare-and-swap, callers
/// must not interrupt each other.
fn unique_id() -> u32 {
    static NEXT: AtomicU32 = AtomicU32::new(0);
    #[cfg(target_has_atomic = "32")]
    return NEXT.fetch_add(1, Ordering::Relaxed);
    #[cfg(not(target_has_atomic = "32"))]
    {
        let id = NEXT.load(Ordering::Relaxed);
        NEXT.store(id.wrapping_add(1), Ordering::Relaxed);
        id
    }
}

impl Default for Scene {
    fn default() -> Self {
        Self::new()
    }
}

impl Scene {
    /// An empty scene: no instances, no lights, faint ambient light, a dark background.
    pub fn new() -> Self {
        Self {
            identity: Identity::new(),
            versions: Versions::default(),
            nodes: vec![],
            mesh_data: vec![],
            sources: vec![],
            positions: vec![],
            attributes: vec![],
            // So that no texture begins at 0.
            texels: vec![0],
            materials: vec![],
            material_records: vec![],
            instances: vec![],
            object_meshes: vec![],
            meshes: vec![],
            free_meshes: vec![],
            free_instances: vec![],
            nothing: None,
            sphere: None,
            transparencies: BTreeMap::new(),
            shown: BTreeMap::new(),
            lights: vec![],
            light_changes: 0,
            sky: Sky::default(),
            see_through: AlphaKind::Opaque,
            places: Places::default(),
            tags: vec![],
            levels: BTreeMap::new(),
            mip: Mip::default(),
            structure: Structure::default(),
            occluders: Occluders::default(),
            ambient: Vec3::splat(0.1),
            background: Vec3::new(0.02, 0.025, 0.035),
            environment_rotation: 0.0,
            environment_intensity: 1.0,
            environment_blur: 0.0,
            backdrop_strength: 1.0,
            backdrop: Backdrop::default(),
        }
    }

    /// Places a mesh in the world. `to_world` takes instance to world space.
    ///
    /// # Errors
    /// The transform cannot be inverted, the instance would be out of range, or an index is
    /// of another scene.
    pub fn add_instance(
        &mut self,
        mesh: MeshIndex,
        material: MaterialIndex,
        to_world: Mat4,
    ) -> Result<InstanceIndex, SceneError> {
        let mut instance = place(self.indexed_mesh(mesh)?, self.instance_material(material)?, to_world)?;
        instance.transparency = self.transparency(mesh.number, material.number)?;
        let number = match self.free_instances.pop() {
            Some(number) => {
                let index = number as usize;
                (self.instances[index], self.object_meshes[index]) = (instance, mesh.number);
                self.tags[index] = self.tags[index].next();
                self.moved([index]);
                number
            }
            None => {
                self.places.push(&Bounds { low: instance.low, high: instance.high });
                self.versions.instances += 1;
                self.instances.push(instance);
                self.object_meshes.push(mesh.number);
                self.tags.push(Tag::default());
                self.instances.len() as u32 - 1
            }
        };
        Ok(self.numbered(number))
    }

    /// Adds a sphere: that of radius 1 around the origin, placed in the world by a matrix, which
    /// may make an ellipsoid of it. It is round however close one looks, and can be moved and
    /// hidden like any instance.
    ///
    /// Its texture coordinates are longitude and latitude: the middle of a texture is at `+z` of
    /// its space, the upper edge at `+y`. It has no vertex colors, and normal maps do nothing.
    ///
    /// ```
    /// # use rtrt_core::scene::{Material, Scene};
    /// use glam::{Mat4, Quat, Vec3};
    /// # let mut scene = Scene::new();
    /// let red = scene.add_material(Material::new([0.8, 0.1, 0.1]).roughness(0.4))?;
    /// let (center, radius) = (Vec3::new(0.0, 2.0, -1.0), 0.5);
    /// let place = Mat4::from_scale_rotation_translation(Vec3::splat(radius), Quat::IDENTITY, center);
    /// scene.add_sphere(red, place)?;
    /// assert_eq!(scene.extent(), Some((center - radius, center + radius)));
    /// # Ok::<(), rtrt_core::scene::SceneError>(())
    /// ```
    ///
    /// # Errors
    /// As for [`Scene::add_instance`].
    pub fn add_sphere(
        &mut self,
        material: MaterialIndex,
        to_world: Mat4,
    ) -> Result<InstanceIndex, SceneError> {
        let mesh = match self.sphere {
            Some(mesh) => mesh,
            None => {
                let shape = Mesh::around_sphere();
                let mesh = self.add_mesh(&shape, &Bvh::build(&shape, &Sequential))?;
                self.meshes[mesh.number as usize].kind = Kind::Sphere;
                *self.sphere.insert(mesh)
            }
        };
        self.add_instance(mesh, material, to_world)
    }

    /// Shows a light as a sphere of its color, where it is and as large as its radius says. It
    /// casts shadows of other lights only. Another call moves the sphere to the light's present position. A
    /// sun and a light with radius 0 have no sphere: the result is then `None`.
    ///
    /// # Errors
    /// There is no such light, or it is out of range.
    pub fn show_light(&mut self, light: usize) -> Result<Option<InstanceIndex>, SceneError> {
        let number = light as u32;
        let shown = self.shown.get(&number).map(|&number| self.numbered(number));
        let missing = SceneError::Index { what: "light", index: number };
        let Light { kind, position, color, radius, .. } = *self.lights.get(light).ok_or(missing)?;
        if kind == LightKind::Sun || radius <= 0.0 {
            shown.map_or(Ok(()), |sphere| self.hide(sphere))?;
            return Ok(None);
        }
        let place = Mat4::from_translation(position) * Mat4::from_scale(Vec3::splat(radius));
        if let Some(sphere) = shown {
            self.set_transform(sphere, place)?;
            return Ok(Some(sphere));
        }
        // Far beyond white: a light with an inverse square is brighter than any surface.
        let color = color.clamp(Vec3::splat(-COLOR_LIMIT), Vec3::splat(COLOR_LIMIT));
        let glow = self.add_material(Material::new(color).unlit(true))?;
        let sphere = self.add_sphere(glow, place)?;
        self.shown.insert(number, sphere.number);
        self.instances[sphere.number as usize].kind = Kind::Light as u32 + number;
        Ok(Some(sphere))
    }

    /// The instance with a number, such as [`Hit::instance`](crate::layout::Hit::instance); `None`
    /// where there is none.
    pub fn instance_index(&self, number: u32) -> Option<InstanceIndex> {
        self.tags.get(number as usize).filter(|tag| tag.is_live()).map(|_| self.numbered(number))
    }

    /// The index of what is at a place.
    pub(crate) fn numbered(&self, number: u32) -> InstanceIndex {
        InstanceIndex { number, generation: self.tags[number as usize].generation, scene: self.family() }
    }

    /// The index of an instance in the arrays.
    pub(super) fn instance(&self, instance: InstanceIndex) -> Result<usize, SceneError> {
        let missing = SceneError::Index { what: "instance", index: instance.number };
        let is_here = self.instance_index(instance.number) == Some(instance);
        if is_here { Ok(instance.number as usize) } else { Err(missing) }
    }

    /// Sets the groups that an instance belongs to, one a bit: a [`Ray`](crate::query::Ray) meets it if their
    /// masks have a bit in common. At first all bits are set. Pictures do not depend on it.
    ///
    /// # Errors
    /// There is no such instance.
    pub fn set_ray_mask(&mut self, instance: InstanceIndex, mask: u32) -> Result<(), SceneError> {
        let index = self.instance(instance)?;
        self.tags[index].mask = mask;
        // Trees keep it.
        let bounds = *self.places.bounds(index);
        self.places.set(index, &bounds);
        self.places.update();
        Ok(())
    }

    /// Sets a number that means something to the caller, and that queries return; at first 0.
    ///
    /// # Errors
    /// There is no such instance.
    pub fn set_user_data(&mut self, instance: InstanceIndex, user: u32) -> Result<(), SceneError> {
        let index = self.instance(instance)?;
        self.tags[index].user = user;
        Ok(())
    }

    pub(super) fn mesh(&self, index: u32) -> Result<&Stored, SceneError> {
        self.meshes.get(index as usize).ok_or(SceneError::Index { what: "mesh", index })
    }

    /// The mesh with this index.
    pub(super) fn indexed_mesh(&self, mesh: MeshIndex) -> Result<&Stored, SceneError> {
        let missing = SceneError::Index { what: "mesh", index: mesh.number };
        let is_here = |stored: &&Stored| (mesh.scene, mesh.generation) == (self.family(), stored.generation);
        self.mesh(mesh.number).ok().filter(is_here).ok_or(missing)
    }

    /// Takes the places of these instances over.
    pub(super) fn moved(&mut self, instances: impl IntoIterator<Item = usize>) {
        self.versions.instances += 1;
        for index in instances {
            let bounds = self.seen_bounds(index);
            self.places.set(index, &bounds);
        }
        self.places.update();
    }

    /// The world bounds of an instance; empty if it is hidden.
    fn seen_bounds(&self, index: usize) -> Bounds {
        let Instance { low, high, .. } = self.instances[index];
        if self.is_seen(index) { Bounds { low, high } } else { Bounds::EMPTY }
    }

    /// Whether an instance is not hidden.
    pub(super) fn is_seen(&self, index: usize) -> bool {
        self.instances[index].root == self.meshes[self.object_meshes[index] as usize].root
    }

    /// Adds a light.
    pub fn add_light(&mut self, light: Light) {
        self.lights_mut().push(light);
    }
    /// The lights.
    pub fn lights(&self) -> &[Light] {
        &self.lights
    }
    /// The lights, to be changed.
    pub fn lights_mut(&mut self) -> &mut Vec<Light> {
        self.light_changes += 1;
        &mut self.lights
    }

    /// A number that changes with the lights.
    pub(super) fn light_changes(&self) -> u32 {
        self.light_changes
    }

    /// A number that no other scene of this process has.
    pub fn id(&self) -> u32 {
        self.identity.own
    }
    /// [`Identity::family`].
    pub(crate) fn family(&self) -> u32 {
        self.identity.family
    }
    /// The number of changes of each part.
    pub fn versions(&self) -> Versions {
        self.versions
    }
    /// Nodes of all BVHs.
    pub fn nodes(&self) -> &[Node] {
        bytemuck::cast_slice(&self.nodes)
    }
    /// The data of all meshes besides vertices: vertex indices, three a triangle, in the order of the BVH's
    /// leaves; packed tangents; second texture coordinates; and the transparency records of instances.
    pub fn mesh_data(&self) -> &[u32] {
        &self.mesh_data
    }
    /// Vertex positions of all meshes, object space.
    pub fn positions(&self) -> &[[f32; 3]] {
        &self.positions
    }
    /// Vertex attributes of all meshes.
    pub fn attributes(&self) -> &[Attribute] {
        &self.attributes
    }
    /// The decoding words, then the mip chains of all textures and the squares of the
    /// environment.
    pub fn texels(&self) -> &[u32] {
        &self.texels
    }
    /// The materials, and the texels of their textures.
    pub fn maps(&self) -> Maps<'_> {
        Maps { materials: &self.material_records, texels: &self.texels }
    }
    /// The instances.
    pub fn instances(&self) -> &[Instance] {
        &self.instances
    }
    /// The world bounds of all instances but hidden ones: lower and upper corner, or none without
    /// instances.
    pub fn extent(&self) -> Option<(Vec3, Vec3)> {
        let bounds = self.places.all();
        (!bounds.is_empty()).then(|| (Vec3::from(bounds.low), Vec3::from(bounds.high)))
    }
    /// The world bounds of all instances; a point without instances.
    pub(super) fn bounds(&self) -> Bounds {
        let bounds = self.places.all();
        if bounds.is_empty() { Bounds { low: [0.0; 3], high: [0.0; 3] } } else { bounds }
    }
    /// The meshes.
    pub(crate) fn stored_meshes(&self) -> &[Stored] {
        &self.meshes
    }
    /// The mesh of each instance.
    pub(crate) fn mesh_numbers(&self) -> &[u32] {
        &self.object_meshes
    }
    /// Where the instances are.
    pub(crate) fn places(&self) -> &Places {
        &self.places
    }
    /// What rays ask of the instances.
    pub(crate) fn tags(&self) -> &[Tag] {
        &self.tags
    }
    /// The material with a number.
    pub(crate) fn material_index(&self, number: u32) -> MaterialIndex {
        MaterialIndex { number, scene: self.family() }
    }
    /// The place of the environment in the texels.
    pub(super) fn sky(&self) -> Sky {
        self.sky
    }
    /// Whether a material needs the stage `detail`.
    pub(super) fn has_details(&self) -> bool {
        let asks = |m: &MaterialRecord| {
            m.textures[MaterialRecord::NORMAL].levels > 0
                || m.extensions & (MaterialRecord::HAS_COAT | MaterialRecord::IS_BRUSHED) != 0
                || m.textures.iter().any(|t| t.levels > 0 && t.set > 0)
        };
        self.material_records.iter().any(asks)
    }
    /// What any of the materials has beyond metallic-roughness.
    pub(super) fn extensions(&self) -> u32 {
        self.material_records.iter().fold(0, |all, material| all | material.extensions)
    }
    /// The most general alpha mode of all instances.
    pub(super) fn see_through(&self) -> AlphaKind {
        self.see_through
    }
    /// The number of a triangle of an instance in its [`Mesh`]: a scene numbers triangles in the order of
    /// the BVH's leaves. `None` if there is no such triangle. For an instance with levels of detail, the
    /// triangle is one of its own mesh.
    pub fn source_triangle(&self, instance: InstanceIndex, triangle: u32) -> Option<u32> {
        let index = self.instance(instance).ok()?;
        let mesh = &self.meshes[self.object_meshes[index] as usize];
        let sources = &self.sources[mesh.first_source..][..mesh.triangles as usize];
        sources.get(triangle as usize).copied()
    }
    /// Triangles stored.
    pub fn triangles(&self) -> u64 {
        self.meshes.iter().map(|m| u64::from(m.triangles)).sum()
    }
    /// Triangles of all instances: those of a mesh count once for each instance.
    pub fn drawn_triangles(&self) -> u64 {
        let live = self.object_meshes.iter().zip(&self.tags).filter(|(_, tag)| tag.is_live());
        live.map(|(&mesh, _)| u64::from(self.meshes[mesh as usize].triangles)).sum()
    }
    /// Bytes of all arrays.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.nodes[..])
            + size_of_val(&self.mesh_data[..])
            + size_of_val(&self.sources[..])
            + size_of_val(&self.positions[..])
            + size_of_val(&self.instances[..])
            + size_of_val(&self.attributes[..])
            + size_of_val(&self.texels[..])
            + size_of_val(&self.material_records[..])
    }
    /// Bytes of vertices (position, normal, texture coordinates, color) and indices, as
    /// they were added. Tangents and second texture coordinates are not counted.
    pub fn source_bytes(&self) -> usize {
        let indices = 12 * self.triangles() as usize;
        size_of_val(&self.positions[..]) + size_of_val(&self.attributes[..]) + indices
    }
}

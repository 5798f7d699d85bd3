//! What a world is made of: a scene, or shapes of the caller's.

use crate::kernel::geometry::Geometry;
use crate::kernel::transparency::{alpha_mode, passes_mask, tint_and_alpha};
use crate::kernel::triangle::Intersection;
use crate::layout::{AlphaKind, Attribute, Instance, Node};
use crate::scene::{InstanceIndex, MaterialIndex, Places, Scene, Tag};

/// What a [`Tree`](super::Tree) can be made of: a [`Scene`], or [`Shapes`](super::Shapes).
pub trait Source: Parts {}

impl<S: Parts> Source for S {}

/// What has had the number of a mesh so far, and how many shapes that had.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MeshVersion {
    pub generation: u32,
    pub shape: u32,
}

/// The nodes of a mesh, and what changes with them.
#[derive(Debug, Clone, Copy)]
pub struct MeshNodes<'a> {
    pub nodes: &'a [Node],
    pub version: MeshVersion,
}

/// What queries read.
pub trait Parts {
    /// A number that no other source has.
    fn id(&self) -> u32;
    /// [`Identity::family`](crate::scene::Identity::family).
    fn family(&self) -> u32;
    /// The number of meshes.
    fn meshes(&self) -> usize;
    /// Another number once meshes were added or removed, or have another shape.
    fn mesh_changes(&self) -> u32;
    /// The nodes of one of them.
    fn nodes(&self, mesh: usize) -> MeshNodes<'_>;
    /// All instances.
    fn instances(&self) -> &[Instance];
    /// The mesh of one of them.
    fn mesh_of(&self, instance: usize) -> usize;
    /// Their bounds and moves.
    fn places(&self) -> &Places;
    /// Their tags.
    fn tags(&self) -> &[Tag];
    /// The corners of a triangle of a mesh, object space.
    fn mesh_triangle(&self, mesh: usize, triangle: u32) -> [[f32; 3]; 3];
    /// The vertices at the corners of a triangle of an instance.
    fn corners(&self, instance: &Instance, triangle: u32) -> [u32; 3];
    /// The position of a vertex, object space.
    fn position(&self, instance: &Instance, vertex: u32) -> [f32; 3];
    /// The attributes of a vertex, if it has any.
    fn attribute(&self, vertex: u32) -> Option<Attribute>;
    /// Whether the hit is in a hole that a mask cuts.
    fn is_hole(&self, instance: u32, triangle: u32, intersection: &Intersection<f32>) -> bool;
    /// The material of an instance, if it has any.
    fn material(&self, instance: &Instance) -> Option<MaterialIndex>;
    /// The number that the triangle had when its mesh was added.
    fn source_triangle(&self, instance: usize, triangle: u32) -> u32;
    /// The index of the instance with a number.
    #[inline(always)]
    fn numbered(&self, number: u32) -> InstanceIndex {
        InstanceIndex { number, generation: self.tags()[number as usize].generation, scene: self.family() }
    }
    /// The place of an instance in the arrays, if it is one of this source.
    #[inline(always)]
    fn place_of(&self, instance: InstanceIndex) -> Option<usize> {
        let index = instance.number as usize;
        let tag = self.tags().get(index)?;
        let is_here = tag.is_live() && self.numbered(instance.number) == instance;
        is_here.then_some(index)
    }
}

impl Parts for Scene {
    fn id(&self) -> u32 {
        self.id()
    }
    fn family(&self) -> u32 {
        self.family()
    }
    fn meshes(&self) -> usize {
        self.stored_meshes().len()
    }
    fn mesh_changes(&self) -> u32 {
        self.versions().geometry
    }
    fn nodes(&self, mesh: usize) -> MeshNodes<'_> {
        let mesh = &self.stored_meshes()[mesh];
        let nodes = &self.nodes()[mesh.root as usize..][..mesh.nodes as usize];
        let version = MeshVersion { generation: mesh.generation, shape: mesh.shape_version };
        MeshNodes { nodes, version }
    }
    #[inline(always)]
    fn instances(&self) -> &[Instance] {
        self.instances()
    }
    #[inline(always)]
    fn mesh_of(&self, instance: usize) -> usize {
        self.mesh_numbers()[instance] as usize
    }
    #[inline(always)]
    fn places(&self) -> &Places {
        self.places()
    }
    #[inline(always)]
    fn tags(&self) -> &[Tag] {
        self.tags()
    }
    fn mesh_triangle(&self, mesh: usize, triangle: u32) -> [[f32; 3]; 3] {
        let mesh = &self.stored_meshes()[mesh];
        let vertices = &self.mesh_data()[(mesh.first_index + 3 * triangle) as usize..][..3];
        [0, 1, 2].map(|corner| self.positions()[(mesh.first_vertex + vertices[corner]) as usize])
    }
    fn corners(&self, instance: &Instance, triangle: u32) -> [u32; 3] {
        instance.corners(self.mesh_data(), triangle)
    }
    fn position(&self, _: &Instance, vertex: u32) -> [f32; 3] {
        self.positions()[vertex as usize]
    }
    fn attribute(&self, vertex: u32) -> Option<Attribute> {
        self.attributes().get(vertex as usize).copied()
    }
    fn is_hole(&self, instance: u32, triangle: u32, intersection: &Intersection<f32>) -> bool {
        let placed = &self.instances()[instance as usize];
        if alpha_mode(placed, self.mesh_data()) != AlphaKind::Mask as u32 {
            return false;
        }
        let geometry = Geometry {
            instances: self.instances(),
            nodes: self.nodes(),
            mesh_data: self.mesh_data(),
            positions: self.positions(),
            texels: self.texels(),
            magnitude: 0.0,
        };
        let [_, _, _, alpha] = tint_and_alpha(&geometry, instance, triangle, intersection);
        !passes_mask(&geometry, instance, alpha)
    }
    fn material(&self, instance: &Instance) -> Option<MaterialIndex> {
        Some(self.material_index(instance.material))
    }
    fn source_triangle(&self, instance: usize, triangle: u32) -> u32 {
        self.instance_index(instance as u32)
            .and_then(|instance| Scene::source_triangle(self, instance, triangle))
            .unwrap_or(triangle)
    }
}

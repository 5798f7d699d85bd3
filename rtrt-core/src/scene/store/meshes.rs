//! Meshes in the scene's arrays: nodes, vertices, mesh data.

use super::{MeshIndex, Pair, Scene, SceneError};
use crate::layout::{Kind, Node};
use crate::scene::bvh::Bounds;
use crate::scene::place::{Stored, sphere};
use crate::scene::{Bvh, Mesh};
use alloc::vec;
use alloc::vec::Vec;
use bytemuck::Zeroable;

impl Scene {
    /// Adds a mesh with its BVH. Any number of instances share it.
    ///
    /// # Errors
    /// The tree is not one of the mesh, or the scene is full.
    pub fn add_mesh(&mut self, mesh: &Mesh, tree: &Bvh) -> Result<MeshIndex, SceneError> {
        tree.check(mesh)?;
        let room = |have: usize, more: usize, what| {
            if have + more > u32::MAX as usize / 4 {
                Err(SceneError::TooLarge { what })
            } else {
                Ok(have as u32)
            }
        };
        // Vertices in the order in which the leaves use them; unused ones are dropped.
        let mut order = Order::new(mesh.positions().len());
        let mut indices = Vec::with_capacity(mesh.indices().len());
        for &triangle in &tree.triangles {
            let corners = &mesh.indices()[3 * triangle as usize..][..3];
            indices.extend(corners.iter().map(|&vertex| order.place(vertex)));
        }
        let vertices = || order.vertices.iter().map(|&vertex| vertex as usize);
        let used = |all: usize| if all == 0 { 0 } else { order.vertices.len() };
        let (tangents, second_uv) = (used(mesh.tangents().len()), used(mesh.second_uv().len()));
        let words = indices.len() + tangents + 2 * second_uv;
        let first_index = room(self.mesh_data.len(), words, "triangles")?;
        let root = tree.nodes[0];
        let bounds = Bounds::around(&root);
        let (center, radius) = sphere(mesh.positions(), &bounds);
        // The start of `count` elements after `before` words; 0 for none.
        let after = |before: usize, count: usize| if count == 0 { 0 } else { first_index + before as u32 };
        let stored = Stored {
            kind: Kind::Mesh,
            root: 1 + room(2 * self.nodes.len(), 1 + tree.nodes.len(), "nodes")?,
            first_vertex: room(self.positions.len(), order.vertices.len(), "vertices")?,
            first_index,
            first_tangent: after(indices.len(), tangents),
            first_second_uv: after(indices.len() + tangents, second_uv),
            first_source: self.sources.len(),
            nodes: tree.nodes.len() as u32,
            vertices: order.vertices.len() as u32,
            transparencies: [0; 2],
            shape_version: 0,
            generation: 0,
            triangles: mesh.triangles() as u32,
            bounds,
            center,
            radius,
        };
        // The node beside the root is the start of hidden instances.
        self.nodes.push(Pair([Node { kind: 3, ..Node::zeroed() }, root]));
        self.nodes.extend(tree.nodes[1..].chunks_exact(2).map(|pair| Pair([pair[0], pair[1]])));
        self.mesh_data.extend_from_slice(&indices);
        if tangents > 0 {
            self.mesh_data.extend(vertices().map(|vertex| mesh.tangents()[vertex]));
        }
        if second_uv > 0 {
            self.mesh_data.extend(vertices().flat_map(|vertex| mesh.second_uv()[vertex].map(f32::to_bits)));
        }
        self.positions.extend(vertices().map(|vertex| mesh.positions()[vertex]));
        self.attributes.extend(vertices().map(|vertex| mesh.attributes()[vertex]));
        self.sources.extend_from_slice(&tree.triangles);
        self.versions.geometry += 1;
        let (number, generation) = match self.free_meshes.pop() {
            Some(number) => (number, self.meshes[number as usize].generation.wrapping_add(1)),
            None => {
                self.meshes.push(stored);
                (self.meshes.len() as u32 - 1, 0)
            }
        };
        self.meshes[number as usize] = Stored { generation, ..stored };
        Ok(MeshIndex { number, generation, scene: self.family() })
    }
}

/// Numbers vertices in the order in which they are first used.
struct Order {
    /// The new number of each, or `u32::MAX`.
    places: Vec<u32>,
    /// The old number of each.
    vertices: Vec<u32>,
}

impl Order {
    fn new(count: usize) -> Self {
        Self { places: vec![u32::MAX; count], vertices: Vec::with_capacity(count) }
    }

    /// The new number of a vertex.
    fn place(&mut self, vertex: u32) -> u32 {
        let place = &mut self.places[vertex as usize];
        if *place == u32::MAX {
            *place = self.vertices.len() as u32;
            self.vertices.push(vertex);
        }
        *place
    }
}

//! What rays are tested against.

use crate::kernel::triangle::Triangle;
use crate::layout::{Instance, Node};

/// Everything that a ray can hit.
#[derive(Clone, Copy)]
pub struct Geometry<'a> {
    /// Instances, placed in the world.
    pub instances: &'a [Instance],
    /// Nodes of all BVHs.
    pub nodes: &'a [Node],
    /// Vertex indices of all meshes, three a triangle, in the order of their BVHs' leaves; after
    /// them, tangents, second texture coordinates and transparency records.
    pub mesh_data: &'a [u32],
    /// Vertex positions, object space.
    pub positions: &'a [[f32; 3]],
    /// Texels, for filters that look up transparency; any words for the others.
    pub texels: &'a [u32],
    /// The frame's magnitude (see [`crate::layout::Frame`]).
    pub magnitude: f32,
}

impl Geometry<'_> {
    /// The vertices at the corners of a triangle of the instance's mesh.
    #[inline(always)]
    pub fn corners(&self, instance: &Instance, triangle: u32) -> [u32; 3] {
        instance.corners(self.mesh_data, triangle)
    }

    /// A triangle of the instance's mesh, object space.
    #[inline(always)]
    pub fn triangle(&self, instance: &Instance, triangle: u32) -> Triangle {
        let [a, b, c] = self.corners(instance, triangle);
        Triangle::new(self.positions[a as usize], self.positions[b as usize], self.positions[c as usize])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    #[test]
    fn a_triangle_has_the_vertices_of_its_mesh() {
        // Another mesh of one triangle and two vertices comes first.
        let mesh_data = [0, 1, 0, 0, 1, 2, 2, 1, 3];
        let positions = [9.0, 9.0, 0.0, 1.0, 2.0, 3.0].map(|x: f32| [x, 10.0 * x, 0.0]);
        let instance = Instance { first_index: 3, first_vertex: 2, triangles: 2, ..Instance::zeroed() };
        let instances = [instance];
        let geometry = Geometry {
            instances: &instances,
            nodes: &[],
            mesh_data: &mesh_data,
            positions: &positions,
            texels: &[],
            magnitude: 1.0,
        };
        assert_eq!(geometry.corners(&instance, 1), [4, 3, 5]);
        assert_eq!(geometry.triangle(&instance, 0).corners, [0.0, 1.0, 2.0].map(|x: f32| [x, 10.0 * x, 0.0]));
    }
}

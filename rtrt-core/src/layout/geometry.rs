//! Meshes, their BVHs, and the instances that place them in the world.

use crate::layout::NONE;
use bytemuck::{Pod, Zeroable};
use core::mem::offset_of;

/// One node of a BVH: a box, and its children or triangles.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Node {
    /// Lower corner, object space.
    pub low: [f32; 3],
    /// Inside: the first of two neighboring children, counted from the mesh's root.
    /// A leaf: the first of its triangles, which are numbered in the order of the leaves.
    pub first: u32,
    /// Upper corner, object space.
    pub high: [f32; 3],
    /// Inside: the axis (0, 1, 2) that separates the children, the first one lower.
    /// A leaf: `4 · triangles + 3`.
    pub kind: u32,
}
const _: () = assert!(size_of::<Node>() == 32 && offset_of!(Node, high) == 16);

impl Node {
    /// Lower and upper corner of its box, wider by so much on each side.
    #[inline(always)]
    pub(crate) fn widened(&self, by: f32) -> ([f32; 3], [f32; 3]) {
        let (low, high) = (&self.low, &self.high);
        ([low[0] - by, low[1] - by, low[2] - by], [high[0] + by, high[1] + by, high[2] + by])
    }

    /// Whether the node holds triangles.
    #[inline(always)]
    pub(crate) fn is_leaf(&self) -> bool {
        self.kind & 3 == 3
    }
    /// How many triangles a leaf holds.
    #[inline(always)]
    pub fn triangles(&self) -> u32 {
        self.kind >> 2
    }
}

/// The attributes of a vertex, interpolated across a triangle.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Attribute {
    /// Object space; any length.
    pub normal: [f32; 3],
    /// Texture coordinates, `v` pointing down.
    pub uv: [f32; 2],
    /// Linear RGBA, 16 bits each: red and green, blue and alpha, each time the first in the low half.
    pub color: [u32; 2],
}
const _: () = assert!(size_of::<Attribute>() == 28 && offset_of!(Attribute, color) == 20);

impl Attribute {
    /// The [color](Self::color) that leaves material and texture as they are.
    pub const WHITE: [u32; 2] = [u32::MAX; 2];

    /// Linear RGBA of 0 ..= 1 as a [color](Self::color); numbers outside are clamped, NaN becomes 1. A number between two
    /// steps becomes the upper one, so that the middle between two bytes of sRGB does not fall below it.
    pub fn pack_color(rgba: [f32; 4]) -> [u32; 2] {
        let [r, g, b, a] = rgba.map(|x| if x < 1.0 { (x.max(0.0) * 65535.0 + 0.99) as u32 } else { 65535 });
        [r | g << 16, b | a << 16]
    }
}

/// The kind of an instance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Kind {
    /// A mesh.
    Mesh = 0,
    /// The sphere of radius 1 around the origin of its space, with two triangles: 0 where a ray
    /// enters, 1 where it leaves (see [`crate::kernel::sphere`]).
    Sphere = 1,
    /// This value and larger ones: a sphere that shows light number `kind − Kind::Light`. It casts no shadow
    /// of that light.
    Light = 2,
}

/// A mesh, or a sphere, placed in the world: three cache lines. The first has what decides whether rays come near.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Instance {
    /// Lower corner of the bounds, world space.
    pub low: [f32; 3],
    /// Bound on the rounding error of culling with the bounds, relative to the frame's magnitude.
    pub slack: f32,
    /// Upper corner of the bounds.
    pub high: [f32; 3],
    /// The node, in the scene's nodes, where traversal starts: the root, or the node of a part.
    pub start: u32,
    /// The instance that this is a part of; [`NONE`] for a whole instance.
    pub opened_from: u32,
    /// [`Kind`]. A sphere's mesh has two triangles without area that span its bounds.
    pub kind: u32,
    /// Where the instance's [`Transparency`](crate::layout::Transparency) is in the scene's mesh data; 0 for an
    /// instance that is opaque everywhere.
    pub transparency: u32,
    /// 1 where it is seen from both sides, else 0 (see
    /// [`MaterialRecord::double_sided`](crate::layout::MaterialRecord::double_sided)).
    pub double_sided: u32,
    /// 1 where object and world space are the same, else 0.
    pub is_identity: u32,
    /// The mesh's root in the scene's nodes.
    pub root: u32,
    /// The mesh's triangles.
    pub triangles: u32,
    /// The material, in the scene's materials.
    pub material: u32,
    /// World to object space, three rows: `m` and, last in each, a coordinate of the object's place `o` (the last
    /// column of `to_world`). A point `p` goes to `m · (p − o)`.
    pub to_object: [[f32; 4]; 3],
    /// The mesh's first vertex in the scene's positions and attributes.
    pub first_vertex: u32,
    /// The start of the mesh's vertex indices, three a triangle, in the scene's mesh data.
    pub first_index: u32,
    /// The start of the mesh's packed tangents, one a vertex, in the scene's mesh data; 0 for none.
    pub first_tangent: u32,
    /// The start of the mesh's second texture coordinates, two words a vertex, in the scene's mesh data; 0
    /// for none.
    pub first_second_uv: u32,
    /// Object to world space, three rows.
    pub to_world: [[f32; 4]; 3],
    /// Center of the bounding sphere, world space.
    pub center: [f32; 3],
    /// Radius of the bounding sphere.
    pub radius: f32,
}
const _: () = assert!(size_of::<Instance>() == 192 && offset_of!(Instance, high) == 16);
const _: () = assert!(offset_of!(Instance, to_object) == 64 && offset_of!(Instance, to_world) == 128);
const _: () = assert!(offset_of!(Instance, center) == 176);

impl Instance {
    /// The whole instance: `number` itself, or the instance that this is a part of.
    #[inline(always)]
    pub(crate) fn source_instance(&self, number: u32) -> u32 {
        if self.opened_from == NONE { number } else { self.opened_from }
    }
    /// Whether it has the same triangles as another one, in the same place, with the same sides, alpha and lists.
    #[inline(always)]
    pub(crate) fn is_copy_of(&self, other: &Self) -> bool {
        let is_like = self.start == other.start
            && self.low[0] == other.low[0]
            && self.low[1] == other.low[1]
            && self.low[2] == other.low[2]
            && self.kind == other.kind
            && self.transparency == other.transparency
            && self.double_sided == other.double_sided;
        let mut row = 0;
        let mut is_same = is_like;
        while is_same && row < 3 {
            let (own, others) = (&self.to_world[row], &other.to_world[row]);
            is_same =
                own[0] == others[0] && own[1] == others[1] && own[2] == others[2] && own[3] == others[3];
            row += 1;
        }
        is_same
    }

    /// Whether it shows this light.
    #[inline(always)]
    pub fn shows(&self, light: u32) -> bool {
        self.kind == Kind::Light as u32 + light
    }
    /// Whether it is a sphere.
    #[inline(always)]
    pub fn is_sphere(&self) -> bool {
        self.kind != Kind::Mesh as u32
    }
    /// The vertices at the corners of a triangle of the instance's mesh; `mesh_data` are the
    /// scene's.
    #[inline(always)]
    pub fn corners(&self, mesh_data: &[u32], triangle: u32) -> [u32; 3] {
        let first = (self.first_index + 3 * triangle) as usize;
        let base = self.first_vertex;
        [base + mesh_data[first], base + mesh_data[first + 1], base + mesh_data[first + 2]]
    }
    /// The bounds, padded by the rounding error of a frame of this magnitude: a ray that hits the instance
    /// in object space hits them in world space.
    #[inline(always)]
    pub fn padded_aabb(&self, magnitude: f32) -> ([f32; 3], [f32; 3]) {
        let (low, high) = (&self.low, &self.high);
        let by = self.slack * magnitude;
        ([low[0] - by, low[1] - by, low[2] - by], [high[0] + by, high[1] + by, high[2] + by])
    }
}

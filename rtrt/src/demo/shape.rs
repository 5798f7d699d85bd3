//! The shapes of the demo.

use crate::import::geometry::Geometry;
use glam::Vec3;
use rtrt_core::layout::Attribute;

/// A mesh that is being built.
#[derive(Default)]
pub(super) struct Shape(pub Geometry);

impl Shape {
    fn vertex(&mut self, position: Vec3, normal: Vec3, uv: [f32; 2]) -> u32 {
        self.0.positions.push(position.to_array());
        self.0.attributes.push(Attribute { normal: normal.to_array(), uv, color: Attribute::WHITE });
        self.0.positions.len() as u32 - 1
    }

    /// A parallelogram with the texture from `uv[0]` at `corner` to `uv[1]` opposite; `right`
    /// and `down` are its sides.
    pub fn quad(mut self, corner: Vec3, right: Vec3, down: Vec3, [from, to]: [[f32; 2]; 2]) -> Self {
        let a = self.vertex(corner, Vec3::ZERO, from);
        self.vertex(corner + right, Vec3::ZERO, [to[0], from[1]]);
        self.vertex(corner + right + down, Vec3::ZERO, to);
        self.vertex(corner + down, Vec3::ZERO, [from[0], to[1]]);
        self.0.indices.extend([a, a + 1, a + 2, a, a + 2, a + 3]);
        self
    }

    /// A parallelogram whose texture repeats every `unit` world units.
    pub fn tiled(self, corner: Vec3, right: Vec3, down: Vec3, unit: f32) -> Self {
        let uv = [libm::sqrtf(right.length_squared()), libm::sqrtf(down.length_squared())].map(|l| l / unit);
        self.quad(corner, right, down, [[0.0; 2], uv])
    }

    /// The six sides of a box, whose texture repeats every `unit` world units.
    pub fn cuboid(self, low: Vec3, high: Vec3, unit: f32) -> Self {
        let size = high - low;
        let (x, y, z) = (Vec3::X * size.x, Vec3::Y * size.y, Vec3::Z * size.z);
        self.tiled(low, x, z, unit)
            .tiled(low, x, y, unit)
            .tiled(low, z, y, unit)
            .tiled(high, -x, -z, unit)
            .tiled(high, -x, -y, unit)
            .tiled(high, -z, -y, unit)
    }

    /// A smooth surface around the y axis; its outline, from top to bottom, is given as
    /// radius and height, and its normals as the same.
    pub fn turned(mut self, center: Vec3, outline: &[[f32; 2]], normals: &[[f32; 2]]) -> Self {
        const SIDES: u32 = 32;
        let first = self.0.positions.len() as u32;
        for (&[radius, height], &[out, up]) in outline.iter().zip(normals) {
            for side in 0..=SIDES {
                let (sin, cos) = libm::sincosf(side as f32 * (core::f32::consts::TAU / SIDES as f32));
                let position = center + Vec3::new(radius * cos, height, radius * sin);
                self.vertex(position, Vec3::new(out * cos, up, out * sin), [0.0; 2]);
            }
        }
        for ring in 1..outline.len() as u32 {
            for side in 0..SIDES {
                let below = first + ring * (SIDES + 1) + side;
                let above = below - SIDES - 1;
                self.0.indices.extend([above, above + 1, below + 1, above, below + 1, below]);
            }
        }
        self
    }

    /// An ellipsoid with these half axes, the two horizontal ones alike.
    pub fn ellipsoid(self, center: Vec3, radius: f32, height: f32) -> Self {
        const RINGS: u32 = 16;
        let circle: Vec<[f32; 2]> = (0..=RINGS)
            .map(|ring| libm::sincosf(ring as f32 * (core::f32::consts::PI / RINGS as f32)).into())
            .collect();
        let outline: Vec<_> = circle.iter().map(|[out, up]| [out * radius, up * height]).collect();
        let normals: Vec<_> = circle.iter().map(|[out, up]| [out / radius, up / height]).collect();
        self.turned(center, &outline, &normals)
    }
}

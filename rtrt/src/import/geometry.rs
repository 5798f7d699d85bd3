//! The geometry of a mesh as a file gives it.

use rtrt_core::layout::Attribute;

/// Positions, attributes and indices of a mesh that is not checked yet.
#[derive(Debug, Clone, Default)]
pub(crate) struct Geometry {
    pub positions: Vec<[f32; 3]>,
    pub attributes: Vec<Attribute>,
    pub indices: Vec<u32>,
    pub second_uv: Option<Vec<[f32; 2]>>,
    pub tangents: Tangents,
    /// What changes its shape.
    pub deform: Deform,
}

/// The tangents of a mesh's vertices, which normal maps need.
#[derive(Debug, Clone, Default)]
pub(crate) enum Tangents {
    /// Nothing needs them.
    #[default]
    None,
    /// As the file has them.
    Given(Vec<[f32; 4]>),
    /// Made from texture coordinates.
    Made {
        /// Those of the second set.
        second: bool,
    },
}

/// The joints that a vertex hangs on, and how much each counts.
pub(crate) type JointWeights = ([u32; 4], [f32; 4]);

/// What changes the shape of a mesh.
#[derive(Debug, Clone, Default)]
pub(crate) struct Deform {
    /// What is added to positions, normals and tangents, as much as their weights say.
    pub targets: Vec<Target>,
    /// Four joints of the skin for each vertex, and how much each counts; none without a skin.
    pub joints: Vec<JointWeights>,
}

/// A morph target. Empty lists change nothing.
#[derive(Debug, Clone, Default)]
pub(crate) struct Target {
    pub positions: Vec<[f32; 3]>,
    pub normals: Vec<[f32; 3]>,
    pub tangents: Vec<[f32; 3]>,
}

impl Deform {
    /// The same data for a selection of vertices: vertex `i` of the result is `vertices[i]`.
    pub fn select(&self, vertices: &[u32]) -> Self {
        fn pick<T: Copy>(of: &[T], vertices: &[u32]) -> Vec<T> {
            vertices.iter().filter_map(|&i| of.get(i as usize).copied()).collect()
        }
        let target = |t: &Target| Target {
            positions: pick(&t.positions, vertices),
            normals: pick(&t.normals, vertices),
            tangents: pick(&t.tangents, vertices),
        };
        Self { targets: self.targets.iter().map(target).collect(), joints: pick(&self.joints, vertices) }
    }
}

/// A color as vertices have it: linear RGBA, 8 bits each; NaN is white.
pub(super) fn pack_color(color: [f32; 4]) -> u32 {
    let byte = |c: f32| if c.is_nan() { 255 } else { (c.clamp(0.0, 1.0) * 255.0 + 0.5) as u8 };
    u32::from_le_bytes(color.map(byte))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colors_are_rounded_and_clamped() {
        assert_eq!(pack_color([2.0, -1.0, 0.5, f32::NAN]), 0xff80_00ff);
    }
}

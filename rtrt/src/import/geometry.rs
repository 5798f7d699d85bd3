//! The geometry of a mesh as a file gives it.

use rtrt_core::layout::Attribute;

/// Positions, attributes and indices of a mesh, before they are checked.
#[derive(Debug, Clone, Default)]
pub(crate) struct Geometry {
    pub positions: Vec<[f32; 3]>,
    pub attributes: Vec<Attribute>,
    pub indices: Vec<u32>,
    pub second_uv: Option<Vec<[f32; 2]>>,
    pub tangents: Tangents,
    /// Morph targets and skin.
    pub deform: Deform,
}

/// The tangents of vertices, for normal maps.
#[derive(Debug, Clone, Default)]
pub(crate) enum Tangents {
    /// No normal map.
    #[default]
    None,
    /// From the file.
    Given(Vec<[f32; 4]>),
    /// Computed from texture coordinates.
    Made {
        /// Whether from the second set.
        second: bool,
    },
}

/// Four joints of a vertex, and their weights.
pub(crate) type JointWeights = ([u32; 4], [f32; 4]);

/// Morph targets and skin of a mesh.
#[derive(Debug, Clone, Default)]
pub(crate) struct Deform {
    /// The morph targets.
    pub targets: Vec<Target>,
    /// The joints of the skin. Each set has four joints for each vertex; there is no set without a skin.
    pub joint_sets: Vec<Vec<JointWeights>>,
}

/// A morph target: offsets of all vertices, multiplied by its weight. An empty list has no offsets.
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
        Self {
            targets: self.targets.iter().map(target).collect(),
            joint_sets: self.joint_sets.iter().map(|set| pick(set, vertices)).collect(),
        }
    }
}

//! Meshes that change their shape: morph targets and skins.

use super::ImportError;
use super::builder::Geometry;
use glam::{DMat4, DVec3};
use rtrt_core::layout::Attribute;
use rtrt_core::scene::{Mesh, MeshIndex};
use std::path::Path;

/// The joints that a vertex hangs on, and how much each counts.
pub(crate) type Hung = ([u32; 4], [f32; 4]);

/// What changes the shape of a mesh.
#[derive(Debug, Clone, Default)]
pub(crate) struct Deform {
    /// What is added to positions and normals, as much as their weights say.
    pub targets: Vec<Target>,
    /// Four joints of the skin for each vertex, and how much each counts; none without a skin.
    pub joints: Vec<Hung>,
}

/// A morph target. Empty lists change nothing.
#[derive(Debug, Clone, Default)]
pub(crate) struct Target {
    pub positions: Vec<[f32; 3]>,
    pub normals: Vec<[f32; 3]>,
}

impl Deform {
    /// The same for other vertices: `kept[i]` is what vertex `i` was.
    pub fn kept(&self, kept: &[u32]) -> Self {
        fn pick<T: Copy>(of: &[T], kept: &[u32]) -> Vec<T> {
            kept.iter().filter_map(|&i| of.get(i as usize).copied()).collect()
        }
        let target =
            |t: &Target| Target { positions: pick(&t.positions, kept), normals: pick(&t.normals, kept) };
        Self { targets: self.targets.iter().map(target).collect(), joints: pick(&self.joints, kept) }
    }
}

/// A mesh of a node of its own, and what it follows from.
#[derive(Debug, Clone)]
pub(super) struct Shape {
    /// What the file calls the mesh.
    pub name: String,
    pub mesh: MeshIndex,
    /// As the file has it.
    pub rest: Geometry,
    /// Of the targets, where they are not animated.
    pub weights: Vec<f64>,
    pub skin: Option<Skin>,
}

/// The joints of a skin.
#[derive(Debug, Clone)]
pub(super) struct Skin {
    /// Nodes: of the file, and once all are known by their place among those of the animation.
    pub joints: Vec<usize>,
    /// From the mesh to each joint.
    pub inverse: Vec<DMat4>,
}

impl Shape {
    /// The mesh with these weights of its targets and nodes there. A skin takes it to world space.
    ///
    /// ```text
    /// p = Σ weight · world(joint) · inverse(joint) · (p + Σ weight · target)
    /// ```
    ///
    /// Computed in `f64`. Weights of joints that do not add up to 1 are made to. Normals go by
    /// the cofactors of the matrix, so that stretching a mesh turns them as it should.
    pub fn at(&self, path: &Path, weights: &[f64], worlds: &[DMat4]) -> Result<Mesh, ImportError> {
        let joints: Vec<DMat4> = self.skin.iter().flat_map(|skin| skin.matrices(worlds)).collect();
        let deform = &self.rest.deform;
        let vertex = |i: usize| {
            let attribute = self.rest.attributes[i];
            let mut position = double(self.rest.positions[i]);
            let mut normal = double(attribute.normal);
            for (target, &weight) in deform.targets.iter().zip(weights) {
                position += target.positions.get(i).map_or(DVec3::ZERO, |&p| double(p)) * weight;
                normal += target.normals.get(i).map_or(DVec3::ZERO, |&n| double(n)) * weight;
            }
            if let Some(matrix) = deform.joints.get(i).and_then(|bound| blended(&joints, bound)) {
                position = matrix.transform_point3(position);
                let [x, y, z] = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|axis| axis.truncate());
                normal = y.cross(z) * normal.x + z.cross(x) * normal.y + x.cross(y) * normal.z;
            }
            (position.as_vec3().to_array(), Attribute { normal: normal.as_vec3().to_array(), ..attribute })
        };
        let (positions, attributes) = (0..self.rest.positions.len()).map(vertex).unzip();
        let refused = |source| ImportError::Mesh { path: path.to_owned(), mesh: self.name.clone(), source };
        Mesh::new(positions, attributes, self.rest.indices.clone()).map_err(refused)
    }
}

impl Skin {
    /// From the mesh to the world, by each joint. One that is not in the scene does not move.
    fn matrices(&self, worlds: &[DMat4]) -> impl Iterator<Item = DMat4> {
        let world = |&joint: &usize| worlds.get(joint).copied().unwrap_or(DMat4::IDENTITY);
        self.joints.iter().map(world).zip(&self.inverse).map(|(world, inverse)| world * *inverse)
    }
}

/// The mean of four joints' matrices; none if none of them counts.
fn blended(joints: &[DMat4], (bound, weights): &Hung) -> Option<DMat4> {
    let weight = |w: f32| if w > 0.0 { f64::from(w) } else { 0.0 };
    let sum: f64 = weights.iter().map(|&w| weight(w)).sum();
    let mut matrix = DMat4::ZERO;
    for (&joint, &w) in bound.iter().zip(weights) {
        if w > 0.0 {
            matrix += *joints.get(joint as usize)? * (weight(w) / sum);
        }
    }
    (sum > 0.0 && sum.is_finite()).then_some(matrix)
}

fn double(v: [f32; 3]) -> DVec3 {
    DVec3::from(v.map(f64::from))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A triangle whose corners hang on two joints: the first on one, the second on the other,
    /// the third on both.
    fn shape(targets: Vec<Target>, skin: Option<Skin>) -> Shape {
        let attribute = Attribute { normal: [1.0, 1.0, 0.0], uv: [0.0; 2], color: 0 };
        let bound = |weights: [f32; 4]| ([0, 1, 0, 0], weights);
        let joints = match skin {
            Some(_) => {
                vec![bound([1.0, 0.0, 0.0, 0.0]), bound([0.0, 2.0, 0.0, 0.0]), bound([1.0, 1.0, 0.0, 0.0])]
            }
            None => vec![],
        };
        let rest = Geometry {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            attributes: vec![attribute; 3],
            indices: vec![0, 1, 2],
            deform: Deform { targets, joints },
            ..Geometry::default()
        };
        let mut scene = rtrt_core::scene::Scene::new();
        let empty = Mesh::new(vec![], vec![], vec![]).unwrap();
        let tree = rtrt_core::scene::MeshTree::build(&empty, &rtrt_core::scene::Sequential);
        let mesh = scene.add_mesh(&empty, &tree).unwrap();
        Shape { name: String::new(), mesh, rest, weights: vec![], skin }
    }

    #[test]
    fn targets_are_added_by_their_weights() {
        let up = Target { positions: vec![[0.0, 0.0, 2.0]; 3], normals: vec![] };
        let lean = Target { positions: vec![], normals: vec![[0.0, 0.0, 4.0]; 3] };
        let mesh = shape(vec![up, lean], None).at(Path::new(""), &[0.5, 0.25], &[]).unwrap();
        assert_eq!(mesh.positions()[1], [1.0, 0.0, 1.0]);
        assert_eq!(mesh.attributes()[1].normal, [1.0, 1.0, 1.0]);
    }

    #[test]
    fn a_vertex_is_where_the_mean_of_its_joints_takes_it() {
        let skin = Skin {
            joints: vec![1, 0, 7],
            inverse: vec![
                DMat4::IDENTITY,
                DMat4::from_translation(DVec3::new(-1.0, 0.0, 0.0)),
                DMat4::IDENTITY,
            ],
        };
        let stretched = DMat4::from_scale(DVec3::new(4.0, 1.0, 1.0));
        let worlds = [stretched, DMat4::from_translation(DVec3::new(0.0, 0.0, 6.0))];
        let mesh = shape(vec![], Some(skin)).at(Path::new(""), &[], &worlds).unwrap();
        let places = [[0.0, 0.0, 6.0], [0.0, 0.0, 0.0], [-2.0, 1.0, 3.0]];
        assert_eq!(mesh.positions(), places);
        // What is stretched along x has normals that turn away from x.
        assert_eq!(mesh.attributes()[0].normal, [1.0, 1.0, 0.0]);
        assert_eq!(mesh.attributes()[1].normal, [1.0, 4.0, 0.0]);
    }
}

//! Meshes with morph targets or skins.

use super::ImportError;
use super::geometry::{Deform, Geometry, Tangents};
use glam::{DMat4, DVec3};
use rtrt_core::layout::Attribute;
use rtrt_core::scene::{Mesh, MeshIndex};
use std::path::Path;

/// A deformed mesh of one node, with its geometry at rest.
#[derive(Debug, Clone)]
pub(super) struct DeformedMesh {
    /// The name of the mesh in the file.
    pub name: String,
    pub mesh: MeshIndex,
    /// The geometry in the file.
    pub rest: Geometry,
    /// The weights of the targets without animation.
    pub weights: Vec<f64>,
    pub skin: Option<Skin>,
}

/// The joints of a skin.
#[derive(Debug, Clone)]
pub(super) struct Skin {
    /// The nodes of the joints: their numbers in the file, later their places in the animation.
    pub joints: Vec<usize>,
    /// The inverse bind matrices: from the mesh to each joint.
    pub inverse: Vec<DMat4>,
}

impl DeformedMesh {
    /// The mesh for these weights of its targets and transforms of nodes. A skinned mesh is in world space.
    ///
    /// ```text
    /// p = Σ weight · world(joint) · inverse(joint) · (p + Σ weight · target)
    /// ```
    ///
    /// Computed in `f64`. The weights of joints are normalized to a sum of 1. Normals are transformed by the
    /// inverse transpose up to a positive factor: the cofactors with the sign of the determinant. Tangents
    /// of the file are transformed by the matrix, computed ones are computed again.
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
            if let Some(matrix) = blended(&joints, deform, i) {
                position = matrix.transform_point3(position);
                let [x, y, z] = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|axis| axis.truncate());
                normal = y.cross(z) * normal.x + z.cross(x) * normal.y + x.cross(y) * normal.z;
                normal *= handedness(&matrix);
            }
            (position.as_vec3().to_array(), Attribute { normal: normal.as_vec3().to_array(), ..attribute })
        };
        let (positions, attributes) = (0..self.rest.positions.len()).map(vertex).unzip();
        let refused = |source| ImportError::Mesh { path: path.to_owned(), mesh: self.name.clone(), source };
        let mesh = Mesh::new(positions, attributes, self.rest.indices.clone()).map_err(refused)?;
        match &self.rest.tangents {
            Tangents::None => Ok(mesh),
            Tangents::Given(tangents) => {
                let turned =
                    (0..).zip(tangents).map(|(i, &tangent)| self.tangent(i, tangent, weights, &joints));
                mesh.with_tangents(&turned.collect::<Vec<_>>()).map_err(refused)
            }
            Tangents::Made { second } => {
                let mesh = match &self.rest.second_uv {
                    Some(uv) if *second => mesh.with_second_uv(uv.clone()).map_err(refused)?,
                    _ => mesh,
                };
                Ok(mesh.with_made_tangents(*second))
            }
        }
    }

    /// A vertex's tangent of the file. A matrix that mirrors changes the hand of the bitangent.
    fn tangent(
        &self,
        i: usize,
        [x, y, z, mut hand]: [f32; 4],
        weights: &[f64],
        joints: &[DMat4],
    ) -> [f32; 4] {
        let deform = &self.rest.deform;
        let mut tangent = double([x, y, z]);
        for (target, &weight) in deform.targets.iter().zip(weights) {
            tangent += target.tangents.get(i).map_or(DVec3::ZERO, |&t| double(t)) * weight;
        }
        if let Some(matrix) = blended(joints, deform, i) {
            tangent = matrix.transform_vector3(tangent);
            hand *= handedness(&matrix) as f32;
        }
        let [x, y, z] = tangent.as_vec3().to_array();
        [x, y, z, hand]
    }
}

/// Turns the triangles around that a skin mirrors at rest: a mirrored triangle would show its back. `joints` are the
/// matrices of the skin's joints.
pub(super) fn turn_mirrored(geometry: &mut Geometry, joints: &[DMat4]) {
    for triangle in geometry.indices.chunks_exact_mut(3) {
        let matrix = blended(joints, &geometry.deform, triangle[0] as usize);
        if matrix.is_some_and(|matrix| handedness(&matrix) < 0.0) {
            triangle.swap(1, 2);
        }
    }
}

/// −1 for a matrix that mirrors, else 1.
fn handedness(matrix: &DMat4) -> f64 {
    if matrix.determinant() < 0.0 { -1.0 } else { 1.0 }
}

impl Skin {
    /// The matrix of each joint, from the mesh to the world. A joint outside of the scene does not move.
    pub fn matrices(&self, worlds: &[DMat4]) -> impl Iterator<Item = DMat4> {
        let world = |&joint: &usize| worlds.get(joint).copied().unwrap_or(DMat4::IDENTITY);
        self.joints.iter().map(world).zip(&self.inverse).map(|(world, inverse)| world * *inverse)
    }
}

/// The weighted mean of the matrices of a vertex's joints; none if no joint has a weight.
fn blended(joints: &[DMat4], deform: &Deform, vertex: usize) -> Option<DMat4> {
    let bound = || {
        let sets = deform.joint_sets.iter().filter_map(move |set| set.get(vertex));
        sets.flat_map(|(bound, weights)| bound.iter().zip(weights)).filter(|(_, weight)| **weight > 0.0)
    };
    let sum: f64 = bound().map(|(_, &weight)| f64::from(weight)).sum();
    let mut matrix = DMat4::ZERO;
    for (&joint, &weight) in bound() {
        matrix += *joints.get(joint as usize)? * (f64::from(weight) / sum);
    }
    (sum > 0.0 && sum.is_finite()).then_some(matrix)
}

fn double(v: [f32; 3]) -> DVec3 {
    DVec3::from(v.map(f64::from))
}

#[cfg(test)]
mod tests {
    use super::super::geometry::Target;
    use super::*;

    /// A triangle whose corners hang on two joints: the first on one, the second on the other,
    /// the third on both.
    fn shape(targets: Vec<Target>, skin: Option<Skin>) -> DeformedMesh {
        let attribute = Attribute { normal: [1.0, 1.0, 0.0], uv: [0.0; 2], color: [0; 2] };
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
            deform: Deform { targets, joint_sets: vec![joints] },
            ..Geometry::default()
        };
        let mut scene = rtrt_core::scene::Scene::new();
        let empty = Mesh::new(vec![], vec![], vec![]).unwrap();
        let tree = rtrt_core::scene::Bvh::build(&empty, &rtrt_core::scene::Sequential);
        let mesh = scene.add_mesh(&empty, &tree).unwrap();
        DeformedMesh { name: String::new(), mesh, rest, weights: vec![], skin }
    }

    #[test]
    fn targets_are_added_by_their_weights() {
        let up = Target { positions: vec![[0.0, 0.0, 2.0]; 3], ..Target::default() };
        let lean = Target { normals: vec![[0.0, 0.0, 4.0]; 3], ..Target::default() };
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
        // Normals turn away from the direction of a stretch.
        assert_eq!(mesh.attributes()[0].normal, [1.0, 1.0, 0.0]);
        assert_eq!(mesh.attributes()[1].normal, [1.0, 4.0, 0.0]);
    }

    /// A skin whose two joints both turn by this, so that all of a mesh does.
    fn turning() -> (Skin, [DMat4; 2]) {
        let turn = DMat4::from_rotation_z(1.1) * DMat4::from_rotation_x(0.4);
        (Skin { joints: vec![0, 1], inverse: vec![DMat4::IDENTITY; 2] }, [turn; 2])
    }

    #[test]
    fn tangents_of_the_file_turn_with_the_mesh() {
        let (skin, worlds) = turning();
        let mut turned = shape(vec![], Some(skin));
        turned.rest.tangents =
            Tangents::Given(vec![[0.0, 0.0, 1.0, 1.0], [1.0, -1.0, 0.0, -1.0], [3.0, -3.0, 0.0, 1.0]]);
        let mesh = turned.at(Path::new(""), &[], &worlds).unwrap();
        let along = worlds[0].transform_vector3(DVec3::new(1.0, -1.0, 0.0)).as_vec3();
        let up = worlds[0].transform_vector3(DVec3::Z).as_vec3();
        let expected = [up.extend(1.0), along.extend(-1.0), (along * 3.0).extend(1.0)].map(|t| t.to_array());
        let plain = Mesh::new(mesh.positions().to_vec(), mesh.attributes().to_vec(), vec![0, 1, 2]).unwrap();
        assert_eq!(mesh, plain.clone().with_tangents(&expected).unwrap());
        assert_ne!(mesh, plain.with_tangents(&[[0.0, 0.0, 1.0, 1.0]; 3]).unwrap());
        // Targets add to them.
        let lean = Target { tangents: vec![[0.0, 4.0, 0.0]; 3], ..Target::default() };
        let mut leaning = shape(vec![lean], None);
        leaning.rest.tangents = Tangents::Given(vec![[1.0, 0.0, 0.0, 1.0]; 3]);
        let mesh = leaning.at(Path::new(""), &[0.25], &[]).unwrap();
        let rest = leaning.at(Path::new(""), &[0.0], &[]).unwrap();
        assert_eq!(mesh, rest.with_tangents(&[[1.0, 1.0, 0.0, 1.0]; 3]).unwrap());
    }

    #[test]
    fn tangents_that_were_made_are_made_anew() {
        let (skin, worlds) = turning();
        for second in [false, true] {
            let mut turned = shape(vec![], Some(skin.clone()));
            let uv = vec![[0.0, 0.0], [0.5, 1.0], [1.0, 0.0]];
            for (attribute, &uv) in turned.rest.attributes.iter_mut().zip(&uv) {
                (attribute.normal, attribute.uv) = ([0.0, 0.0, 1.0], if second { [0.0; 2] } else { uv });
            }
            turned.rest.second_uv = second.then_some(uv);
            turned.rest.tangents = Tangents::Made { second };
            let mesh = turned.at(Path::new(""), &[], &worlds).unwrap();
            // Along the first edge u grows by a half, along the second by one, and v by one and not at all.
            let along = worlds[0].transform_vector3(DVec3::Y).as_vec3().extend(1.0).to_array();
            let hand = |w| mesh.clone().with_tangents(&[[along[0], along[1], along[2], w]; 3]).unwrap();
            assert!(mesh == hand(1.0) || mesh == hand(-1.0), "{second}");
        }
    }
}

//! The animations of a scene: the pose at a time.

use super::ImportError;
use super::deformed::DeformedMesh;
use super::track::Track;
use glam::{DMat4, DQuat, DVec3, Mat4, Vec3};
use gltf_json::animation::Property;
use rtrt_core::scene::{
    Camera, InstanceIndex, Light, Mesh, MeshIndex, Motion, Projection, Scene, SceneError,
};
use std::path::{Path, PathBuf};

/// The animations of a file, or the motions of a scene built in code. Unless another one is chosen, the first
/// animation is played.
#[derive(Debug, Clone)]
pub struct Animation {
    path: PathBuf,
    names: Vec<String>,
    /// The animation that is played; none for all at once.
    played: Option<usize>,
    /// What is subtracted from the world of the nodes.
    origin: DVec3,
    /// Parents come before their children.
    nodes: Vec<SceneNode>,
    /// Instances with a motion, and their transforms at the start.
    motions: Vec<(InstanceIndex, Mat4, Motion)>,
    /// The end of the motions, seconds.
    rest: f64,
}

/// A node with its instances, deformed meshes, camera and light.
#[derive(Debug, Clone)]
pub(super) struct SceneNode {
    /// The parent's place in the list of nodes.
    pub parent: Option<usize>,
    pub local: Local,
    pub tracks: Vec<Track>,
    /// The instances, with their transforms relative to the node.
    pub objects: Vec<(InstanceIndex, DMat4)>,
    /// The deformed meshes.
    pub shapes: Vec<DeformedMesh>,
    /// A camera, by its place in [`super::Loaded::cameras`].
    pub camera: Option<(usize, Projection)>,
    /// A light, by its place in the scene.
    pub light: Option<usize>,
}

/// A node's own transform. Long chains multiply many, so it is in double precision.
#[derive(Debug, Clone, Copy)]
pub(super) enum Local {
    Matrix(DMat4),
    /// Scale, then rotation (a quaternion of any length), then translation.
    Parts {
        translation: DVec3,
        rotation: DQuat,
        scale: DVec3,
    },
}

impl Local {
    pub const IDENTITY: Self =
        Self::Parts { translation: DVec3::ZERO, rotation: DQuat::IDENTITY, scale: DVec3::ONE };

    /// The transform as a matrix.
    pub fn matrix(&self) -> DMat4 {
        let Self::Parts { translation, rotation, scale } = *self else {
            let Self::Matrix(matrix) = *self else { return DMat4::IDENTITY };
            return matrix;
        };
        let length = libm::sqrt(rotation.length_squared());
        let rotation = if length > 0.0 { rotation * (1.0 / length) } else { DQuat::IDENTITY };
        DMat4::from_cols(
            (rotation * DVec3::X).extend(0.0),
            (rotation * DVec3::Y).extend(0.0),
            (rotation * DVec3::Z).extend(0.0),
            translation.extend(1.0),
        ) * DMat4::from_scale(scale)
    }

    /// The transform at a time. The format forbids to animate a matrix; tracks replace it.
    fn at(&self, tracks: &[&Track], time: f64) -> Self {
        let Some(Self::Parts { mut translation, mut rotation, mut scale }) = (match self {
            Self::Matrix(_) if tracks.is_empty() => None,
            Self::Matrix(_) => Some(Self::IDENTITY),
            Self::Parts { .. } => Some(*self),
        }) else {
            return *self;
        };
        for track in tracks {
            match (track.property, track.at(time)[..].as_ref()) {
                (Property::Translation, &[x, y, z]) => translation = DVec3::new(x, y, z),
                (Property::Scale, &[x, y, z]) => scale = DVec3::new(x, y, z),
                (Property::Rotation, &[x, y, z, w]) => rotation = DQuat::from_xyzw(x, y, z, w),
                _ => {}
            }
        }
        Self::Parts { translation, rotation, scale }
    }
}

/// The state of all moving things at a time.
#[derive(Debug, Clone, Default)]
pub struct Pose {
    /// Instances, and their transforms to world space.
    pub objects: Vec<(InstanceIndex, Mat4)>,
    /// Deformed meshes.
    pub shapes: Vec<(MeshIndex, Mesh)>,
    /// Cameras, by their place in [`super::Loaded::cameras`].
    pub cameras: Vec<(usize, Camera)>,
    /// Lights, by their place in the scene, with position and direction.
    pub lights: Vec<(usize, Vec3, Vec3)>,
    path: PathBuf,
}

impl Animation {
    pub(super) fn new(path: &Path, names: Vec<String>, nodes: Vec<SceneNode>) -> Self {
        Self {
            path: path.to_owned(),
            names,
            played: Some(0),
            origin: DVec3::ZERO,
            nodes,
            motions: Vec::new(),
            rest: 0.0,
        }
    }

    /// The animation of a world from which this is subtracted.
    pub(super) fn relative_to(self, origin: DVec3) -> Self {
        Self { origin, ..self }
    }

    /// An animation of these motions, which end after `rest` seconds.
    pub(crate) fn of_motions(path: &str, motions: Vec<(InstanceIndex, Mat4, Motion)>, rest: f64) -> Self {
        Self { motions, rest, ..Self::new(Path::new(path), vec!["motion".into()], Vec::new()) }
    }

    /// The names of the animations, in their order; empty for one without a name.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Chooses the animation, counted from 0, or all at once. Of several for the same property the last one
    /// counts.
    pub fn play(&mut self, number: Option<usize>) {
        self.played = number;
    }

    /// The number of the chosen animation; none for all at once.
    pub fn played_number(&self) -> Option<usize> {
        self.played
    }

    /// The tracks of a node in the chosen animation.
    fn played<'a>(&'a self, node: &'a SceneNode) -> impl Iterator<Item = &'a Track> {
        node.tracks.iter().filter(|track| self.played.is_none_or(|number| track.animation == number))
    }

    /// Whether any animation moves something.
    pub(super) fn moves(&self) -> bool {
        self.nodes.iter().any(|node| !node.tracks.is_empty())
    }

    /// The end of the chosen animation, seconds.
    pub fn end(&self) -> f64 {
        self.nodes.iter().flat_map(|node| self.played(node)).map(Track::end).fold(self.rest, f64::max)
    }

    /// The pose `time` seconds after the start, without things that do not move.
    ///
    /// # Errors
    /// A deformed mesh cannot be drawn.
    pub fn at(&self, time: f64) -> Result<Pose, ImportError> {
        self.pose(Some(time))
    }

    /// The deformed meshes without animation.
    pub(super) fn rest(&self) -> Result<Pose, ImportError> {
        Ok(Pose { shapes: self.pose(None)?.shapes, path: self.path.clone(), ..Pose::default() })
    }

    /// The pose without animation, of the things that the chosen one moves: for when another one is chosen, which may leave
    /// them alone.
    ///
    /// # Errors
    /// A deformed mesh cannot be drawn.
    pub fn unplayed(&self) -> Result<Pose, ImportError> {
        self.pose(None)
    }

    fn pose(&self, time: Option<f64>) -> Result<Pose, ImportError> {
        let mut pose = Pose { path: self.path.clone(), ..Pose::default() };
        let (mut worlds, mut moving): (Vec<DMat4>, Vec<bool>) = (vec![], vec![]);
        let from_origin = DMat4::from_translation(-self.origin);
        for node in &self.nodes {
            let tracks: Vec<_> = self.played(node).collect();
            let parent = node.parent.map_or(from_origin, |place| worlds[place]);
            let local = time.map_or(node.local, |time| node.local.at(&tracks, time));
            worlds.push(parent * local.matrix());
            moving.push(node.parent.is_some_and(|place| moving[place]) || !tracks.is_empty());
        }
        if let Some(time) = time {
            let time = time.clamp(0.0, self.rest);
            pose.objects.extend(
                self.motions.iter().map(|(object, start, motion)| (*object, motion.at(*start, time))),
            );
        }
        for (place, node) in self.nodes.iter().enumerate() {
            let weights = self.played(node).filter(|track| track.property == Property::MorphTargetWeights);
            let weights = weights.last();
            let weights = time.and_then(|time| Some(weights?.at(time)));
            for shape in &node.shapes {
                let joints = shape.skin.iter().flat_map(|skin| &skin.joints);
                let is_bent = joints.into_iter().any(|&joint| moving.get(joint) == Some(&true));
                if time.is_none() || is_bent || weights.is_some() {
                    let weights = weights.as_ref().unwrap_or(&shape.weights);
                    pose.shapes.push((shape.mesh, shape.at(&self.path, weights, &worlds)?));
                }
            }
            if !moving[place] {
                continue;
            }
            let to_world = worlds[place];
            pose.objects
                .extend(node.objects.iter().map(|(object, from)| (*object, (to_world * *from).as_mat4())));
            if let Some((index, projection)) = node.camera {
                pose.cameras.extend(camera(projection, &to_world).map(|camera| (index, camera)));
            }
            let (position, direction) =
                (to_world.w_axis.truncate().as_vec3(), -to_world.z_axis.truncate().as_vec3());
            if direction.length_squared() > 0.0 && direction.is_finite() && position.is_finite() {
                pose.lights.extend(node.light.map(|index| (index, position, direction)));
            }
        }
        Ok(pose)
    }
}

impl Pose {
    /// Moves the scene's instances, and bends its meshes. An instance whose transform has no inverse is hidden. What was
    /// removed from the scene stays away.
    ///
    /// # Errors
    /// The pose is of another scene, or an instance is out of range.
    pub fn apply(&self, scene: &mut Scene) -> Result<(), ImportError> {
        let refused = |source: SceneError| ImportError::Scene { path: self.path.clone(), source };
        let objects = self.objects.iter().filter(|(object, _)| !scene.is_removed(*object));
        let (visible, hidden): (Vec<_>, Vec<_>) = objects.partition(|(_, to_world)| has_inverse(to_world));
        for (mesh, shape) in &self.shapes {
            if !scene.is_mesh_removed(*mesh) {
                scene.reshape(*mesh, shape).map_err(refused)?;
            }
        }
        scene.set_transforms(visible).map_err(refused)?;
        hidden.into_iter().try_for_each(|(object, _)| scene.hide(object)).map_err(refused)
    }

    /// Moves the lights of the file.
    pub fn aim(&self, lights: &mut [Light]) {
        for &(index, place, along) in &self.lights {
            if let Some(light) = lights.get_mut(index) {
                (light.position, light.direction) = (place, along);
            }
        }
    }
}

/// Whether an instance can have this transform.
fn has_inverse(to_world: &Mat4) -> bool {
    let m = to_world.as_dmat4();
    m.determinant() != 0.0 && m.is_finite() && m.inverse().as_mat4().is_finite()
}

/// The camera of a node; none if its picture would be empty.
pub(super) fn camera(projection: Projection, to_world: &DMat4) -> Option<Camera> {
    let usable = match projection {
        Projection::Perspective { fov_y } => fov_y > 0.0 && fov_y < std::f32::consts::PI,
        Projection::OffCenter { left, right, bottom, top } => left < right && bottom < top,
        Projection::Orthographic { height } => height > 0.0 && height.is_finite(),
    };
    let eye = to_world.w_axis.truncate();
    let up = to_world.y_axis.truncate().as_vec3();
    let forward = -to_world.z_axis.truncate();
    let length = libm::sqrt(forward.length_squared());
    // So far that the point differs from the eye in single precision.
    let distance = eye.abs().max_element().max(1.0);
    let look_at = (eye + forward * (distance / length)).as_vec3();
    let across = up.cross(forward.as_vec3());
    let usable = usable && look_at.is_finite() && up.is_finite() && across != Vec3::ZERO;
    usable.then_some(Camera { eye: eye.as_vec3(), look_at, up, projection })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rtrt_core::scene::{Attribute, Bvh, Material, Sequential};

    #[test]
    fn what_was_removed_stays_away_and_the_rest_moves() {
        let shape = |x: f32| {
            let attribute = Attribute { normal: [0.0; 3], uv: [0.0; 2], color: Attribute::WHITE };
            let corners = vec![[x, 0.0, 0.0], [x + 1.0, 0.0, 0.0], [x, 1.0, 0.0]];
            Mesh::new(corners, vec![attribute; 3], vec![0, 1, 2]).unwrap()
        };
        let mut scene = Scene::new();
        let paint = scene.add_material(Material::new([0.8; 3])).unwrap();
        let meshes =
            [0; 2].map(|_| scene.add_mesh(&shape(0.0), &Bvh::build(&shape(0.0), &Sequential)).unwrap());
        let objects = [0, 0, 1, 1].map(|n| scene.add_instance(meshes[n], paint, Mat4::IDENTITY).unwrap());
        let away = Mat4::from_translation(Vec3::X * 3.0);
        let pose = Pose {
            objects: vec![
                (objects[0], Mat4::ZERO),
                (objects[1], away),
                (objects[2], away),
                (objects[3], Mat4::ZERO),
            ],
            shapes: meshes.map(|mesh| (mesh, shape(5.0))).to_vec(),
            ..Pose::default()
        };
        objects[..2].iter().for_each(|gone| scene.remove_instance(*gone).unwrap());
        scene.remove_mesh(meshes[0]).unwrap();
        // It has the number of one that was removed.
        let new = scene.add_instance(meshes[1], paint, Mat4::IDENTITY).unwrap();
        assert!(objects[..2].iter().any(|gone| gone.number() == new.number()));
        pose.apply(&mut scene).unwrap();
        let low = |object: InstanceIndex| scene.instances()[object.number() as usize].low[0];
        assert_eq!((low(new), low(objects[2])), (5.0, 8.0));
        assert_eq!(scene.instances()[objects[3].number() as usize].triangles, 0);
    }

    #[test]
    fn a_pose_of_another_scene_is_an_error() {
        let mut other = Scene::new();
        let paint = other.add_material(Material::default()).unwrap();
        let ball = other.add_sphere(paint, Mat4::IDENTITY).unwrap();
        let pose = Pose { objects: vec![(ball, Mat4::IDENTITY)], ..Pose::default() };
        assert!(matches!(pose.apply(&mut Scene::new()), Err(ImportError::Scene { .. })));
        pose.apply(&mut other).unwrap();
    }
}

//! How far surfaces move in the picture from one frame to the next.

use crate::layers::Layers;
use crate::pose::pixel;
use glam::DVec3;
use rtrt_core::layout::Instance;
use rtrt_core::scene::{Camera, InstanceIndex, Scene};
use std::sync::Arc;

/// A scene and its camera as they were.
#[derive(Debug, Clone)]
pub struct Before {
    camera: Camera,
    moment: Arc<Moment>,
}

/// A scene as it was.
#[derive(Debug)]
struct Moment {
    /// [`Scene::id`].
    scene: u32,
    instances: Vec<(Instance, Option<InstanceIndex>)>,
    positions: Vec<[f32; 3]>,
    /// Counts changes of `positions`.
    geometry: u32,
}

impl Before {
    /// What the next frame has to know of this one.
    pub fn new(scene: &Scene, camera: &Camera) -> Self {
        let numbered = (0..).zip(scene.instances());
        let moment = Moment {
            scene: scene.id(),
            instances: numbered.map(|(number, own)| (*own, scene.instance_index(number))).collect(),
            positions: scene.positions().to_vec(),
            geometry: scene.versions().geometry,
        };
        Self { camera: *camera, moment: Arc::new(moment) }
    }

    /// The same moment from another camera.
    #[must_use]
    pub fn seen_from(&self, camera: &Camera) -> Self {
        Self { camera: *camera, moment: self.moment.clone() }
    }

    /// Whether it was this scene.
    pub fn is_of(&self, scene: &Scene) -> bool {
        self.moment.scene == scene.id()
    }
}

/// A point of a surface in a picture.
#[derive(Debug, Clone, Copy)]
pub struct Point {
    /// As [`Layers::object`].
    pub object: u32,
    /// As [`Layers::triangle`].
    pub triangle: u32,
    /// As [`Layers::barycentrics`].
    pub barycentrics: [f32; 2],
    /// As [`Layers::position`].
    pub position: [f32; 3],
}

/// How points of a picture of this size have moved since `before`, pixel by pixel; see [`motion`].
#[derive(Debug)]
pub struct Motion<'a> {
    scene: &'a Scene,
    camera: &'a Camera,
    before: &'a Before,
    size: [u32; 2],
    is_bent: bool,
}

impl<'a> Motion<'a> {
    /// The motion in a picture of the scene from this camera.
    pub fn new(scene: &'a Scene, camera: &'a Camera, size: [u32; 2], before: &'a Before) -> Self {
        let is_bent = before.moment.geometry != scene.versions().geometry;
        Self { scene, camera, before, size, is_bent }
    }

    /// That of a point.
    pub fn of(&self, point: &Point) -> [f32; 2] {
        let Self { scene, camera, before, size, is_bent } = *self;
        let (object, then) = (point.object as usize, &before.moment.instances);
        let (Some(now), Some((then, index))) = (scene.instances().get(object), then.get(object)) else {
            return [0.0; 2];
        };
        // One that was hidden was nowhere, nor was one that has the number of another.
        if then.triangles == 0 || scene.instance_index(point.object) != *index {
            return [0.0; 2];
        }
        let here = DVec3::from(point.position.map(f64::from));
        let own = if is_bent && !now.is_sphere() && point.triangle < now.triangles {
            let [u, v] = point.barycentrics.map(f64::from);
            let corners = now.corners(scene.mesh_data(), point.triangle);
            let positions = &before.moment.positions;
            // Meshes that were removed have moved the others in the arrays.
            let then = |vertex: u32| (vertex - now.first_vertex + then.first_vertex) as usize;
            let [a, b, c] = corners.map(|vertex| DVec3::from(positions[then(vertex)].map(f64::from)));
            a * (1.0 - u - v) + b * u + c * v
        } else {
            let place = DVec3::from(now.to_object.map(|row| f64::from(row[3])));
            turned(&now.to_object, here - place)
        };
        let there = turned(&then.to_world, own) + DVec3::from(then.to_world.map(|row| f64::from(row[3])));
        match (pixel(camera, size, here), pixel(&before.camera, size, there)) {
            (Some(here), Some(there)) => [0, 1].map(|axis| (here[axis] - there[axis]) as f32),
            _ => [f32::NAN; 2],
        }
    }
}

/// The motion of each pixel's surface since `before`, in pixels: where it is, less where it was, to the right and
/// downward. It follows transforms, bent meshes and the camera. 0 without a surface, and for one that was hidden; not a
/// number for one that was behind the camera.
pub fn motion(scene: &Scene, camera: &Camera, layers: &Layers, before: &Before) -> Vec<[f32; 2]> {
    let all = Motion::new(scene, camera, [layers.width, layers.height], before);
    let of = |number: usize| {
        all.of(&Point {
            object: layers.object[number],
            triangle: layers.triangle[number],
            barycentrics: layers.barycentrics[number],
            position: layers.position[number],
        })
    };
    (0..layers.object.len()).map(of).collect()
}

/// A vector through the first three columns of a matrix.
fn turned(rows: &[[f32; 4]; 3], v: DVec3) -> DVec3 {
    DVec3::from(rows.map(|[x, y, z, _]| DVec3::new(x.into(), y.into(), z.into()).dot(v)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Mat4, Vec3};
    use rtrt_core::backend::{Backend, Picture, Request};
    use rtrt_core::layout::Attribute;
    use rtrt_core::scene::{Bvh, Material, Mesh, MeshIndex, Projection, Sequential};

    /// What moves from one frame to the next.
    #[derive(Clone, Copy)]
    enum Moved {
        Ball,
        Shape,
        Camera,
    }

    const STEP: Vec3 = Vec3::new(0.3, 0.2, 0.0);

    /// A triangle around the origin, moved by `by`.
    fn triangle(by: Vec3) -> Mesh {
        let corners = [[-4.0, -3.0, 0.0], [4.0, -3.0, 0.0], [0.0, 4.0, 0.0]];
        let positions = corners.map(|corner| (Vec3::from(corner) + by).into()).to_vec();
        let plain = Attribute { normal: [0.0, 0.0, 1.0], uv: [0.0; 2], color: Attribute::WHITE };
        Mesh::new(positions, vec![plain; 3], vec![0, 1, 2]).unwrap()
    }

    /// A scene of a ball, or of the triangle.
    fn scene(is_ball: bool) -> (Scene, InstanceIndex, Option<MeshIndex>) {
        let mut scene = Scene::new();
        let paint = scene.add_material(Material::new([0.8; 3])).unwrap();
        if is_ball {
            let ball = scene.add_sphere(paint, Mat4::from_scale(Vec3::splat(2.0))).unwrap();
            return (scene, ball, None);
        }
        let shape = triangle(Vec3::ZERO);
        let mesh = scene.add_mesh(&shape, &Bvh::build(&shape, &Sequential)).unwrap();
        let object = scene.add_instance(mesh, paint, Mat4::IDENTITY).unwrap();
        (scene, object, Some(mesh))
    }

    /// The motion in the middle of a picture with 10 pixels a unit.
    fn in_the_middle(moved: Moved) -> [f32; 2] {
        let (mut scene, object, mesh) = scene(!matches!(moved, Moved::Shape));
        let projection = Projection::Orthographic { height: 6.4 };
        let mut camera = Camera { eye: Vec3::Z * 9.0, look_at: Vec3::ZERO, up: Vec3::Y, projection };
        let before = Before::new(&scene, &camera);
        match (moved, mesh) {
            (Moved::Shape, Some(mesh)) => scene.reshape(mesh, &triangle(STEP)).unwrap(),
            (Moved::Camera, _) => (camera.eye, camera.look_at) = (camera.eye + STEP, camera.look_at + STEP),
            _ => {
                let place = Mat4::from_translation(STEP) * Mat4::from_scale(Vec3::splat(2.0));
                scene.set_transform(object, place).unwrap();
            }
        }
        let mut picture = Picture::default();
        let request = Request::new(&camera, [64, 64]).deferred(true);
        let mut cpu = rtrt_cpu::Cpu::new(rtrt_cpu::Options { lanes: Some(1), threads: Some(1) }).unwrap();
        cpu.render(&scene, &request, &mut picture).unwrap();
        let layers = Layers::new(&scene, &request, &picture).unwrap();
        let all = motion(&scene, &camera, &layers, &before);
        assert_eq!(all[0], [0.0; 2]);
        all[32 * 64 + 32]
    }

    #[test]
    fn what_was_hidden_has_not_moved() {
        let (mut scene, object, _) = scene(true);
        let projection = Projection::Orthographic { height: 6.4 };
        let camera = Camera { eye: Vec3::Z * 9.0, look_at: Vec3::ZERO, up: Vec3::Y, projection };
        scene.hide(object).unwrap();
        let before = Before::new(&scene, &camera);
        let place = Mat4::from_translation(STEP) * Mat4::from_scale(Vec3::splat(2.0));
        scene.set_transform(object, place).unwrap();
        let point = Point { object: 0, triangle: 0, barycentrics: [0.5; 2], position: [0.3, 0.2, 2.0] };
        assert_eq!(Motion::new(&scene, &camera, [64, 64], &before).of(&point), [0.0; 2]);
        assert!(before.is_of(&scene) && !before.is_of(&Scene::new()));
    }

    #[test]
    fn what_is_removed_changes_the_motion_of_nothing_else_and_what_has_its_number_was_not_there() {
        let mut scene = Scene::new();
        let paint = scene.add_material(Material::new([0.8; 3])).unwrap();
        // One mesh in front of the triangle's in the arrays, with an instance.
        let [other, mesh] = [Vec3::X * 50.0, Vec3::ZERO].map(|by| {
            let shape = triangle(by);
            scene.add_mesh(&shape, &Bvh::build(&shape, &Sequential)).unwrap()
        });
        let gone = scene.add_instance(other, paint, Mat4::IDENTITY).unwrap();
        let object = scene.add_instance(mesh, paint, Mat4::IDENTITY).unwrap();
        let projection = Projection::Orthographic { height: 6.4 };
        let camera = Camera { eye: Vec3::Z * 9.0, look_at: Vec3::ZERO, up: Vec3::Y, projection };
        let before = Before::new(&scene, &camera);
        scene.remove_instance(gone).unwrap();
        scene.remove_mesh(other).unwrap();
        scene.set_transform(object, Mat4::from_translation(STEP)).unwrap();
        let new = scene.add_instance(mesh, paint, Mat4::from_translation(STEP)).unwrap();
        assert_eq!(new.number(), gone.number());
        let motion = Motion::new(&scene, &camera, [64, 64], &before);
        // Of its triangle, the point with the weights ½, ¼, ¼.
        let position = [-1.0 + STEP.x, -1.25 + STEP.y, 0.0];
        let of = |object: InstanceIndex| {
            motion.of(&Point { object: object.number(), triangle: 0, barycentrics: [0.25; 2], position })
        };
        assert_eq!(of(new), [0.0; 2]);
        let found = of(object);
        assert!((0..2).all(|i: usize| (found[i] - [3.0, -2.0][i]).abs() < 1e-3), "{found:?}");
    }

    #[test]
    fn what_moves_to_the_right_and_up_moves_so_in_the_picture() {
        for (moved, expected) in
            [(Moved::Ball, [3.0, -2.0]), (Moved::Shape, [3.0, -2.0]), (Moved::Camera, [-3.0, 2.0])]
        {
            let found = in_the_middle(moved);
            assert!((0..2).all(|i: usize| (found[i] - expected[i]).abs() < 1e-3), "{found:?} {expected:?}");
        }
    }
}

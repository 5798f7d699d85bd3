//! How far surfaces move in the picture from one frame to the next.

use crate::layers::Layers;
use crate::pose::pixel;
use glam::DVec3;
use rtrt_core::layout::{Instance, NONE};
use rtrt_core::scene::{Camera, Scene};

/// A scene and its camera as they were.
#[derive(Debug, Clone)]
pub struct Before {
    camera: Camera,
    instances: Vec<Instance>,
    positions: Vec<[f32; 3]>,
    /// Counts changes of `positions`.
    geometry: u32,
}

impl Before {
    /// What the next frame has to know of this one.
    pub fn new(scene: &Scene, camera: &Camera) -> Self {
        Self {
            camera: *camera,
            instances: scene.instances().to_vec(),
            positions: scene.positions().to_vec(),
            geometry: scene.versions().geometry,
        }
    }
}

/// The motion of each pixel's surface since `before`, in pixels: where it is, less where it was, to the right and
/// downward. It follows transforms, bent meshes and the camera. 0 without a surface; not a number for one that was
/// behind the camera.
pub fn motion(scene: &Scene, camera: &Camera, layers: &Layers, before: &Before) -> Vec<[f32; 2]> {
    let size = [layers.width, layers.height];
    let is_bent = before.geometry != scene.versions().geometry;
    let of = |number: usize| {
        let object = layers.object[number] as usize;
        let (Some(now), Some(then)) = (scene.instances().get(object), before.instances.get(object)) else {
            return [0.0; 2];
        };
        let here = DVec3::from(layers.position[number].map(f64::from));
        let triangle = layers.triangle[number];
        let own = if is_bent && !now.is_sphere() && triangle < now.triangles {
            let [u, v] = layers.barycentrics[number].map(f64::from);
            let corners = now.corners(scene.mesh_data(), triangle);
            let [a, b, c] =
                corners.map(|vertex| DVec3::from(before.positions[vertex as usize].map(f64::from)));
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
    };
    (0..layers.object.len()).map(|n| if layers.object[n] == NONE { [0.0; 2] } else { of(n) }).collect()
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
    use rtrt_core::scene::{Bvh, InstanceIndex, Material, Mesh, MeshIndex, Projection, Sequential};

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
        let layers = Layers::new(&scene, &picture, 1).unwrap();
        let all = motion(&scene, &camera, &layers, &before);
        assert_eq!(all[0], [0.0; 2]);
        all[32 * 64 + 32]
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

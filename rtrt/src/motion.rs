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
            through(&now.to_object, here)
        };
        let there = through(&then.to_world, own);
        match (pixel(camera, size, here), pixel(&before.camera, size, there)) {
            (Some(here), Some(there)) => [0, 1].map(|axis| (here[axis] - there[axis]) as f32),
            _ => [f32::NAN; 2],
        }
    };
    (0..layers.object.len()).map(|n| if layers.object[n] == NONE { [0.0; 2] } else { of(n) }).collect()
}

/// A point through three rows of a matrix.
fn through(rows: &[[f32; 4]; 3], point: DVec3) -> DVec3 {
    DVec3::from(rows.map(|row| {
        let [x, y, z, w] = row.map(f64::from);
        x * point.x + y * point.y + z * point.z + w
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Mat4, Vec3};
    use rtrt_core::backend::{Backend, Picture, Request};
    use rtrt_core::scene::{Material, Projection};

    /// A ball that moves by (0.3, 0.2) in a picture of 10 pixels a unit, and the motion in its middle.
    fn in_the_middle(moves_camera: bool) -> [f32; 2] {
        let mut scene = Scene::new();
        let paint = scene.add_material(Material::new([0.8; 3])).unwrap();
        let ball = scene.add_sphere(paint, Mat4::from_scale(Vec3::splat(2.0))).unwrap();
        let projection = Projection::Orthographic { height: 6.4 };
        let mut camera = Camera { eye: Vec3::Z * 9.0, look_at: Vec3::ZERO, up: Vec3::Y, projection };
        let before = Before::new(&scene, &camera);
        let step = Vec3::new(0.3, 0.2, 0.0);
        if moves_camera {
            (camera.eye, camera.look_at) = (camera.eye + step, camera.look_at + step);
        } else {
            scene
                .set_transform(ball, Mat4::from_translation(step) * Mat4::from_scale(Vec3::splat(2.0)))
                .unwrap();
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
        for (moves_camera, expected) in [(false, [3.0, -2.0]), (true, [-3.0, 2.0])] {
            let found = in_the_middle(moves_camera);
            assert!((0..2).all(|i: usize| (found[i] - expected[i]).abs() < 1e-3), "{found:?} {expected:?}");
        }
    }
}

//! A scene is drawn alike wherever it is and however large it is.

use conformance::reference;
use conformance::shape::{Build, Random, Shape};
use glam::{Mat4, Quat, Vec3};
use rtrt_core::backend::{Backend, Deferred, Picture, Request, Shadows};
use rtrt_core::scene::{Camera, Light, Projection, Scene};

/// Where a scene is, and how large.
#[derive(Clone, Copy)]
struct Place {
    at: Vec3,
    size: f32,
}

impl Place {
    const HERE: Self = Self { at: Vec3::ZERO, size: 1.0 };

    fn point(&self, p: Vec3) -> Vec3 {
        p * self.size + self.at
    }
}

/// A vector of whole 64ths: sums with whole numbers up to 2^17 are exact.
fn exact(random: &mut Random, size: f32) -> Vec3 {
    (random.vector(size) * 64.0).round() / 64.0
}

/// A random scene, there.
fn scene(seed: u64, place: Place) -> Scene {
    let mut random = Random(seed);
    let random = &mut random;
    let mut build = Build::default();
    let meshes = [Shape::cube(), Shape::ball(3), Shape::soup(random, 60, 0.4)].map(|shape| build.mesh(shape));
    let floor = build.mesh(Shape::floor(4.0, -1.0));
    build.instance(
        floor,
        Mat4::from_scale_rotation_translation(Vec3::splat(place.size), Quat::IDENTITY, place.at),
    );
    for number in 0..8 {
        let turn = Quat::from_scaled_axis(random.vector(3.0));
        let at = place.point(exact(random, 2.0));
        let size = (random.vector(0.4) + 0.5) * place.size;
        let to_world = Mat4::from_scale_rotation_translation(size, turn, at);
        let gray = build.gray;
        match number % 4 {
            0 => _ = build.scene.add_sphere(gray, to_world).expect("a transform that was tried"),
            mesh => _ = build.instance(meshes[mesh - 1], to_world),
        }
    }
    // Light fades with the square of the distance, and so with that of the size.
    let lamp = Light::point(place.point(Vec3::new(1.5, 3.0, 2.0)))
        .inverse_square(true)
        .color(Vec3::splat(30.0 * place.size * place.size))
        .radius(0.25 * place.size);
    let sun = Light::sun(Vec3::new(-1.0, -2.0, 0.5)).color(Vec3::splat(1.0)).radius(0.02);
    build.light(lamp).light(sun).scene
}

fn rendered(seed: u64, place: Place, shadows: Shadows) -> (Vec<u32>, Deferred) {
    let eye = place.point(Vec3::new(3.0, 2.0, 5.0));
    let look_at = place.point(Vec3::ZERO);
    let projection = Projection::Perspective { fov_y: 0.9 };
    let camera = Camera { eye, look_at, up: Vec3::Y, projection };
    let request = Request::new(&camera, [64, 48]).shadows(shadows).deferred(true);
    let mut picture = Picture::default();
    reference().render(&scene(seed, place), &request, &mut picture).unwrap();
    (picture.pixels, picture.deferred.take().unwrap())
}

#[test]
fn a_scene_scaled_by_a_power_of_two_has_the_same_pixels() {
    for seed in 0..6 {
        for shadows in [Shadows::Hard, Shadows::Soft] {
            let (pixels, deferred) = rendered(seed, Place::HERE, shadows);
            assert!(deferred.hits.iter().filter(|hit| hit.instance != u32::MAX).count() > 500);
            for power in [-6, 5, 14, -17] {
                let place = Place { size: libm::exp2f(power as f32), ..Place::HERE };
                let (other, scaled) = rendered(seed, place, shadows);
                let what = format!("seed {seed}, 2^{power}, {shadows:?}");
                assert!(deferred.masks == scaled.masks, "{what}: masks differ");
                let different = pixels.iter().zip(&other).position(|(a, b)| a != b);
                assert_eq!(different, None, "{what}");
            }
        }
    }
}

/// How many of so many shadow masks may differ: of points whose coordinates cannot tell which side of an edge of a
/// shadow they are on.
fn may_differ(masks: usize) -> usize {
    masks / 100
}

#[test]
fn a_scene_that_is_moved_has_the_same_hits_and_as_good_as_the_same_shadows() {
    for seed in 0..6 {
        let (pixels, deferred) = rendered(seed, Place::HERE, Shadows::Hard);
        for at in [Vec3::new(512.0, -256.0, 1024.0), Vec3::new(-32_768.0, 8_192.0, 16_384.0)] {
            let (other, moved) = rendered(seed, Place { at, ..Place::HERE }, Shadows::Hard);
            assert_eq!(deferred.hits, moved.hits, "seed {seed}, {at}");
            let masks = deferred.masks.iter().zip(&moved.masks).filter(|(a, b)| a != b).count();
            assert!(masks <= may_differ(deferred.masks.len()), "seed {seed}, {at}: {masks}");
            let apart = |a: u32, b: u32| {
                a.to_le_bytes().iter().zip(b.to_le_bytes()).map(|(a, b)| a.abs_diff(b)).max().unwrap_or(0)
            };
            let pixels = pixels.iter().zip(&other).filter(|(a, b)| apart(**a, **b) > 1).count();
            assert!(pixels <= may_differ(other.len()), "seed {seed}, {at}: {pixels}");
        }
    }
}

/// Without its own bound on rounding a far scene would shade itself, or lose its shadows: a bump of a fiftieth of
/// a unit far away has the shadow that it has near by.
#[test]
fn small_things_far_away_have_shadows() {
    let shadow = |at: f32| {
        let place = Place { at: Vec3::new(at, 0.0, 0.0), size: 1.0 };
        let mut build = Build::default();
        let (floor, cube) = (build.mesh(Shape::floor(1.0, 0.0)), build.mesh(Shape::cube()));
        build.instance(floor, Mat4::from_translation(place.at));
        // From 1/64 below the floor to 1/32 above it.
        let bump =
            Mat4::from_translation(place.point(Vec3::Y / 128.0)) * Mat4::from_scale(Vec3::splat(3.0 / 128.0));
        build.instance(cube, bump);
        let scene = build.light(Light::sun(Vec3::new(-1.0, -1.0, 0.0))).scene;
        let projection = Projection::Orthographic { height: 0.25 };
        let camera = Camera { eye: place.point(Vec3::Y), look_at: place.at, up: Vec3::NEG_Z, projection };
        let request = Request::new(&camera, [64, 64]).shadows(Shadows::Hard).deferred(true);
        let mut picture = Picture::default();
        reference().render(&scene, &request, &mut picture).unwrap();
        let deferred = picture.deferred.unwrap();
        deferred.masks.iter().filter(|&&mask| mask == 0).count()
    };
    // As wide as the bump and as long as it is high: 3/64 by 1/32, of 1/4 by 1/4 in 64 by 64 pixels.
    assert_eq!(shadow(0.0), 12 * 8);
    for at in [1024.0, -8192.0, 65_536.0] {
        // A pixel is 1/256 wide, a half of what coordinates of 65,536 tell apart.
        assert!(shadow(at).abs_diff(12 * 8) <= 24, "{at}: {}", shadow(at));
    }
}

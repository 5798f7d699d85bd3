//! Sub-rays that are shaded as one.

use conformance::cases;
use conformance::shape::{Build, Random, Shape};
use glam::{Mat4, Vec3};
use rtrt_core::backend::{Backend, Picture, Request, Shading, Shadows};
use rtrt_core::scene::{Camera, Light, Material, Projection, Scene};
use rtrt_core::stage::share::shaded;
use rtrt_cpu::{Cpu, Options};

const CAMERA: Camera = Camera {
    eye: Vec3::new(0.0, 1.0, 5.0),
    look_at: Vec3::ZERO,
    up: Vec3::Y,
    projection: Projection::Perspective { fov_y: 0.8 },
};

fn cpu(lanes: Option<u32>) -> Cpu {
    Cpu::new(Options { lanes, ..Options::default() }).expect("a backend")
}

fn render(cpu: &mut Cpu, scene: &Scene, request: &Request<'_>) -> Picture {
    let mut picture = Picture::default();
    cpu.render(scene, request, &mut picture).expect("a frame");
    picture
}

/// Without deferred buffers, rays of several blocks are shaded together.
#[test]
fn deferred_buffers_and_lanes_change_no_pixel() {
    let shared = cases::all().filter(|case| case.name.starts_with("share/"));
    // Larger than a group of blocks, and not a multiple of one.
    for case in shared {
        let request = case.request().size([203, 77]);
        let scene = (case.scene)();
        let whole = render(&mut cpu(Some(1)), &scene, &request);
        for lanes in [Some(1), Some(8), None] {
            let alone = render(&mut cpu(lanes), &scene, &request.deferred(false));
            assert_eq!(alone.pixels, whole.pixels, "{}, {lanes:?}", case.name);
        }
    }
}

/// Where a triangle has one color, it does not matter which of its sub-rays is shaded.
#[test]
fn surfaces_of_one_color_look_as_with_a_color_a_sample() {
    let mut build = Build::default();
    let mesh = build.mesh(Shape::ball(6));
    build.scene.ambient = Vec3::ZERO;
    let mut random = Random(7);
    for _ in 0..200 {
        let color = random.vector(1.0).abs().to_array();
        let glow = build.scene.add_material(Material::new([0.0; 3]).emission(color)).expect("a material");
        let place = Mat4::from_translation(random.vector(1.5)) * Mat4::from_scale(Vec3::splat(0.15));
        build.scene.add_instance(mesh, glow, place).expect("a place");
        build.scene.add_sphere(glow, Mat4::from_translation(random.vector(1.5)) * place).expect("a place");
    }
    for samples in [4, 16] {
        let request = Request::new(&CAMERA, [150, 90]).samples(samples).shadows(Shadows::Hard);
        let pictures = [Shading::Sample, Shading::Pixel]
            .map(|shading| render(&mut cpu(None), &build.scene, &request.shading(shading)).pixels);
        assert!(pictures[0] == pictures[1], "{samples}");
        assert_ne!(pictures[0], render(&mut cpu(None), &build.scene, &request.samples(1)).pixels);
    }
}

#[test]
fn few_sub_rays_are_shaded_and_all_where_that_cannot_be() {
    let shape = Shape::ball(3).and(Shape::floor(4.0, -1.0));
    let scene = Build::default().shape(shape).light(Light::point([2.0, 3.0, 3.0])).scene;
    let followers = |scene: &Scene, request: Request<'_>| {
        let request = request.shading(Shading::Pixel).deferred(true);
        let picture = render(&mut cpu(None), scene, &request);
        let hits = picture.deferred.expect("deferred buffers").hits;
        let taken = (0..).zip(&hits).filter(|(ray, hit)| shaded(*ray, hit) != *ray).count();
        (taken, (0..).zip(&hits).filter(|(ray, hit)| shaded(*ray, hit) == *ray).count())
    };
    let request = Request::new(&CAMERA, [160, 96]).samples(4).shadows(Shadows::Hard);
    let (taken, kept) = followers(&scene, request);
    assert!(taken * 10 > kept * 28 && taken < kept * 3, "{taken} {kept}");
    let mut soft = scene.clone();
    soft.add_light(Light::point([1.0, 4.0, 2.0]).radius(0.2));
    let mut glass = scene.clone();
    let pane = glass.add_material(Material::new([1.0; 3]).blend(0.5)).expect("a material");
    glass.add_sphere(pane, Mat4::from_scale(Vec3::splat(0.3))).expect("a place");
    let mut lit = scene.clone();
    lit.ambient = Vec3::ONE;
    for (scene, request) in [
        (&soft, request.shadows(Shadows::Soft)),
        (&soft, request.shadows(Shadows::Area { jitter: None })),
        (&glass, request),
        (&lit, request.ambient_occlusion(1.0)),
        (&scene, request.samples(1)),
    ] {
        assert_eq!(followers(scene, request).0, 0);
    }
}

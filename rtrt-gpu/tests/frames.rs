//! Frames on a GPU have the CPU's bits, in every buffer.

use glam::{Mat4, Vec3};
use rtrt_core::backend::{Backend, Picture, Request, Shadows};
use rtrt_core::compare::compare;
use rtrt_core::layout::{Attribute, Texture, Wrap};
use rtrt_core::scene::{Bvh, Camera, Image, Light, Material, Mesh, Projection, Scene, Sequential};
use rtrt_cpu::Cpu;
use rtrt_gpu::{Error, Gpu, Options, Route};

/// The GPU, or none after saying why.
fn open(options: Options) -> Option<Gpu> {
    match Gpu::new(options) {
        Ok(gpu) => Some(gpu),
        Err(error) => {
            assert!(std::env::var("RTRT_REQUIRE_GPU").as_deref() != Ok("1"), "a GPU is required: {error}");
            println!("skipped: {error}");
            None
        }
    }
}

fn numbers() -> impl FnMut() -> f32 {
    let mut state = 7_u32;
    move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 24) as f32
    }
}

/// Triangles strewn over a cube of side 2, with any normals, texture coordinates and colors.
fn shards(count: usize) -> Mesh {
    let mut next = numbers();
    let mut around = |scale: f32| [0; 3].map(|_| (next() - 0.5) * scale);
    let (mut positions, mut attributes) = (vec![], vec![]);
    for _ in 0..count {
        let center = around(2.0);
        for _ in 0..3 {
            let corner = around(0.5);
            positions.push([0, 1, 2].map(|axis| center[axis] + corner[axis]));
            let [u, v, w] = around(4.0);
            let color = [w.to_bits(), w.to_bits() | 0xffff_8080];
            attributes.push(Attribute { normal: around(2.0), uv: [u, v], color });
        }
    }
    Mesh::new(positions, attributes, (0..3 * count as u32).collect()).unwrap()
}

/// A square in the x–z plane.
fn floor() -> Mesh {
    let corners = [[-1.0, 0.0, -1.0], [1.0, 0.0, -1.0], [1.0, 0.0, 1.0], [-1.0, 0.0, 1.0]];
    let attribute = |p: [f32; 3]| Attribute {
        normal: [0.0, 1.0, 0.0],
        uv: [p[0] * 3.0, p[2] * 3.0],
        color: Attribute::WHITE,
    };
    Mesh::new(corners.to_vec(), corners.map(attribute).to_vec(), vec![0, 1, 2, 0, 2, 3]).unwrap()
}

/// `instances` heaps of shards over a textured floor, with some of every light.
fn heaps(instances: usize, lights: usize) -> Scene {
    let mut scene = Scene::new();
    let rgba = (0..29 * 13 * 4).map(|i| (i * 97 % 251) as u8).collect();
    let image = Image { width: 29, height: 13, rgba };
    let checks = scene.add_texture(&image, [Wrap::Repeat, Wrap::Mirror]).unwrap();
    let none = Texture { levels: 0, ..checks };
    let ground =
        scene.add_material(Material::new([0.9, 0.8, 0.7]).roughness(0.9).base_color_map(checks)).unwrap();
    let shiny = scene
        .add_material(
            Material::new([0.3, 0.5, 0.9])
                .metallic(0.6)
                .roughness(0.2)
                .base_color_map(none)
                .emission([0.01, 0.0, 0.02]),
        )
        .unwrap();
    let mut place = |mesh: &Mesh, material, at: &[Mat4]| {
        let mesh = scene.add_mesh(mesh, &Bvh::build(mesh, &Sequential)).unwrap();
        for &at in at {
            scene.add_instance(mesh, material, at).unwrap();
        }
    };
    place(&floor(), ground, &[Mat4::from_scale(Vec3::splat(20.0))]);
    let mut next = numbers();
    let mut at = vec![Mat4::IDENTITY];
    for _ in 1..instances {
        let turn = Mat4::from_rotation_y(next() * 6.0) * Mat4::from_rotation_x(next() * 3.0);
        let position = Vec3::new(next() * 10.0 - 5.0, next() * 2.0 + 0.5, next() * 10.0 - 5.0);
        at.push(Mat4::from_translation(position) * turn * Mat4::from_scale(Vec3::new(0.4, 0.6, 0.5)));
    }
    place(&shards(200), shiny, &at);
    for number in 0..lights {
        let [x, y, z] = [next(), next(), next()];
        let color = Vec3::new(0.5, 0.4, 0.3) + Vec3::new(z, x, y) * 0.3;
        scene.add_light(if number % 3 == 2 {
            Light::sun(Vec3::new(x - 0.5, -1.0, z - 0.5)).color(color)
        } else {
            let position = Vec3::new(x * 8.0 - 4.0, y * 3.0 + 2.0, z * 8.0 - 4.0);
            let reach = (number % 2 == 0).then_some(9.0);
            Light::point(position).color(color).reach(reach).inverse_square(number % 4 == 1)
        });
    }
    scene
}

const CAMERA: Camera = Camera {
    eye: Vec3::new(3.0, 2.5, 5.0),
    look_at: Vec3::new(0.0, 0.5, 0.0),
    up: Vec3::Y,
    projection: Projection::Perspective { fov_y: 0.9 },
};

/// What the backend makes of the request, with all buffers.
fn rendered(backend: &mut dyn Backend, scene: &Scene, request: &Request<'_>) -> Picture {
    let mut picture = Picture::default();
    backend.render(scene, request, &mut picture).unwrap();
    picture
}

/// The GPU's picture, which is the CPU's.
fn agree(gpu: &mut Gpu, what: &str, scene: &Scene, request: &Request<'_>) -> Picture {
    let mut cpu = Cpu::new(rtrt_cpu::Options { lanes: Some(1), threads: Some(1) }).unwrap();
    let expected = rendered(&mut cpu, scene, request);
    let actual = rendered(gpu, scene, request);
    if let Err(difference) = compare(request, &expected, &actual) {
        panic!("{what}: {difference}");
    }
    let total: f64 = actual.stages_ms.iter().sum();
    println!("{what}: equal; {total:.1} ms {:.1?}", actual.stages_ms);
    assert!(actual.pixels.iter().any(|pixel| *pixel != actual.pixels[0]) || scene.instances().is_empty());
    actual
}

fn request(size: [u32; 2], samples: u32) -> Request<'static> {
    Request::new(&CAMERA, size).samples(samples).deferred(true)
}

#[test]
fn passthrough_has_the_bits_of_the_cpu() {
    all_scenes(Route::Passthrough);
}

#[test]
fn naga_has_the_bits_of_the_cpu() {
    all_scenes(Route::Naga);
}

fn all_scenes(route: Route) {
    let Some(mut gpu) = open(Options { route, ..Options::default() }) else { return };
    agree(&mut gpu, "nothing", &Scene::new(), &request([40, 30], 1));
    agree(&mut gpu, "one heap", &heaps(1, 1), &request([160, 90], 1));
    agree(&mut gpu, "odd size", &heaps(1, 2), &request([131, 77], 4));
    agree(&mut gpu, "sixteen samples", &heaps(2, 1), &request([37, 21], 16));
    agree(&mut gpu, "many heaps", &heaps(40, 3), &request([160, 90], 1));
    agree(&mut gpu, "many lights", &heaps(5, 35), &request([64, 36], 1));
    let dark = request([64, 36], 1).shadows(Shadows::Off);
    agree(&mut gpu, "no shadows", &heaps(5, 3), &dark);
    let flat = Camera { projection: Projection::Orthographic { height: 6.0 }, ..CAMERA };
    agree(&mut gpu, "parallel", &heaps(5, 3), &request([64, 36], 1).camera(&flat));
    let inside = Camera { eye: Vec3::new(0.1, 0.1, 0.1), ..CAMERA };
    agree(&mut gpu, "inside", &heaps(9, 3), &request([64, 36], 1).camera(&inside));
}

#[test]
fn light_too_faint_to_count_is_nothing_everywhere() {
    // Devices that flush denormals and processors that keep them must not see any.
    let Some(mut gpu) = open(Options::default()) else { return };
    let mut scene = Scene::new();
    let polished = scene.add_material(Material::new([1e-18; 3]).metallic(0.1).roughness(0.33)).unwrap();
    let mesh = shards(200);
    let mesh = scene.add_mesh(&mesh, &Bvh::build(&mesh, &Sequential)).unwrap();
    scene.add_instance(mesh, polished, Mat4::IDENTITY).unwrap();
    scene.ambient = Vec3::ZERO;
    for (color, distance) in [(1.0, 1e2), (1e-3, 1e4), (1e-15, 3.0), (1e-30, 3.0), (1e-40, 3.0)] {
        let position = Vec3::new(distance, 3.0, distance);
        let color = Vec3::splat(color);
        scene.add_light(Light::point(position).color(color).inverse_square(true));
        let picture = agree(&mut gpu, "faint", &scene, &request([128, 72], 1));
        let deferred = picture.deferred.unwrap();
        let numbers: [&[f32]; 2] =
            [bytemuck::cast_slice(&deferred.lit), bytemuck::cast_slice(&deferred.colors)];
        assert!(!numbers.concat().iter().any(|number| number.is_subnormal()));
    }
}

#[test]
fn a_changed_scene_is_uploaded_again() {
    let Some(mut gpu) = open(Options::default()) else { return };
    let mut scene = heaps(3, 2);
    let request = request([64, 36], 1);
    agree(&mut gpu, "before", &scene, &request);
    let moved = scene.instance_index(2).unwrap();
    scene.set_transform(moved, Mat4::from_scale(Vec3::splat(0.7))).unwrap();
    agree(&mut gpu, "moved", &scene, &request);
    let red = scene.add_material(Material::new([0.9, 0.1, 0.1]).roughness(0.5)).unwrap();
    let mesh = shards(50);
    let mesh = scene.add_mesh(&mesh, &Bvh::build(&mesh, &Sequential)).unwrap();
    scene.add_instance(mesh, red, Mat4::from_translation(Vec3::new(1.0, 1.0, 1.0))).unwrap();
    agree(&mut gpu, "more", &scene, &request);
    agree(&mut gpu, "another", &heaps(2, 0), &request);
}

#[test]
fn lists_longer_than_their_room_are_made_again() {
    let Some(mut gpu) = open(Options::default()) else { return };
    let scene = heaps(700, 1);
    let long = request([320, 180], 1);
    agree(&mut gpu, "long lists", &scene, &long);
    agree(&mut gpu, "the same again", &scene, &long);
    let aside = Camera { eye: Vec3::new(-3.0, 2.5, 5.0), ..CAMERA };
    agree(&mut gpu, "another camera", &scene, &long.camera(&aside));
    let entries = rendered(&mut gpu, &scene, &long).deferred.unwrap().lists.len() / 2;
    assert!(entries > 1 << 16, "{entries} entries fit at once: the test shows nothing");
}

#[test]
fn no_pixel_depends_on_bands() {
    let Some(mut gpu) = open(Options { band_bytes: Some(200_000), ..Options::default() }) else { return };
    agree(&mut gpu, "bands", &heaps(6, 2), &request([131, 77], 4));
    let mut scene = heaps(6, 2);
    for light in scene.lights_mut() {
        light.radius = 0.2;
    }
    agree(&mut gpu, "bands with soft shadows", &scene, &request([131, 177], 4));
}

#[test]
fn the_device_finds_every_field_where_the_compiler_puts_it() {
    let Some(gpu) = open(Options::default()) else { return };
    assert_eq!(gpu.layout().unwrap(), Gpu::expected_layout());
}

#[test]
fn an_adapter_that_is_not_there_is_named() {
    let error = Gpu::new(Options { adapter: Some("abacus".into()), ..Options::default() }).err().unwrap();
    assert!(matches!(&error, Error::AdapterNotFound { wanted, .. } if wanted == "abacus"), "{error}");
}

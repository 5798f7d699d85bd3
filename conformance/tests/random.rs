//! Scenes, cameras and lights that nobody thought of.
//!
//! `RTRT_SEEDS=1000..2000` runs those seeds instead of the usual ones.

use conformance::oracle::{brute, wide};
use conformance::reference;
use conformance::shape::{Build, Random, Shape};
use conformance::variants::{all, present, requires_gpu};
use glam::{Mat4, Quat, Vec3};
use rtrt_core::backend::{Backend, Picture, Request, Shadows};
use rtrt_core::compare::compare;
use rtrt_core::layout::Wrap;
use rtrt_core::scene::{
    AlphaMode, Camera, Image, Light, Material, MaterialIndex, Panorama, Projection, Scene,
};
use std::ops::Range;

fn seeds() -> Range<u64> {
    let Ok(seeds) = std::env::var("RTRT_SEEDS") else { return 0..108 };
    let (first, last) = seeds.split_once("..").expect("RTRT_SEEDS is FIRST..LAST");
    first.parse().expect("a number")..last.parse().expect("a number")
}

/// A number whose logarithm is spread evenly.
fn any_size(random: &mut Random, low: f32, high: f32) -> f32 {
    libm::powf(10.0, random.within(low, high))
}

fn shape(random: &mut Random) -> Shape {
    match random.below(5) {
        0 => Shape::cube(),
        1 => Shape::ball(2 + random.below(5)),
        2 => Shape::floor(1.0, 0.0),
        _ => {
            let (count, size) = (1 + random.below(150), any_size(random, -2.0, 0.5));
            Shape::soup(random, count, size)
        }
    }
}

/// A transform: turned, stretched, sometimes mirrored, sometimes the identity.
fn transform(random: &mut Random) -> Mat4 {
    if random.below(4) == 0 {
        return Mat4::IDENTITY;
    }
    let axis = random.vector(1.0).normalize_or(Vec3::X);
    let turn = Quat::from_axis_angle(axis, random.within(0.0, 6.0));
    let size = any_size(random, -1.0, 0.5);
    let scale = if random.below(2) == 0 { Vec3::splat(size) } else { random.vector(size) + 0.01 };
    Mat4::from_scale_rotation_translation(scale, turn, random.vector(3.0))
}

fn light(random: &mut Random) -> Light {
    let casts_shadows = random.below(6) > 0;
    shining(random).casts_shadows(casts_shadows)
}

fn shining(random: &mut Random) -> Light {
    let color = (random.vector(0.5) + 0.5) * 1.5;
    let radius = if random.below(3) == 0 { any_size(random, -2.0, -0.2) } else { 0.0 };
    if random.below(3) == 0 {
        return Light::sun(random.vector(1.0) + Vec3::splat(1e-3)).color(color).radius(radius);
    }
    let reach = (random.below(2) == 0).then(|| any_size(random, -0.5, 1.5));
    let (position, inverse_square) = (random.vector(4.0), random.below(2) == 0);
    if random.below(3) == 0 {
        let outer = random.within(0.05, 1.55);
        let inner = outer * random.within(0.0, 1.0);
        let direction = -position + random.vector(1.0);
        return Light::spot(position, direction, outer)
            .color(color)
            .reach(reach)
            .inverse_square(inverse_square)
            .inner(inner)
            .radius(radius);
    }
    Light::point(position).color(color).reach(reach).inverse_square(inverse_square).radius(radius)
}

fn shadows(random: &mut Random) -> Shadows {
    match random.below(8) {
        0 => Shadows::Off,
        1 => Shadows::Hard,
        2 => Shadows::Area { jitter: None },
        3 => Shadows::Area { jitter: Some(random.bits()) },
        _ => Shadows::Soft,
    }
}

/// A thousand small instances: many that end where a block ends.
fn swarm(random: &mut Random) -> Scene {
    let mut build = Build::default().shape(Shape::floor(4.0, -2.0));
    let mesh = build.mesh(shape_of_few(random));
    for _ in 0..1200 {
        let turn = Mat4::from_rotation_y(random.within(0.0, 6.0));
        let size = Mat4::from_scale(Vec3::splat(any_size(random, -2.0, -1.0)));
        build.instance(mesh, Mat4::from_translation(random.vector(2.0)) * turn * size);
    }
    (0..1 + random.below(3)).fold(build, |build, _| build.light(light(random))).scene
}

fn shape_of_few(random: &mut Random) -> Shape {
    let one = Shape::triangle([[-1.0, -0.8, 0.2], [1.0, -0.6, -0.3], [0.1, 1.0, 0.4]]);
    if random.below(3) == 0 { Shape::cube() } else { one }
}

/// A material that blends or is masked, some with a texture whose alpha varies.
fn see_through(random: &mut Random, build: &mut Build) -> MaterialIndex {
    let mut material = Material::new((random.vector(0.5) + 0.5).to_array()).roughness(0.5);
    material.alpha = random.within(0.0, 1.2);
    material.double_sided = random.below(2) == 1;
    material.alpha_mode =
        if random.below(3) == 0 { AlphaMode::Mask { cutoff: 0.5 } } else { AlphaMode::Blend };
    if random.below(2) == 0 {
        let rgba = (0..4 * 7 * 5).map(|_| random.bits() as u8).collect();
        let wrap = [Wrap::Repeat, Wrap::Clamp, Wrap::Mirror][random.below(3) as usize];
        let map = build.scene.add_texture(&Image { width: 7, height: 5, rgba }, [wrap; 2]).expect("room");
        material.base_color_map = Some(map);
    }
    build.scene.add_material(material).expect("a case's material")
}

fn scene(random: &mut Random) -> Scene {
    let mut build = Build::default();
    let opaque = Material::new([0.6; 3]).roughness(0.7);
    let one_sided = opaque.double_sided(false);
    let one_sided = build.scene.add_material(one_sided).expect("a case's material");
    let meshes: Vec<_> = (0..1 + random.below(4)).map(|_| shape(random)).map(|s| build.mesh(s)).collect();
    let materials: Vec<_> = (0..3).map(|_| see_through(random, &mut build)).collect();
    // In half of the scenes everything is opaque.
    let clear = random.below(2);
    for _ in 0..1 + random.below(20) {
        let mesh = meshes[random.below(meshes.len() as u32) as usize];
        let place = transform(random);
        let gray = if random.below(3) == 0 { one_sided } else { build.gray };
        if random.below(6) == 0 {
            build.scene.add_sphere(gray, place).expect("a transform that was tried");
        } else if clear * random.below(3) == 0 {
            build.scene.add_instance(mesh, gray, place).expect("a transform that was tried");
        } else {
            let material = materials[random.below(3) as usize];
            let added = match random.below(5) {
                0 => build.scene.add_sphere(material, place),
                _ => build.scene.add_instance(mesh, material, place),
            };
            added.expect("a transform that was tried");
        }
    }
    let mut scene = (0..random.below(5)).fold(build, |build, _| build.light(light(random))).scene;
    if random.below(4) == 0 {
        surround(random, &mut scene);
    }
    if random.below(3) == 0 {
        change(random, &mut scene);
    }
    scene
}

/// An environment of a few pixels, some of them bright.
fn surround(random: &mut Random, scene: &mut Scene) {
    let (width, height) = (2 + random.below(9), 1 + random.below(6));
    let rgb = (0..width * height).map(|_| [0; 3].map(|_| any_size(random, -3.0, 1.5))).collect();
    scene.set_environment(&Panorama { width, height, rgb }).expect("a panorama");
}

/// Objects that are elsewhere than at first, and some that are hidden.
fn change(random: &mut Random, scene: &mut Scene) {
    for number in 0..scene.instances().len() as u32 {
        let instance = scene.instance_index(number).expect("it is there");
        match random.below(4) {
            0 => scene.hide(instance).expect("it is there"),
            1 => scene.set_transform(instance, transform(random)).expect("a transform that was tried"),
            _ => {}
        }
    }
}

fn camera(random: &mut Random) -> Camera {
    let projection = match random.below(4) {
        0 => Projection::Orthographic { height: any_size(random, -1.0, 1.0) },
        1 => Projection::Perspective { fov_y: random.within(0.01, 3.0) },
        _ => Projection::Perspective { fov_y: 1.0 },
    };
    let far = any_size(random, -0.5, 4.0);
    let eye = random.vector(far);
    // A narrow field of view for distant scenes, so that the picture is not empty.
    let projection = match projection {
        Projection::Perspective { fov_y } if far > 10.0 => {
            Projection::Perspective { fov_y: fov_y * 8.0 / far }
        }
        other => other,
    };
    Camera { eye, look_at: random.vector(1.0), up: random.vector(1.0), projection }
}

/// What a seed gives.
struct Given {
    scene: Scene,
    camera: Camera,
    /// Whether it is a [`swarm`].
    is_swarm: bool,
    size: [u32; 2],
    clip: [f32; 2],
    reach: f32,
    samples: u32,
    shadows: Shadows,
    layers: u32,
}

impl Given {
    fn new(seed: u64) -> Self {
        let mut random = Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let is_swarm = seed.is_multiple_of(6);
        let mut scene = if is_swarm { swarm(&mut random) } else { scene(&mut random) };
        let camera = camera(&mut random);
        let size = if is_swarm { [61, 45] } else { [1 + random.below(40), 1 + random.below(30)] };
        let away = camera.eye.length();
        let (near, far) = (away * random.within(-3.0, 1.0).max(0.0), away * random.within(1.0, 3.0));
        let far = if random.below(4) == 0 { far } else { f32::INFINITY };
        let reach = if random.below(3) == 0 { random.within(0.1, 4.0) } else { 0.0 };
        scene.ambient = Vec3::splat(if reach > 0.0 { 0.5 } else { 0.0 });
        Self {
            scene,
            camera,
            is_swarm,
            size,
            clip: [near, far],
            reach,
            samples: [1, 1, 1, 1, 1, 4, 4, 16][random.below(8) as usize],
            shadows: shadows(&mut random),
            layers: [1, 2, 3, 8][random.below(4) as usize],
        }
    }

    fn request(&self) -> Request<'_> {
        Request::new(&self.camera, self.size)
            .clip(self.clip[0], self.clip[1])
            .ambient_occlusion(self.reach)
            .samples(self.samples)
            .shadows(self.shadows)
            .layers(self.layers)
            .deferred(true)
    }
}

#[test]
fn the_reference_is_what_the_oracles_say_on_random_scenes() {
    let mut reference = reference();
    let mut expected = Picture::default();
    let (mut cast, mut hits, mut rays, mut judged) = (0, 0, 0, 0);
    for seed in seeds() {
        let given = Given::new(seed);
        let (scene, request) = (&given.scene, given.request());
        reference.render(scene, &request, &mut expected).unwrap_or_else(|why| panic!("seed {seed}: {why}"));
        brute::check(scene, &request, &expected, 1).unwrap_or_else(|why| panic!("seed {seed}: {why}"));
        let seen = wide::check(scene, &request, &expected, if given.is_swarm { 11 } else { 1 });
        let seen = seen.unwrap_or_else(|why| panic!("seed {seed}: {why}"));
        (rays, judged) = (rays + seen.rays, judged + seen.judged);
        cast += (request.size[0] * request.size[1] * request.samples) as usize;
        hits += expected.deferred.iter().flat_map(|d| &d.hits).filter(|hit| hit.instance != u32::MAX).count();
    }
    assert!(hits * 5 > cast && judged * 4 > rays, "{hits} hits on {cast} rays, {judged} of {rays} judged");
}

#[test]
fn every_variant_equals_the_reference_on_random_scenes() {
    let mut reference = reference();
    let mut variants = present(all(), requires_gpu());
    assert_eq!(variants.failed, 0);
    let (mut expected, mut actual) = (Picture::default(), Picture::default());
    for seed in seeds() {
        let given = Given::new(seed);
        let (scene, request) = (&given.scene, given.request());
        reference.render(scene, &request, &mut expected).unwrap_or_else(|why| panic!("seed {seed}: {why}"));
        for (name, backend) in &mut variants.backends {
            let rendered = backend.render(scene, &request, &mut actual);
            rendered.unwrap_or_else(|why| panic!("seed {seed}, {name}: {why}"));
            let compared = compare(&request, &expected, &actual);
            compared.unwrap_or_else(|why| panic!("seed {seed}, {name}: {why}"));
        }
    }
}

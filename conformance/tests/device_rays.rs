//! Rays on a device, by both routes, against the world's own answers.

use conformance::shape::Random;
use conformance::variants::requires_gpu;
use glam::{Mat4, Vec3};
use rtrt_core::layout::Hit as HitRecord;
use rtrt_core::query::{Hit, Ray, Sides, Tree, World};
use rtrt_core::scene::{Attribute, Bvh, Image, InstanceIndex, Material, Mesh, Scene, Sequential, Wrap};
use rtrt_gpu::{Error, Gpu, Options, Route, wgpu};

/// Meshes and spheres of all kinds of materials and masks; the last is hidden.
fn world(random: &mut Random) -> (Scene, Vec<InstanceIndex>) {
    let mut point = |size: f32| [(); 3].map(|()| random.within(-size, size));
    let positions: Vec<_> = (0..300).map(|_| point(1.0)).collect();
    let attribute = |i: usize| Attribute {
        normal: [0.0; 3],
        uv: [(i % 7) as f32 * 0.4, (i % 5) as f32 * 0.3],
        color: Attribute::WHITE,
    };
    let mesh = Mesh::new(positions, (0..300).map(attribute).collect(), (0..300).collect()).expect("a mesh");
    let mut scene = Scene::new();
    let image = Image { width: 4, height: 4, rgba: (0..64).map(|i| (i * 37 % 256) as u8).collect() };
    let holes = scene.add_texture(&image, [Wrap::Repeat; 2]).expect("a texture");
    let materials = [
        Material::default().double_sided(true),
        Material::default().double_sided(false),
        Material::default().base_color_map(holes).mask(0.5),
    ];
    let materials = materials.map(|material| scene.add_material(material).expect("a material"));
    let mesh = scene.add_mesh(&mesh, &Bvh::build(&mesh, &Sequential)).expect("a mesh");
    let mut instances = vec![];
    for number in 0..60 {
        let turn = glam::Quat::from_scaled_axis(Vec3::from(point(3.0)));
        let scale = Vec3::new(0.7, if number % 4 == 1 { -1.5 } else { 1.5 }, 1.0);
        let place = Mat4::from_scale_rotation_translation(scale, turn, Vec3::from(point(4.0)));
        let place = if number == 0 { Mat4::IDENTITY } else { place };
        let material = materials[number % 3];
        let instance = if number % 5 == 4 {
            scene.add_sphere(material, place)
        } else {
            scene.add_instance(mesh, material, place)
        };
        instances.push(instance.expect("an instance"));
        scene.set_ray_mask(instances[number], 1 << (number % 4)).expect("it is there");
    }
    scene.hide(instances[59]).expect("it is there");
    (scene, instances)
}

/// Rays of every kind, some of which are refused.
fn rays(random: &mut Random, instances: &[InstanceIndex]) -> Vec<Ray> {
    let ray = |number: usize| {
        let mut point = |size: f32| [(); 3].map(|()| random.within(-size, size));
        let mut ray = Ray::new(point(5.0), point(1.0));
        match number % 11 {
            0 => ray = ray.until(4.0),
            1 => ray = ray.starting(3.0),
            2 => ray = ray.mask(0b0110),
            3 => ray = ray.skip(instances[number % instances.len()]),
            4 => ray = ray.through_holes(),
            5 => ray.direction = ray.direction.map(|c| c * 1e30),
            6 => ray.direction = ray.direction.map(|c| c * 1e-30),
            7 => ray.direction = [1.0, 0.0, 0.0],
            _ => {}
        }
        match number {
            77 => ray.direction = [0.0; 3],
            78 => ray.origin[1] = f32::NAN,
            79 => ray.to = f32::NAN,
            _ => {}
        }
        ray.sides([Sides::Both, Sides::Fronts, Sides::Backs, Sides::Drawn][number % 4])
    };
    (0..4000).map(ray).collect()
}

/// Compares all of what a device says, and the same through buffers of a caller's.
fn check(gpu: &Gpu, scene: &Scene, world: &World<'_>, rays: &[Ray]) {
    let expected: Vec<_> = rays.iter().map(|ray| world.closest(ray)).collect();
    let hidden: Vec<_> = rays.iter().map(|ray| world.occluded(ray)).collect();
    assert!(expected.iter().filter(|hit| matches!(hit, Ok(Some(_)))).count() > 1000);
    assert!(hidden.iter().filter(|hit| **hit == Ok(false)).count() > 100);
    let on_device = gpu.world(scene, &Sequential).expect("a world");
    let (mut hits, mut met) = (vec![Ok(None); rays.len()], vec![Ok(false); rays.len()]);
    on_device.closest(rays, &mut hits).expect("answers");
    on_device.occluded(rays, &mut met).expect("answers");
    for ((ray, hit), expected) in rays.iter().zip(&hits).zip(&expected) {
        let bits =
            |hit: &Hit| (hit.t.to_bits(), hit.instance, hit.triangle, hit.u.to_bits(), hit.v.to_bits());
        let [hit, expected] = [hit, expected].map(|hit| hit.as_ref().map(|hit| hit.as_ref().map(bits)));
        // NaN is in some errors, which is not equal to itself.
        assert_eq!(format!("{hit:?}"), format!("{expected:?}"), "{ray:?}");
    }
    assert_eq!(format!("{met:?}"), format!("{hidden:?}"));
    // Slices of different lengths, and none.
    let mut few = [Ok(None); 3];
    on_device.closest(rays, &mut few).expect("answers");
    assert_eq!(few[..], hits[..3]);
    on_device.closest(&[], &mut few).expect("no answers");
}

/// Compares what a device writes to a buffer of the caller's.
fn check_buffers(gpu: &Gpu, scene: &Scene, world: &World<'_>, rays: &[Ray]) {
    let (device, queue) = gpu.device();
    let on_device = gpu.world(scene, &Sequential).expect("a world");
    let records: Vec<_> = rays.iter().map(|ray| on_device.record(ray).expect("a ray")).collect();
    let buffer = |bytes: usize, usage| {
        let (size, mapped_at_creation) = (bytes as u64, false);
        device.create_buffer(&wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation })
    };
    let storage = wgpu::BufferUsages::STORAGE;
    let given = buffer(48 * rays.len(), storage | wgpu::BufferUsages::COPY_DST);
    let bytes = 20 * rays.len();
    let taken = buffer(bytes, storage | wgpu::BufferUsages::COPY_SRC);
    let read = buffer(bytes, wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ);
    queue.write_buffer(&given, 0, bytemuck::cast_slice(&records));
    let mut commands = device.create_command_encoder(&Default::default());
    let count = rays.len() as u32;
    assert!(matches!(
        on_device.encode_closest(&mut commands, &given, &taken, count + 1),
        Err(Error::BufferTooShort { .. })
    ));
    on_device.encode_closest(&mut commands, &given, &taken, count).expect("commands");
    commands.copy_buffer_to_buffer(&taken, 0, &read, 0, bytes as u64);
    queue.submit([commands.finish()]);
    read.map_async(wgpu::MapMode::Read, .., |mapped| mapped.expect("mapped"));
    device.poll(wgpu::PollType::wait_indefinitely()).expect("done");
    let found: Vec<HitRecord> = bytemuck::pod_collect_to_vec(&read.get_mapped_range(..).expect("mapped")[..]);
    for (ray, found) in rays.iter().zip(&found) {
        assert_eq!(on_device.hit(ray, found), world.closest(ray).expect("a ray"), "{ray:?}");
    }
}

#[test]
fn answers_are_those_of_the_world_to_the_bit() {
    let mut random = Random(3);
    let (scene, instances) = world(&mut random);
    let mut tree = Tree::default();
    let asked = tree.world(&scene);
    let rays = rays(&mut random, &instances);
    for route in [Route::Passthrough, Route::Naga] {
        match Gpu::new(Options { route, ..Options::default() }) {
            Ok(gpu) => {
                check(&gpu, &scene, &asked, &rays);
                check_buffers(&gpu, &scene, &asked, &rays[..77]);
            }
            Err(error) => assert!(!requires_gpu(), "{error}"),
        }
    }
}

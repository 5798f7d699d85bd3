//! Rays on a device, by both routes, against the world's own answers.

use conformance::shape::Random;
use conformance::variants::requires_gpu;
use glam::{Mat4, Vec3};
use rtrt_core::layout::{Hit as HitRecord, Instance};
use rtrt_core::query::{Hit, Ray, Sides, Tree, World};
use rtrt_core::scene::{
    Attribute, Bvh, Image, InstanceIndex, Material, MaterialIndex, Mesh, MeshIndex, Scene, Sequential, Wrap,
};
use rtrt_gpu::{Error, Gpu, Options, Route, wgpu};

/// A hundred triangles within a cube.
fn heap(random: &mut Random) -> Mesh {
    let positions: Vec<_> = (0..300).map(|_| random.vector(1.0).to_array()).collect();
    let attribute = |i: usize| Attribute {
        normal: [0.0; 3],
        uv: [(i % 7) as f32 * 0.4, (i % 5) as f32 * 0.3],
        color: Attribute::WHITE,
    };
    Mesh::new(positions, (0..300).map(attribute).collect(), (0..300).collect()).expect("a mesh")
}

/// A texture with holes, by this number.
fn holes(scene: &mut Scene, step: usize) -> Material {
    let image = Image { width: 4, height: 4, rgba: (0..64).map(|i| (i * step % 256) as u8).collect() };
    let holes = scene.add_texture(&image, [Wrap::Repeat; 2]).expect("a texture");
    Material::default().base_color_map(holes).mask(0.5)
}

/// A place in the world, turned and scaled; some are mirrored.
fn place(random: &mut Random, number: usize) -> Mat4 {
    let turn = glam::Quat::from_scaled_axis(random.vector(3.0));
    let scale = Vec3::new(0.7, if number % 4 == 1 { -1.5 } else { 1.5 }, 1.0);
    Mat4::from_scale_rotation_translation(scale, turn, random.vector(4.0))
}

/// A scene with indices of what is in it.
struct Made {
    scene: Scene,
    mesh: MeshIndex,
    /// A mesh that nothing has.
    spare: Option<MeshIndex>,
    materials: [MaterialIndex; 3],
    instances: Vec<InstanceIndex>,
}

/// Meshes and spheres of all kinds of materials and masks; the last is hidden.
fn world(random: &mut Random) -> Made {
    let mesh = heap(random);
    let mut scene = Scene::new();
    let holes = holes(&mut scene, 37);
    let materials = [Material::default().double_sided(true), Material::default().double_sided(false), holes];
    let materials = materials.map(|material| scene.add_material(material).expect("a material"));
    let mesh = scene.add_mesh(&mesh, &Bvh::build(&mesh, &Sequential)).expect("a mesh");
    let mut instances = vec![];
    for number in 0..60 {
        let place = if number == 0 { Mat4::IDENTITY } else { place(random, number) };
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
    Made { scene, mesh, spare: None, materials, instances }
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

/// Compares all of what a device says.
fn check(on_device: &rtrt_gpu::World, world: &World<'_>, rays: &[Ray]) {
    let expected: Vec<_> = rays.iter().map(|ray| world.closest(ray)).collect();
    let hidden: Vec<_> = rays.iter().map(|ray| world.occluded(ray)).collect();
    assert!(expected.iter().filter(|hit| matches!(hit, Ok(Some(_)))).count() > rays.len() / 5);
    assert!(hidden.iter().filter(|hit| **hit == Ok(false)).count() > rays.len() / 40);
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
fn check_buffers(gpu: &Gpu, on_device: &rtrt_gpu::World, world: &World<'_>, rays: &[Ray]) {
    let (device, queue) = gpu.device();
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

/// Opens the GPU by both routes.
fn gpus() -> impl Iterator<Item = Gpu> {
    [Route::Passthrough, Route::Naga].into_iter().filter_map(|route| {
        let gpu = Gpu::new(Options { route, ..Options::default() });
        gpu.inspect_err(|error| assert!(!requires_gpu(), "{error}")).ok()
    })
}

#[test]
fn answers_are_those_of_the_world_to_the_bit() {
    let mut random = Random(3);
    let Made { scene, instances, .. } = world(&mut random);
    let mut tree = Tree::default();
    let asked = tree.world(&scene);
    let rays = rays(&mut random, &instances);
    for gpu in gpus() {
        let on_device = gpu.world(&scene, &Sequential).expect("a world");
        check(&on_device, &asked, &rays);
        check_buffers(&gpu, &on_device, &asked, &rays[..77]);
    }
}

/// Something that happens to a scene.
type Step = fn(&mut Made, &mut Random);

/// What a world has to follow.
const STEPS: [(&str, Step); 20] = [
    ("nothing happens", |_, _| {}),
    ("one moves", |made, random| {
        made.scene.set_transform(made.instances[7], place(random, 7)).expect("a place");
    }),
    ("a mesh and a sphere hide", |made, _| {
        made.instances[5..10].iter().for_each(|&i| made.scene.hide(i).expect("it is there"));
    }),
    ("some move, and one of them is seen again", |made, random| {
        let moved: Vec<_> = (0..20).map(|i| (made.instances[3 * i], place(random, i))).collect();
        made.scene.set_transforms(moved).expect("places");
    }),
    ("one gets other groups", |made, _| {
        made.scene.set_ray_mask(made.instances[12], 0b1110).expect("it is there");
        made.scene.set_ray_mask(made.instances[13], 0).expect("it is there");
    }),
    ("all move, more often than is remembered", |made, random| {
        for _ in 0..3 {
            let moved = made.instances.iter().map(|&i| (i, place(random, i.number() as usize)));
            made.scene.set_transforms(moved).expect("places");
        }
        made.scene.hide(made.instances[20]).expect("it is there");
    }),
    ("one becomes flat and large", |made, _| {
        let scale = Mat4::from_scale(Vec3::new(9.0, 1e-3, 9.0));
        made.scene.set_transform(made.instances[1], scale).expect("a place");
    }),
    ("a mesh gets another shape", |made, random| {
        made.scene.reshape(made.mesh, &heap(random)).expect("as many triangles");
    }),
    ("a material is drawn from both sides", |made, _| {
        let both = Material::default().double_sided(true);
        made.scene.set_material(made.materials[1], both).expect("a material");
    }),
    ("a material has other holes", |made, _| {
        let holes = holes(&mut made.scene, 53);
        made.scene.set_material(made.materials[2], holes).expect("a material");
    }),
    ("there is one more", |made, random| {
        let more = made.scene.add_instance(made.mesh, made.materials[1], place(random, 60));
        made.instances.push(more.expect("a place"));
    }),
    ("there is one more mesh, seen nowhere", |made, random| {
        let mesh = heap(random);
        made.mesh = made.scene.add_mesh(&mesh, &Bvh::build(&mesh, &Sequential)).expect("a mesh");
    }),
    ("it is seen, and another moves", |made, random| {
        let more = made.scene.add_instance(made.mesh, made.materials[2], place(random, 61));
        made.instances.push(more.expect("a place"));
        made.scene.set_transform(made.instances[2], place(random, 2)).expect("a place");
    }),
    ("one is removed", |made, _| made.scene.remove_instance(made.instances[30]).expect("it is there")),
    ("a sphere has its number", |made, random| {
        let more = made.scene.add_sphere(made.materials[0], place(random, 30)).expect("a place");
        assert_eq!(more.number(), made.instances[30].number());
        made.instances[30] = more;
    }),
    ("there are two more meshes, one of them seen", |made, random| {
        let [spare, mesh] = [(); 2].map(|()| {
            let mesh = heap(random);
            made.scene.add_mesh(&mesh, &Bvh::build(&mesh, &Sequential)).expect("a mesh")
        });
        (made.spare, made.mesh) = (Some(spare), mesh);
        let more = made.scene.add_instance(mesh, made.materials[2], place(random, 62));
        made.instances.push(more.expect("a place"));
    }),
    ("the other is removed, and what follows it lies elsewhere", |made, _| {
        let spare = made.spare.expect("a mesh");
        made.scene.remove_mesh(spare).expect("it has no instances");
    }),
    ("it is a clone", |made, _| made.scene = made.scene.clone()),
    ("two move in the clone", |made, random| {
        made.scene.set_transform(made.instances[61], place(random, 3)).expect("a place");
        made.scene.set_transform(made.instances[60], place(random, 4)).expect("a place");
    }),
    ("it is another scene, as large", |made, random| *made = world(random)),
];

#[test]
fn a_world_that_follows_answers_as_a_new_one_whatever_happens() {
    // What is copied does not depend on the route.
    let Some(gpu) = gpus().next() else { return };
    let mut random = Random(8);
    let mut made = world(&mut random);
    let mut tree = Tree::default();
    let empty = Scene::new();
    // A new world is one that was empty.
    let [mut following, mut fresh] = [(); 2].map(|()| gpu.world(&empty, &Sequential).expect("a world"));
    for (name, step) in STEPS {
        println!("{name}");
        step(&mut made, &mut random);
        following.update(&made.scene, &Sequential).expect("an update");
        fresh.update(&empty, &Sequential).expect("an update");
        fresh.update(&made.scene, &Sequential).expect("an update");
        let asked = tree.world(&made.scene);
        let rays = rays(&mut random, &made.instances);
        check(&following, &asked, &rays[80..800]);
        check(&fresh, &asked, &rays[80..300]);
        check_buffers(&gpu, &following, &asked, &rays[..77]);
    }
    following.update(&empty, &Sequential).expect("an update");
    let mut hits = [Ok(None); 9];
    following.closest(&rays(&mut random, &made.instances)[..9], &mut hits).expect("answers");
    assert_eq!(hits, [Ok(None); 9]);
}

#[test]
fn a_world_that_cannot_follow_is_empty_until_it_can() {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let Ok(adapter) = pollster::block_on(instance.request_adapter(&Default::default())) else {
        assert!(!requires_gpu(), "a GPU is required");
        return println!("skipped: no adapter");
    };
    let wanted = wgpu::DeviceDescriptor {
        required_features: adapter.features() & rtrt_gpu::FEATURES,
        required_limits: wgpu::Limits { max_storage_buffer_binding_size: 3 << 20, ..adapter.limits() },
        ..Default::default()
    };
    let (device, queue) = pollster::block_on(adapter.request_device(&wanted)).expect("a device");
    let gpu = Gpu::with_device(device, queue, Route::Auto).expect("a GPU");
    let mut random = Random(9);
    let made = world(&mut random);
    let mut tree = Tree::default();
    let mut on_device = gpu.world(&made.scene, &Sequential).expect("a world");
    let questions = rays(&mut random, &made.instances);
    check(&on_device, &tree.world(&made.scene), &questions);
    let positions = vec![[0.0, 1.0, 2.0]; 3];
    let attribute = Attribute { normal: [0.0; 3], uv: [0.0; 2], color: Attribute::WHITE };
    let large = Mesh::new(positions, vec![attribute; 3], [0, 1, 2].repeat(263_000)).expect("a mesh");
    // The nodes fit, and the mesh data does not; and not even the instances do, so that nothing is copied.
    for too_large in ["mesh data", "instances"] {
        let mut scene = made.scene.clone();
        if too_large == "mesh data" {
            scene.add_mesh(&large, &Bvh::build(&large, &Sequential)).expect("room");
        } else {
            for _ in 0..(3 << 20) / size_of::<Instance>() {
                scene.add_instance(made.mesh, made.materials[0], Mat4::IDENTITY).expect("room");
            }
        }
        let refused = on_device.update(&scene, &Sequential);
        let is_so = matches!(refused, Err(Error::BufferTooLarge { buffer, .. }) if buffer == too_large);
        assert!(is_so, "{refused:?}");
        let (mut hits, mut met) = ([Ok(None); 77], [Ok(true); 77]);
        on_device.closest(&questions, &mut hits).expect("answers");
        on_device.occluded(&questions, &mut met).expect("answers");
        assert_eq!((hits, met), ([Ok(None); 77], [Ok(false); 77]), "{too_large}");
        on_device.update(&made.scene, &Sequential).expect("an update");
        check(&on_device, &tree.world(&made.scene), &questions);
    }
}

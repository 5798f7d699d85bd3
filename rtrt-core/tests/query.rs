//! Rays against random worlds: every answer is that of a search without any tree.

use bytemuck::{Pod, cast_slice};
use glam::{Mat4, Quat, Vec3};
use rtrt_core::kernel::geometry::Geometry;
use rtrt_core::kernel::ray::Ray as KernelRay;
use rtrt_core::kernel::sphere::Chord;
use rtrt_core::kernel::triangle::{Triangle, intersect};
use rtrt_core::lane::V3;
use rtrt_core::layout::{Instance, Node};
use rtrt_core::query::{
    Changed, DeviceChanges, DeviceWorld, Hit, Overlap, Ray, Shapes, Sides, Source, Tree, Volume, World,
};
use rtrt_core::scene::{
    Attribute, Bvh, InstanceIndex, Material, MaterialIndex, Mesh, MeshError, MeshIndex, Scene, Sequential,
};
use rtrt_core::stage::query::{self, QueryWorld};

/// Numbers that look random.
struct Random(u32);

impl Random {
    fn word(&mut self) -> u32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        self.0 >> 8
    }
    fn below(&mut self, end: u32) -> u32 {
        self.word() % end
    }
    /// Within −1 .. 1.
    fn signed(&mut self) -> f32 {
        self.word() as f32 / (1 << 23) as f32 - 1.0
    }
    fn vector(&mut self, size: f32) -> Vec3 {
        Vec3::new(self.signed(), self.signed(), self.signed()) * size
    }
    /// A place in a world of this size: moved, turned, scaled, some of them mirrored or flat.
    fn place(&mut self, size: f32) -> Mat4 {
        let scale = match self.below(5) {
            0 => Vec3::ONE,
            1 => Vec3::new(0.3, 2.0, -1.0),
            2 => Vec3::new(1.0, 1e-3, 3.0),
            _ => Vec3::splat((self.signed() * 1.5).exp()),
        };
        let turn = Quat::from_scaled_axis(self.vector(3.0));
        Mat4::from_scale_rotation_translation(scale, turn, self.vector(size))
    }
}

/// Triangles strewn over a cube, some of them in a row with shared corners.
fn heap(random: &mut Random, triangles: u32) -> Mesh {
    let mut positions: Vec<[f32; 3]> = vec![];
    for _ in 0..triangles {
        let center = random.vector(1.0);
        positions.extend([0; 3].map(|_| (center + random.vector(0.4)).to_array()));
    }
    let count = positions.len() as u32;
    let mut indices: Vec<u32> = (0..count).collect();
    indices.extend((0..count / 2).flat_map(|i| [i, i + 1, (i + 7) % count]));
    let attribute = |i: usize| Attribute {
        normal: [0.0, 1.0, i as f32 * 0.01],
        uv: [i as f32 * 0.1, 0.5],
        color: if i.is_multiple_of(3) {
            Attribute::pack_color([1.0, 1.0, 1.0, 0.125])
        } else {
            Attribute::WHITE
        },
    };
    Mesh::new(positions, (0..count as usize).map(attribute).collect(), indices).expect("a mesh")
}

/// A scene of meshes and spheres, with indices of what is in it.
struct Made {
    scene: Scene,
    meshes: Vec<MeshIndex>,
    materials: Vec<MaterialIndex>,
    instances: Vec<InstanceIndex>,
}

fn made(random: &mut Random, instances: u32) -> Made {
    let mut scene = Scene::new();
    let looks = [
        Material::default(),
        Material::default().double_sided(false),
        Material::default().mask(0.5),
        Material::default().blend(0.3),
    ];
    let materials: Vec<_> = looks.into_iter().map(|look| scene.add_material(look).expect("a look")).collect();
    let mut meshes = vec![];
    for triangles in [1, 5, 60, 300] {
        let mesh = heap(random, triangles);
        meshes.push(scene.add_mesh(&mesh, &Bvh::build(&mesh, &Sequential)).expect("room"));
    }
    let mut placed = vec![];
    for number in 0..instances {
        let material = materials[random.below(4) as usize];
        let place = if number == 0 { Mat4::IDENTITY } else { random.place(8.0) };
        let instance = if random.below(4) == 0 {
            scene.add_sphere(material, place)
        } else {
            scene.add_instance(meshes[random.below(4) as usize], material, place)
        };
        let instance = instance.expect("a place");
        scene.set_ray_mask(instance, 1 << random.below(4) | 1 << random.below(4)).expect("it is there");
        placed.push(instance);
    }
    Made { scene, meshes, materials, instances: placed }
}

/// All hits on a ray, found by asking each triangle of each instance; holes aside.
fn every(scene: &Scene, masks: &[u32], ray: &Ray) -> Vec<(f32, u32, u32, f32, f32)> {
    let world = KernelRay::<f32>::new(V3::splat((), ray.origin), V3::splat((), ray.direction));
    let mut hits = vec![];
    for (number, instance) in scene.instances().iter().enumerate() {
        let skipped = ray.skip.is_some_and(|skip| skip.number() as usize == number);
        if instance.triangles == 0 || masks[number] & ray.mask == 0 || skipped {
            continue;
        }
        let local = if instance.is_identity == 1 { world } else { world.to_object(instance) };
        let limit = ray.to.min(f32::MAX);
        for id in 0..instance.triangles {
            let (found, front) = if instance.is_sphere() {
                (Chord::new(&local).side(local.direction, id, limit), id == 0)
            } else {
                let [a, b, c] =
                    instance.corners(scene.mesh_data(), id).map(|v| scene.positions()[v as usize]);
                let triangle = Triangle::new(a, b, c);
                let relative = triangle.relative_to(local.origin);
                (intersect(&local, &relative, limit), relative.front(1.0_f32))
            };
            let is_side = match ray.sides {
                Sides::Both => true,
                Sides::Fronts => front,
                Sides::Backs => !front,
                Sides::Drawn => front || instance.double_sided == 1,
            };
            if found.mask && is_side && found.t >= ray.from {
                hits.push((found.t, number as u32, id, found.u, found.v));
            }
        }
    }
    hits.sort_by(|a, b| a.partial_cmp(b).expect("no NaN"));
    hits
}

fn row(hit: &Hit) -> (f32, u32, u32, f32, f32) {
    (hit.t, hit.instance.number(), hit.triangle, hit.u, hit.v)
}

/// A ray among what is in a world of this size.
fn ray(random: &mut Random, size: f32, scene: &Scene, instances: &[InstanceIndex]) -> Ray {
    let from = if random.below(3) == 0 { 3.0 } else { 1.0 };
    let origin = random.vector(size * from);
    // To where something is, near that, or anywhere.
    let target = &scene.instances()[random.below(instances.len() as u32) as usize];
    let mut ray = if random.below(2) == 0 {
        Ray::between(origin, Vec3::from(target.center) + random.vector(target.radius)).until(f32::INFINITY)
    } else if random.below(2) == 0 {
        Ray::between(origin, random.vector(size))
    } else {
        Ray::new(origin, if random.below(5) == 0 { Vec3::X } else { random.vector(2.0) })
    };
    if random.below(3) == 0 {
        ray = ray.starting(random.signed() * 3.0);
    }
    if random.below(3) == 0 {
        ray = ray.until(random.signed() * 3.0 + 3.0);
    }
    if random.below(2) == 0 {
        ray = ray.mask(random.below(16));
    }
    if random.below(3) == 0 {
        ray = ray.skip(instances[random.below(instances.len() as u32) as usize]);
    }
    ray.sides([Sides::Both, Sides::Fronts, Sides::Backs, Sides::Drawn][random.below(4) as usize])
}

/// What a device has of a scene: copies of what was found changed.
#[derive(Default)]
struct OnDevice {
    world: DeviceWorld,
    instances: Vec<Instance>,
    /// Those of the scene, then those of the tree.
    nodes: Vec<Node>,
    mesh_data: Vec<u32>,
    positions: Vec<[f32; 3]>,
    texels: Vec<u32>,
    masks: Vec<u32>,
}

/// Copies what has changed, from `start` on; `end` elements are there afterwards.
fn renew<T: Pod>(copy: &mut Vec<T>, [start, end]: [usize; 2], elements: &[T], changed: &Changed) {
    copy.resize(end, T::zeroed());
    for range in changed.ranges(elements.len(), 2) {
        copy[start + range.start..start + range.end].copy_from_slice(&elements[range]);
    }
}

impl OnDevice {
    /// Follows to the scene, and compares with a copy that is made anew.
    fn update(&mut self, scene: &Scene) {
        let DeviceChanges { geometry, texels, instances, tree } = self.world.update(scene, &Sequential);
        let (root, end) = (scene.nodes().len(), scene.nodes().len() + self.world.tree().len());
        renew(&mut self.instances, [0, scene.instances().len()], scene.instances(), &instances);
        renew(&mut self.masks, [0, scene.instances().len()], &self.world.masks, &instances);
        renew(&mut self.nodes, [0, end], scene.nodes(), &geometry);
        renew(&mut self.nodes, [root, end], self.world.tree(), &tree);
        renew(&mut self.mesh_data, [0, scene.mesh_data().len()], scene.mesh_data(), &geometry);
        renew(&mut self.positions, [0, scene.positions().len()], scene.positions(), &geometry);
        renew(&mut self.texels, [0, scene.texels().len()], scene.texels(), &texels);
        let bytes = cast_slice::<_, u8>;
        assert!(bytes(&self.instances) == bytes(scene.instances()));
        assert_eq!((&self.nodes[..root], &self.nodes[root..]), (scene.nodes(), self.world.tree()));
        assert_eq!((&self.mesh_data[..], &self.positions[..]), (scene.mesh_data(), scene.positions()));
        assert_eq!(self.texels, scene.texels());
        let fresh = DeviceWorld::new(scene, &Sequential);
        assert_eq!((self.world.frame, &self.masks), (fresh.frame, &fresh.masks));
    }

    /// Compares what the device computes with all hits.
    fn compare(&self, scene: &Scene, masks: &[u32], ray: &Ray) {
        let world = QueryWorld {
            frame: &self.world.frame,
            geometry: Geometry {
                instances: &self.instances,
                nodes: &self.nodes,
                mesh_data: &self.mesh_data,
                positions: &self.positions,
                texels: &self.texels,
                magnitude: self.world.frame.magnitude,
            },
            masks: &self.masks,
        };
        let record = self.world.record(ray).expect("a ray");
        let every = every(scene, masks, ray);
        let closest = self.world.hit(ray, &query::closest(&world, &record));
        assert_eq!(closest.as_ref().map(row), every.first().copied(), "{ray:?}");
        assert_eq!(query::occluded(&world, &record), u32::from(!every.is_empty()), "{ray:?}");
    }
}

/// Compares every kind of query with all hits; returns how many rays hit anything.
fn compare(world: &World<'_>, scene: &Scene, masks: &[u32], ray: &Ray) -> usize {
    let every = every(scene, masks, ray);
    let closest = world.closest(ray).expect("a ray");
    assert_eq!(closest.as_ref().map(row), every.first().copied(), "{ray:?}");
    assert_eq!(world.occluded(ray), Ok(!every.is_empty()), "{ray:?}");
    // Beside rays to elsewhere.
    let [x, y, z] = ray.direction;
    let elsewhere = Ray { direction: [y, z, -x], ..*ray };
    let rays: [Ray; 20] = core::array::from_fn(|i| if i % 3 == 1 { elsewhere } else { *ray });
    let (mut together, mut occluded) = ([Ok(None); 20], [Ok(false); 20]);
    world.closest_each(&rays, &mut together);
    world.occluded_each(&rays, &mut occluded);
    for i in (0..20).filter(|i| i % 3 != 1) {
        let hit = together[i].expect("a ray");
        assert_eq!(hit.as_ref().map(row), every.first().copied(), "{ray:?}");
        assert_eq!(occluded[i], Ok(!every.is_empty()), "{ray:?}");
    }
    let mut hits = [Hit::NONE; 9];
    for size in [0, 1, 9] {
        let count = world.all(ray, &mut hits[..size]).expect("a ray");
        let found: Vec<_> = hits[..count].iter().map(row).collect();
        assert_eq!(found, every[..every.len().min(size)], "{ray:?}");
    }
    // A rule of the caller's: odd triangles only.
    let odd = |hit: &Hit| hit.triangle % 2 == 1;
    let every_odd: Vec<_> = every.iter().copied().filter(|hit| hit.2 % 2 == 1).collect();
    let closest = world.closest_where(ray, odd).expect("a ray");
    assert_eq!(closest.as_ref().map(row), every_odd.first().copied(), "{ray:?}");
    assert_eq!(world.occluded_where(ray, odd), Ok(!every_odd.is_empty()));
    let count = world.all_where(ray, &mut hits, odd).expect("a ray");
    let found: Vec<_> = hits[..count].iter().map(row).collect();
    assert_eq!(found, every_odd[..every_odd.len().min(9)]);
    usize::from(!every.is_empty())
}

#[test]
fn answers_are_those_of_a_search_without_a_tree_while_things_move() {
    let mut random = Random(1);
    // It follows from one scene to the next.
    let mut device = OnDevice::default();
    for instances in [1, 2, 9, 70, 400] {
        let Made { mut scene, meshes, materials, instances: mut all } = made(&mut random, instances);
        let mut tree = Tree::default();
        let mut masks = vec![0; instances as usize];
        let mut hit = 0;
        for step in 0..12 {
            // A few move, or most of them; some hide, a mesh bends, and there is one more.
            let moved = if step % 4 == 3 { instances } else { random.below(4) };
            let places: Vec<_> = (0..moved)
                .map(|_| (all[random.below(all.len() as u32) as usize], random.place(8.0 + step as f32)))
                .collect();
            scene.set_transforms(places).expect("places");
            if step % 3 == 1 {
                scene.hide(all[random.below(all.len() as u32) as usize]).expect("it is there");
            }
            if step == 5 {
                scene.reshape(meshes[2], &heap(&mut random, 60)).expect("the same triangles");
            }
            if step == 7 {
                all.push(scene.add_sphere(materials[0], random.place(3.0)).expect("a place"));
                masks.push(u32::MAX);
            }
            if step == 9 {
                // Nothing moves.
                scene.set_material(materials[1], Material::default().mask(0.3)).expect("a look");
            }
            if step == 10 {
                let mesh = heap(&mut random, 20);
                scene.add_mesh(&mesh, &Bvh::build(&mesh, &Sequential)).expect("room");
            }
            // Masks of all change, or of one.
            let chosen = random.below(all.len() as u32) as usize;
            for number in (0..all.len()).filter(|number| step % 4 == 0 || *number == chosen) {
                masks[number] = 1 << random.below(4);
                scene.set_ray_mask(all[number], masks[number]).expect("it is there");
            }
            let world = tree.world(&scene);
            device.update(&scene);
            for _ in 0..25 {
                let ray = ray(&mut random, 8.0, &scene, &all);
                device.compare(&scene, &masks, &ray);
                hit += compare(&world, &scene, &masks, &ray);
            }
        }
        assert!(hit > instances.min(60) as usize, "{instances}: {hit}");
    }
}

#[test]
fn a_masked_world_is_one_without_the_others() {
    let mut random = Random(5);
    let Made { mut scene, instances, .. } = made(&mut random, 60);
    let masks: Vec<_> = instances.iter().map(|_| 1 << random.below(4)).collect();
    for (instance, mask) in instances.iter().zip(&masks) {
        scene.set_ray_mask(*instance, *mask).expect("it is there");
    }
    let questions: Vec<_> = (0..200)
        .map(|_| (1 + random.below(15), ray(&mut random, 8.0, &scene, &instances), random.vector(8.0)))
        .collect();
    let ask = |world: World<'_>, ray: &Ray, point: Vec3| {
        let mut overlaps = [Overlap::NONE; 400];
        let mut touched = [Hit::NONE.instance; 60];
        let volume = Volume::ball(point, 2.0);
        let count = world.overlaps(&volume, &mut overlaps).expect("a ball");
        let instances = world.overlapped_instances(&volume, &mut touched).expect("a ball");
        assert!(touched[..instances].windows(2).all(|pair| pair[0].number() < pair[1].number()));
        let nearest = world.nearest(point, 9.0).expect("a point");
        let closest = world.closest(ray).expect("a ray");
        (
            closest.as_ref().map(row),
            nearest.as_ref().map(row),
            overlaps[..count].to_vec(),
            touched[..instances].to_vec(),
        )
    };
    let mut tree = Tree::default();
    let masked: Vec<_> = {
        let world = tree.world(&scene);
        questions.iter().map(|(mask, ray, point)| ask(world.masked(*mask), ray, *point)).collect()
    };
    let mut different = 0;
    for ((mask, ray, point), masked) in questions.iter().zip(&masked) {
        different += usize::from(ask(tree.world(&scene), ray, *point) != *masked);
        // Instances of no group are in no world.
        for (instance, own) in instances.iter().zip(&masks) {
            scene.set_ray_mask(*instance, if own & mask == 0 { 0 } else { *own }).expect("it is there");
        }
        assert_eq!(ask(tree.world(&scene), ray, *point), *masked);
        for (instance, own) in instances.iter().zip(&masks) {
            scene.set_ray_mask(*instance, *own).expect("it is there");
        }
    }
    assert!(different > 50, "{different}");
}

#[test]
fn a_direction_of_any_length_hits_the_same() {
    let mut random = Random(4);
    let Made { scene, instances, .. } = made(&mut random, 40);
    let mut tree = Tree::default();
    let world = tree.world(&scene);
    let mut hits = 0;
    for _ in 0..500 {
        let plain = ray(&mut random, 8.0, &scene, &instances).sides(Sides::Both);
        let expected = world.closest(&plain).expect("a ray");
        hits += usize::from(expected.is_some());
        for power in [-100, -60, 60, 100] {
            let length = f32::from_bits((127 + power as u32 as i32) as u32 * (1 << 23));
            let by = |c: f32| c * length;
            let scaled = Ray {
                direction: plain.direction.map(by),
                from: plain.from / length,
                to: plain.to / length,
                ..plain
            };
            let found = world.closest(&scaled).expect("a ray");
            let expected = expected.map(|hit| Hit { t: hit.t / length, ..hit });
            assert_eq!(found, expected, "{plain:?} times 2^{power}");
        }
    }
    assert!(hits > 100, "{hits}");
}

#[test]
fn holes_are_looked_through_only_if_asked() {
    let mut random = Random(9);
    let Made { mut scene, instances, materials, .. } = made(&mut random, 60);
    // What the mask leaves in place is decided by vertex colors: compared with a scene in which it cuts nothing.
    let mut tree = Tree::default();
    let rays: Vec<_> = (0..600).map(|_| ray(&mut random, 8.0, &scene, &instances).through_holes()).collect();
    let ask = |world: &World<'_>, ray: &Ray| world.closest(ray).expect("a ray").map(|hit| row(&hit));
    let world = tree.world(&scene);
    let through: Vec<_> = rays.iter().map(|ray| ask(&world, ray)).collect();
    let solid: Vec<_> = rays.iter().map(|ray| ask(&world, &Ray { through_holes: false, ..*ray })).collect();
    assert_ne!(through, solid);
    scene.set_material(materials[2], Material::default().mask(0.0)).expect("a look");
    let world = tree.world(&scene);
    let uncut: Vec<_> = rays.iter().map(|ray| ask(&world, ray)).collect();
    assert_eq!(uncut, solid);
}

#[test]
fn shapes_of_the_callers_answer_as_a_scene_does() {
    let mut random = Random(2);
    let meshes: Vec<_> = [1, 40, 300].into_iter().map(|n| heap(&mut random, n)).collect();
    let (mut scene, mut shapes) = (Scene::new(), Shapes::new());
    let material = scene.add_material(Material::default()).expect("a look");
    let mut in_scene = vec![];
    let mut in_shapes = vec![];
    for mesh in &meshes {
        in_scene.push(scene.add_mesh(mesh, &Bvh::build(mesh, &Sequential)).expect("room"));
        in_shapes.push(shapes.add_mesh(mesh.positions(), mesh.indices(), &Sequential).expect("a mesh"));
    }
    let mut both = vec![];
    for _ in 0..80 {
        let (mesh, place) = (random.below(3) as usize, random.place(8.0));
        both.push((
            scene.add_instance(in_scene[mesh], material, place).expect("a place"),
            shapes.add_instance(in_shapes[mesh], place).expect("a place"),
        ));
    }
    let (mut tree, mut other) = (Tree::default(), Tree::new(&shapes, &Sequential));
    let mut hits = 0;
    for step in 0..4 {
        for _ in 0..step * 20 {
            let ((a, b), place) = (both[random.below(80) as usize], random.place(8.0));
            scene.set_transform(a, place).expect("a place");
            shapes.set_transform(b, place).expect("a place");
        }
        let (world, shape_world) = (tree.world(&scene), other.world(&shapes));
        for _ in 0..200 {
            let ray = Ray { skip: None, ..ray(&mut random, 8.0, &scene, &[both[0].0]) };
            let (a, b) = (world.closest(&ray).expect("a ray"), shape_world.closest(&ray).expect("a ray"));
            assert_eq!(a.as_ref().map(row), b.as_ref().map(row));
            if let (Some(a), Some(b)) = (a, b) {
                hits += 1;
                assert_eq!(world.source_triangle(&a), shape_world.source_triangle(&b));
                let surfaces = (world.surface(&a).expect("a hit"), shape_world.surface(&b).expect("a hit"));
                assert_eq!(surfaces.0.position, surfaces.1.position);
                assert_eq!(surfaces.0.normal, surfaces.1.normal);
                // A hit of another world is none of this one.
                assert_eq!((world.surface(&b), world.source_triangle(&b)), (None, None));
            }
        }
    }
    assert!(hits > 100, "{hits}");
}

#[test]
fn a_stored_bvh_serves_its_own_triangles_only() {
    let mut random = Random(8);
    let [mesh, other] = [heap(&mut random, 60), heap(&mut random, 60)];
    let mut shapes = Shapes::new();
    let built = shapes.add_mesh(mesh.positions(), mesh.indices(), &Sequential).expect("a mesh");
    let digest = Bvh::digest(mesh.positions(), mesh.indices());
    let bytes = shapes.bvh(built).expect("it is there").to_bytes(&digest);
    let read = || Bvh::from_bytes(mesh.positions(), mesh.indices(), &digest, &bytes).expect("a BVH");
    let mut again = Shapes::new();
    let stored = again.add_mesh_with(mesh.positions(), mesh.indices(), read()).expect("a mesh");
    assert_eq!(again.bvh(stored), shapes.bvh(built));
    assert_eq!(again.bvh(built), None);
    assert!(matches!(
        again.add_mesh_with(other.positions(), other.indices(), read()),
        Err(MeshError::Tree(_))
    ));
    assert!(again.add_mesh_with(mesh.positions(), &mesh.indices()[3..], read()).is_err());
}

#[test]
fn rays_that_leave_a_surface_do_not_hit_it_and_the_point_is_on_it() {
    let mut random = Random(7);
    let Made { scene, instances, .. } = made(&mut random, 60);
    let mut tree = Tree::default();
    let world = tree.world(&scene);
    let mut hits = 0;
    for _ in 0..2000 {
        let ray = Ray { skip: None, ..ray(&mut random, 8.0, &scene, &instances) };
        let Some(hit) = world.closest(&ray).expect("a ray") else { continue };
        hits += 1;
        let surface = world.surface(&hit).expect("a hit");
        let [x, y, z] = surface.normal.map(f64::from);
        assert!((x * x + y * y + z * z - 1.0).abs() < 1e-6);
        assert_eq!(surface.material, scene.material_of(hit.instance));
        assert_eq!(Some(surface.source_triangle), world.source_triangle(&hit));
        // The front is where the ray comes from, if it hits the front.
        let along = Vec3::from(ray.direction).dot(surface.normal.into());
        let fronts = world.closest(&Ray { sides: Sides::Fronts, to: hit.t, from: hit.t, ..ray });
        if along.abs() > 1e-3 * Vec3::from(ray.direction).length() {
            assert_eq!(fronts.expect("a ray").map(|front| front.triangle) == Some(hit.triangle), along < 0.0);
        }
        for side in [1.0, -1.0] {
            let away = Vec3::from(surface.normal) * side + random.vector(0.5);
            let leaving = Ray::new(surface.start(away), away);
            let own = |other: &Hit| (other.instance, other.triangle) == (hit.instance, hit.triangle);
            let again = world.closest_where(&leaving, own).expect("a ray");
            // A sphere is left through its other side.
            let is_sphere = scene.instances()[hit.instance.number() as usize].is_sphere();
            assert!(again.is_none() || is_sphere, "{hit:?} {again:?}");
        }
        let instance = &scene.instances()[hit.instance.number() as usize];
        if !instance.is_sphere() {
            let corners = instance.corners(scene.mesh_data(), hit.triangle).map(|vertex| {
                let p = scene.positions()[vertex as usize].map(f64::from);
                glam::DVec3::from(instance.to_world.map(|r| {
                    f64::from(r[0]) * p[0] + f64::from(r[1]) * p[1] + f64::from(r[2]) * p[2] + f64::from(r[3])
                }))
            });
            let [a, b, c] = corners;
            let normal = (b - a).cross(c - a).normalize();
            let off = (glam::DVec3::from(surface.position.map(f64::from)) - a).dot(normal).abs();
            assert!(off <= f64::from(surface.error) * 1.8, "{off} {surface:?}");
        }
    }
    assert!(hits > 500, "{hits}");
}

/// Answers of any source, to be called with anything.
fn ask_everything<S: Source>(world: &World<'_, S>, ray: &Ray, hit: &Hit) {
    let mut hits = [*hit; 3];
    let _ = world.closest(ray);
    let _ = world.occluded(ray);
    let usual = Ray::new([1.0, 2.0, 9.0], [0.1, -0.2, -1.0]);
    let rays: [Ray; 20] = core::array::from_fn(|i| if i % 2 == 1 { usual } else { *ray });
    world.closest_each(&rays, &mut [Ok(None); 20]);
    world.occluded_each(&rays, &mut [Ok(true); 20]);
    let _ = world.all(ray, &mut hits);
    let _ = world.closest_where(ray, |hit| hit.u > 0.3);
    let _ = (world.surface(hit), world.source_triangle(hit), world.user_data(hit.instance));
    let _ = world.nearest(ray.origin, ray.to);
    let volume = Volume::between(ray.origin, ray.direction);
    let _ = world.overlaps(&volume, &mut [Overlap::NONE; 2]);
    let _ = world.overlapped_instances(&Volume::ball(ray.origin, ray.to), &mut [hit.instance]);
}

#[test]
fn nothing_panics_whatever_is_asked() {
    let mut random = Random(3);
    let Made { scene, instances, .. } = made(&mut random, 30);
    let other = made(&mut random, 3);
    let odd = [
        0.0,
        -0.0,
        1.0,
        -1.0,
        1e-45,
        -1e-45,
        1e-38,
        1e-30,
        1e30,
        -1e30,
        f32::MAX,
        f32::MIN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::NAN,
        1_073_741_824.0,
        -1_073_741_900.0,
        3.5,
    ];
    let number = |random: &mut Random| match random.below(3) {
        0 => f32::from_bits(random.word() << 16 ^ random.word()),
        _ => odd[random.below(odd.len() as u32) as usize],
    };
    let (mut tree, mut shape_tree) = (Tree::default(), Tree::default());
    let positions = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let mut shapes = Shapes::new();
    let mesh = shapes.add_mesh(&positions, &[0, 1, 2, 1, 1, 1], &Sequential).expect("a mesh");
    shapes.add_instance(mesh, Mat4::IDENTITY).expect("a place");
    let shape_world = shape_tree.world(&shapes);
    let world = tree.world(&scene);
    for _ in 0..30_000 {
        let mut point = || [0; 3].map(|_| number(&mut random));
        let mut ray = Ray::new(point(), point());
        if random.below(2) == 0 {
            (ray.from, ray.to) = (number(&mut random), number(&mut random));
        }
        let from = if random.below(4) == 0 { &other.instances } else { &instances };
        let instance = from[random.below(from.len() as u32) as usize];
        ray.skip = (random.below(2) == 0).then_some(instance);
        let hit = Hit {
            t: number(&mut random),
            instance,
            triangle: if random.below(2) == 0 { random.below(3) } else { random.word() << 8 },
            u: number(&mut random),
            v: number(&mut random),
        };
        ask_everything(&world, &ray, &hit);
        ask_everything(&shape_world, &ray, &hit);
    }
    // Nothing at all.
    let mut tree = Tree::default();
    let nothing = Scene::new();
    assert_eq!(tree.world(&nothing).closest(&Ray::new([0.0; 3], [1.0; 3])), Ok(None));
}

#[test]
fn what_belongs_to_another_scene_is_refused() {
    let mut random = Random(5);
    let (mut one, other) = (made(&mut random, 3), made(&mut random, 3));
    let scene = &mut one.scene;
    let place = Mat4::IDENTITY;
    assert!(scene.add_instance(other.meshes[0], one.materials[0], place).is_err());
    assert!(scene.add_instance(one.meshes[0], other.materials[0], place).is_err());
    assert!(scene.add_sphere(other.materials[0], place).is_err());
    assert!(scene.set_transform(other.instances[0], place).is_err());
    assert!(scene.hide(other.instances[0]).is_err());
    assert!(scene.set_ray_mask(other.instances[0], 1).is_err());
    assert!(scene.set_levels(one.instances[0], &[(1.0, other.meshes[0])]).is_err());
    assert!(scene.set_material(other.materials[0], Material::default()).is_err());
    assert!(scene.reshape(other.meshes[0], &heap(&mut random, 1)).is_err());
    assert_eq!((scene.material(other.materials[0]), scene.material_of(other.instances[0])), (None, None));
    assert_eq!(scene.source_triangle(other.instances[0], 0), None);
    // A shape of another size says what it should be.
    let error = scene.reshape(one.meshes[1], &heap(&mut random, 2)).expect_err("too few").to_string();
    assert_eq!(
        error,
        "the shape has 3 + 2 triangles".replace("3 + 2", &heap(&mut random, 2).triangles().to_string())
            + ", and the mesh has 12"
    );
    // A tree of another mesh, with as many triangles, with fewer, with more; and none.
    let mesh = heap(&mut random, 20);
    for triangles in [20, 19, 21, 0] {
        let tree = Bvh::build(&heap(&mut random, triangles), &Sequential);
        assert!(scene.add_mesh(&mesh, &tree).is_err(), "{triangles}");
    }
    assert!(scene.add_mesh(&mesh, &Bvh { nodes: vec![], triangles: vec![] }).is_err());
    assert!(scene.add_mesh(&mesh, &Bvh::build(&mesh, &Sequential)).is_ok());
}

#[test]
fn indices_name_the_same_things_in_a_clone_and_changes_stay_where_they_are_made() {
    let mut scene = Scene::new();
    let white = scene.add_material(Material::default()).unwrap();
    let at = |z: f32| Mat4::from_translation(Vec3::new(0.0, 0.0, z));
    let ball = scene.add_sphere(white, at(-5.0)).unwrap();
    let ray = Ray::new([0.0; 3], [0.0, 0.0, -1.0]);
    let mut trees = [Tree::default(), Tree::default()];
    let mut hit = |scene: &Scene| {
        let tree = &mut trees[usize::from(scene.instances().len() > 1)];
        tree.world(scene).closest(&ray).unwrap().map(|hit| (hit.instance, hit.t.round()))
    };
    assert_eq!(hit(&scene), Some((ball, 4.0)));
    let mut clone = scene.clone();
    assert!(clone.id() != scene.id());
    // The tree of the scene is none of the clone.
    clone.set_transform(ball, at(-9.0)).unwrap();
    assert_eq!([hit(&clone), hit(&scene)], [Some((ball, 8.0)), Some((ball, 4.0))]);
    scene.hide(ball).unwrap();
    assert_eq!([hit(&clone), hit(&scene)], [Some((ball, 8.0)), None]);
    let near = clone.add_sphere(white, at(-3.0)).unwrap();
    assert_eq!([hit(&clone), hit(&scene)], [Some((near, 2.0)), None]);
    assert!(scene.set_transform(near, at(0.0)).is_err(), "it is not in the scene");
    // Other scenes know none of them.
    assert!(Scene::new().set_transform(ball, at(0.0)).is_err());

    let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let mut shapes = Shapes::new();
    let mesh = shapes.add_mesh(&positions, &[0, 1, 2], &Sequential).unwrap();
    let first = shapes.add_instance(mesh, at(-5.0)).unwrap();
    let mut other = shapes.clone();
    other.set_transform(first, at(-7.0)).unwrap();
    let ray = Ray::new([0.25, 0.25, 0.0], [0.0, 0.0, -1.0]);
    let mut tree = Tree::default();
    let mut hit = |shapes: &Shapes<'_>| {
        tree.world(shapes).closest(&ray).unwrap().map(|hit| (hit.instance, hit.t.round()))
    };
    assert_eq!([hit(&other), hit(&shapes)], [Some((first, 7.0)), Some((first, 5.0))]);
}

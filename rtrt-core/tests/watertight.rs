//! Rays from within closed meshes: none gets out, wherever they are aimed.

use glam::{Mat4, Quat, Vec3};
use rtrt_core::query::{Ray, Tree};
use rtrt_core::scene::{Attribute, Bvh, Material, Mesh, Scene, Sequential};
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering::Relaxed};

/// Numbers that look random.
struct Random(u64);

impl Random {
    fn bits(&mut self) -> u64 {
        // Splitmix64.
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let x = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let x = (x ^ x >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        x ^ x >> 31
    }
    fn below(&mut self, end: usize) -> usize {
        (self.bits() % end as u64) as usize
    }
    /// Within 0 .. 1.
    fn share(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1 << 24) as f32
    }
    fn vector(&mut self, size: f32) -> Vec3 {
        (Vec3::new(self.share(), self.share(), self.share()) * 2.0 - 1.0) * size
    }
}

/// A closed surface that is seen whole from every point near its center.
struct Shape {
    name: &'static str,
    corners: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    center: Vec3,
    /// So far from the center, along each axis, everything is seen.
    room: Vec3,
    /// How many times as long a ray may take as through a box.
    cost: u32,
}

impl Shape {
    /// Two cones on one ring: fans of so many needles.
    fn fans(name: &'static str, ring: u32, height: f32) -> Self {
        let mut corners = vec![Vec3::Y * height, -Vec3::Y * height];
        corners.extend((0..ring).map(|i| {
            let angle = i as f32 / ring as f32 * core::f32::consts::TAU;
            Vec3::new(angle.cos(), 0.0, angle.sin())
        }));
        let triangles = (0..ring).flat_map(|i| {
            let (a, b) = (2 + i, 2 + (i + 1) % ring);
            [[0, b, a], [1, a, b]]
        });
        Self {
            name,
            corners,
            triangles: triangles.collect(),
            center: Vec3::ZERO,
            room: Vec3::new(0.3, height * 0.3, 0.3),
            cost: 1 + ring / 50,
        }
    }

    /// A box whose sides, flat along the axes, are cut into so many parts along each, of two triangles.
    fn room(name: &'static str, size: Vec3, cuts: [u32; 3]) -> Self {
        let mut shape =
            Self { name, corners: vec![], triangles: vec![], center: Vec3::ZERO, room: size * 0.4, cost: 1 };
        for side in 0..6 {
            let (axis, sign) = (side / 2, if side % 2 == 0 { 1.0 } else { -1.0 });
            let first = shape.corners.len() as u32;
            let [rows, columns] = [cuts[(axis + 1) % 3], cuts[(axis + 2) % 3]];
            for row in 0..=rows {
                for column in 0..=columns {
                    let at = |i: u32, cuts: u32| i as f32 / cuts as f32 * 2.0 - 1.0;
                    let mut corner = [0.0; 3];
                    corner[axis] = sign;
                    corner[(axis + 1) % 3] = at(row, rows);
                    corner[(axis + 2) % 3] = at(column, columns);
                    shape.corners.push(Vec3::from(corner) * size);
                }
            }
            for row in 0..rows {
                for column in 0..columns {
                    let a = first + row * (columns + 1) + column;
                    let b = a + columns + 1;
                    shape.triangles.extend([[a, a + 1, b], [a + 1, b + 1, b]]);
                }
            }
        }
        shape
    }

    /// A ball, cut from a box, its corners in and out by up to `rough`.
    fn ball(name: &'static str, cuts: u32, rough: f32, random: &mut Random) -> Self {
        let mut shape = Self::room(name, Vec3::ONE, [cuts; 3]);
        let mut moved = std::collections::HashMap::new();
        for corner in &mut shape.corners {
            let key = corner.to_array().map(|c| (c + 0.0).to_bits());
            let by = *moved.entry(key).or_insert_with(|| 1.0 + (random.share() - 0.5) * rough);
            *corner = corner.normalize() * by;
        }
        // Corners of neighboring sides are one point, though their own roundings may differ.
        let points: std::collections::HashMap<_, _> =
            shape.corners.iter().map(|c| ((*c * 1e5).to_array().map(|c| c.round() as i32), *c)).collect();
        for corner in &mut shape.corners {
            *corner = points[&(*corner * 1e5).to_array().map(|c| c.round() as i32)];
        }
        shape.room = Vec3::splat(0.2);
        shape
    }

    /// The shape elsewhere, of another size.
    fn placed(mut self, name: &'static str, scale: f32, by: Vec3) -> Self {
        self.name = name;
        for corner in &mut self.corners {
            *corner = *corner * scale + by;
        }
        self.center = self.center * scale + by;
        self.room *= scale;
        self
    }

    fn mesh(&self) -> Mesh {
        let attribute = Attribute { normal: [0.0, 1.0, 0.0], uv: [0.0; 2], color: Attribute::WHITE };
        let indices = self.triangles.as_flattened().to_vec();
        let positions = self.corners.iter().map(|c| c.to_array()).collect();
        Mesh::new(positions, vec![attribute; self.corners.len()], indices).expect("a mesh")
    }

    /// A point of the surface: within a triangle, on an edge, at a corner, or some roundings beside one. Of an edge
    /// also one that is near the origin, however far away the edge's ends are.
    fn aim(&self, origin: Vec3, random: &mut Random) -> Vec3 {
        let corners = self.triangles[random.below(self.triangles.len())];
        let [a, b, c] = corners.map(|corner| self.corners[corner as usize]);
        match random.below(8) {
            0 => a + (b - a) * random.share() + (c - a) * random.share() * 0.5,
            1 => a,
            2 => a + a.abs() * random.vector(1e-6),
            3 => a + (b - a) * random.share() * random.share() * 0.01,
            4 | 5 => {
                let along = (b - a).normalize();
                let near = (origin - a).dot(along) + (random.share() - 0.5) * 40.0 * self.room.min_element();
                a + along * near.clamp(0.0, (b - a).length())
            }
            _ => a + (b - a) * random.share(),
        }
    }

    /// The number of rays for this shape: [`rays`]. A shape whose rays take long gets fewer, but at least [`RAYS`].
    fn rays(&self) -> u32 {
        let rays = rays();
        rays.min(RAYS.max(rays / self.cost))
    }

    /// Asks so many rays from within, alone and together, in the space of an instance that is placed so. Returns how many
    /// miss.
    fn leaks(&self, place: Mat4, rays: u32, random: &mut Random) -> u32 {
        let mut scene = Scene::new();
        let material = scene.add_material(Material::default()).expect("a material");
        // The first shape is another one: the tree is refitted to this.
        let mesh = self.mesh();
        let flat = Mesh::new(
            self.corners.iter().map(|c| [c.x, c.y, c.z * 0.5]).collect(),
            vec![
                Attribute { normal: [0.0, 1.0, 0.0], uv: [0.0; 2], color: Attribute::WHITE };
                self.corners.len()
            ],
            self.triangles.as_flattened().to_vec(),
        );
        let flat = flat.expect("a mesh");
        let index = scene.add_mesh(&flat, &Bvh::build(&flat, &Sequential)).expect("a mesh");
        scene.reshape(index, &mesh).expect("as many triangles");
        scene.add_instance(index, material, place).expect("an instance");
        let mut tree = Tree::new(&scene, &Sequential);
        let world = tree.world(&scene);
        let mut ray = || {
            let origin = self.center + random.vector(1.0) * self.room;
            let to = self.aim(origin, random);
            let (origin, to) = (place.transform_point3(origin), place.transform_point3(to));
            Ray::new(origin.to_array(), (to - origin).to_array())
        };
        let mut leaks = 0;
        for _ in 0..rays.div_ceil(64) {
            let rays = [(); 64].map(|()| ray());
            let alone = |ray| world.closest(ray).expect("a ray").is_none();
            leaks += rays.iter().filter(|ray| alone(ray)).count() as u32;
            let mut occluded = [Ok(false); 64];
            world.occluded_each(&rays, &mut occluded);
            leaks += occluded.iter().filter(|occluded| **occluded != Ok(true)).count() as u32;
        }
        leaks
    }
}

/// The number of rays for a shape under each transform.
const RAYS: u32 = 4_000;

/// The same, or what `RTRT_RAYS` says.
fn rays() -> u32 {
    std::env::var("RTRT_RAYS").map_or(RAYS, |rays| rays.parse().expect("a number of rays"))
}

fn threads() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// Where shapes are: as they are made, turned, stretched and mirrored, and moved.
fn places() -> [Mat4; 3] {
    let turned = Mat4::from_scale_rotation_translation(
        Vec3::new(0.3, -1.7, 5.0),
        Quat::from_scaled_axis(Vec3::new(0.4, 1.0, -0.3)),
        Vec3::new(3.0, -40.0, 0.7),
    );
    [Mat4::IDENTITY, turned, Mat4::from_translation(Vec3::new(0.1, 0.2, -7.0))]
}

#[test]
fn no_ray_gets_out_of_a_closed_mesh() {
    let mut random = Random(1);
    let shapes = [
        Shape::fans("a few needles", 7, 1.0),
        Shape::fans("fans", 500, 0.7),
        Shape::fans("fans of thin needles", 20_000, 3.0),
        Shape::room("a box", Vec3::ONE, [1; 3]),
        Shape::room("a corridor", Vec3::new(1.0, 0.5, 300.0), [3; 3]),
        Shape::room("tiles", Vec3::new(1.0, 2.0, 0.7), [40; 3]),
        Shape::ball("a ball", 16, 0.0, &mut random),
        Shape::ball("a rough ball", 40, 0.02, &mut random),
        Shape::ball("", 16, 0.02, &mut random).placed("a tiny ball", 1e-5, Vec3::ZERO),
        Shape::ball("", 16, 0.02, &mut random).placed("a huge ball", 3e6, Vec3::ZERO),
        Shape::ball("", 12, 0.02, &mut random).placed("a ball far away", 1.0, Vec3::new(900.0, -70.0, 3.0)),
        Shape::room("", Vec3::ONE, [5; 3]).placed("tiles far away", 1.0, Vec3::new(4096.0, 0.0, -512.0)),
    ];
    let all: Vec<_> = shapes.iter().flat_map(|shape| places().map(|place| (shape, place))).collect();
    let (next, count) = (AtomicUsize::new(0), AtomicU64::new(0));
    let work = || {
        let mut found = vec![];
        loop {
            let number = next.fetch_add(1, Relaxed);
            let Some((shape, place)) = all.get(number) else { break };
            let mut random = Random(number as u64);
            let leaks = shape.leaks(*place, shape.rays(), &mut random);
            count.fetch_add(shape.rays().into(), Relaxed);
            if leaks > 0 {
                found.push(format!("{}: {leaks}", shape.name));
            }
        }
        found
    };
    let found: Vec<_> = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..all.len().min(threads())).map(|_| scope.spawn(work)).collect();
        workers.into_iter().flat_map(|worker| worker.join().expect("no panic")).collect()
    });
    println!("{} rays", count.into_inner());
    assert!(found.is_empty(), "{found:#?}");
}

#[test]
fn no_box_is_too_narrow_for_the_rays_that_pass_beside_its_triangles() {
    let mut random = Random(1);
    // Edges along the axes, whose ends are a thousand times as far away as where rays meet them.
    for cuts in [[1; 3], [40, 40, 1]] {
        let shape = Shape::room("a corridor", Vec3::new(1.0, 0.5, 3000.0), cuts);
        let leaks = places().map(|place| shape.leaks(place, 100 * rays(), &mut random));
        assert_eq!(leaks, [0; 3], "{cuts:?}");
    }
}

#[test]
fn a_hole_is_found() {
    let mut random = Random(1);
    let mut shape = Shape::ball("a ball", 16, 0.0, &mut random);
    shape.triangles.pop();
    assert!(shape.leaks(Mat4::IDENTITY, 20_000, &mut random) > 0);
}

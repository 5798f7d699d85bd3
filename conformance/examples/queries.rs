//! How fast single rays are, and whether the answers are right.
//!
//! ```text
//! cargo run --release -p conformance --example queries -- SCENE [--json] [--rays N] [--judged N]
//! ```
//!
//! One thread asks the same rays of each library, ray by ray, three times; the median counts. `rtrt` is `Caster`, with
//! the processor's vectors; `rtrt-core` is `World`, with those that every processor of its kind has; `loop` asks each
//! instance's tree of two children a node, one after the other, as programs had to before there was a
//! `World`.
//!
//! | workload | rays |
//! |---|---|
//! | `closest` | from random points of surfaces, in random directions |
//! | `occluded` | the same, as far as a tenth of the scene's diagonal |
//! | `camera` | one for each pixel of 640 x 360 |
//! | `bake` | 256 from each of some random points of surfaces |
//!
//! `wrong` counts answers that differ from those of a search in `f64` through all triangles, of the first
//! `--judged` rays that are not too close to call. The program fails if two ways differ by a bit.

use glam::{DVec3, Vec3};
use rtrt::import::Loaded;
use rtrt_core::kernel::closest_hit::ClosestHit;
use rtrt_core::kernel::geometry::Geometry;
use rtrt_core::kernel::hit_filter::{Any, Closest, Faces, HitFilter};
use rtrt_core::kernel::packet::{Packet, PacketHits, ray_hit_mask};
use rtrt_core::kernel::ray::Ray as KernelRay;
use rtrt_core::kernel::tiles::Tiles;
use rtrt_core::kernel::traverse::traverse;
use rtrt_core::lane::V3;
use rtrt_core::layout::NONE;
use rtrt_core::query::{Hit, QueryError, Ray, Tree, World};
use rtrt_core::scene::{Bvh, Mesh, Projection, Scene, Sequential};
use rtrt_cpu::Caster;
use std::collections::BTreeMap;
use std::error::Error;
use std::path::Path;
use std::time::Instant;

const RUNS: usize = 3;
const WIDTH: u32 = 640;
const HEIGHT: u32 = 360;

/// What one library did.
#[derive(Debug, Clone, Copy, serde::Serialize)]
struct Row {
    /// Millions of rays a second.
    mrays: f64,
    /// Wrong answers.
    wrong: usize,
    /// Answers that were judged.
    judged: usize,
}

/// The nearest hit: `t`, instance and triangle; or only whether there is one.
type Answer = (f32, u32, u32);

const MISS: Answer = (f32::MAX, NONE, NONE);

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let (mut path, mut json, mut rays, mut judged) = (None, false, 200_000, 300);
    while let Some(argument) = arguments.next() {
        let mut number = || {
            arguments.next().ok_or("a number is missing")?.parse::<usize>().map_err(Box::<dyn Error>::from)
        };
        match argument.as_str() {
            "--json" => json = true,
            "--rays" => rays = number()?,
            "--judged" => judged = number()?,
            _ => path = Some(argument),
        }
    }
    let path = path.ok_or("SCENE [--json] [--rays N] [--judged N]")?;
    let Loaded { scene, camera, .. } = rtrt::import::load(Path::new(&path), &rtrt_cpu::Parallel)?;
    if scene.instances().iter().any(|instance| instance.is_sphere()) {
        return Err("a scene with spheres is not judged".into());
    }
    let (low, high) = scene.extent().ok_or("an empty scene")?;

    let build = build_ms(&scene)?;
    let mut tree = Tree::default();
    let world = tree.world(&scene);
    let points = Points::new(&scene, &world);
    let mut random = Random(1);
    let mut workloads: BTreeMap<&str, Vec<Ray>> = BTreeMap::new();
    let closest: Vec<_> = (0..rays).map(|_| points.ray(&mut random)).collect();
    let reach = (high - low).length() / 10.0;
    workloads.insert("occluded", closest.iter().map(|ray| ray.until(reach)).collect());
    workloads.insert("closest", closest);
    let Projection::Perspective { fov_y } = camera.projection else {
        return Err("a camera with a perspective".into());
    };
    workloads.insert("camera", camera_rays(camera.eye, camera.look_at, camera.up, fov_y));
    let bake = (0..rays.div_ceil(256)).flat_map(|_| {
        let from = points.ray(&mut random);
        let normal = Vec3::from(from.direction);
        [0; 256].map(|_| Ray::new(from.origin, random.around(normal)))
    });
    workloads.insert("bake", bake.collect());

    let brute = Brute::new(&scene);
    let mut table: BTreeMap<&str, BTreeMap<&str, Row>> = BTreeMap::new();
    for (name, rays) in &workloads {
        let is_any = *name == "occluded";
        let each = Each::new(&scene, low, high);
        let mut ways: Vec<(&str, (f64, Vec<Answer>))> = vec![];
        let caster = Caster::new();
        if is_any {
            let said = |met: Result<bool, QueryError>| met.map(|met| if met { (0.0, 0, 0) } else { MISS });
            ways.push(("rtrt", timed(rays, |ray| said(caster.occluded(&world, ray)))?));
            ways.push(("rtrt-core", timed(rays, |ray| said(world.occluded(ray)))?));
            ways.push(("loop", timed(rays, |ray| Ok(each.ask(ray, Any)))?));
        } else {
            let said = |hit: Result<Option<Hit>, QueryError>| {
                hit.map(|hit| hit.map_or(MISS, |hit| (hit.t, hit.instance.number(), hit.triangle)))
            };
            ways.push(("rtrt", timed(rays, |ray| said(caster.closest(&world, ray)))?));
            ways.push(("rtrt-core", timed(rays, |ray| said(world.closest(ray)))?));
            ways.push(("loop", timed(rays, |ray| Ok(each.ask(ray, Closest)))?));
        }
        if ways.iter().any(|(_, (_, answers))| *answers != ways[0].1.1) {
            return Err(format!("{name}: two ways differ").into());
        }
        for (library, (mrays, answers)) in ways {
            let verdicts = rays.iter().zip(&answers).take(judged);
            let verdicts: Vec<_> =
                verdicts.filter_map(|(ray, answer)| brute.agrees(ray, *answer, is_any)).collect();
            let wrong = verdicts.iter().filter(|is_right| !**is_right).count();
            table.entry(name).or_default().insert(library, Row { mrays, wrong, judged: verdicts.len() });
        }
    }
    let triangles = scene.triangles() as f64;
    let numbers =
        BTreeMap::from([("build_ms", build), ("bytes_per_triangle", tree.bytes() as f64 / triangles)]);
    if json {
        let mut all = serde_json::to_value(&table)?;
        for (name, number) in &numbers {
            all[name] = serde_json::json!({ "rtrt": number });
        }
        println!("{}", serde_json::to_string_pretty(&all)?);
        return Ok(());
    }
    println!("{:>10} {:>10} {:>9} {:>7} {:>7}", "workload", "library", "M rays/s", "wrong", "judged");
    for (name, libraries) in &table {
        for (library, Row { mrays, wrong, judged }) in libraries {
            println!("{name:>10} {library:>10} {mrays:>9.2} {wrong:>7} {judged:>7}");
        }
    }
    for (name, number) in &numbers {
        println!("{name}: {number:.1}");
    }
    Ok(())
}

/// Millions of rays a second, and the answers.
fn timed(
    rays: &[Ray],
    ask: impl Fn(&Ray) -> Result<Answer, QueryError>,
) -> Result<(f64, Vec<Answer>), QueryError> {
    let mut seconds = [0.0; RUNS];
    let mut answers = vec![];
    for seconds in &mut seconds {
        answers.clear();
        answers.reserve(rays.len());
        let start = Instant::now();
        for ray in rays {
            answers.push(ask(ray)?);
        }
        *seconds = start.elapsed().as_secs_f64();
    }
    seconds.sort_by(f64::total_cmp);
    Ok((rays.len() as f64 / seconds[RUNS / 2] / 1e6, answers))
}

/// The time that one thread takes for the trees of all meshes and of the instances.
fn build_ms(scene: &Scene) -> Result<f64, Box<dyn Error>> {
    let mut meshes = BTreeMap::new();
    for instance in scene.instances().iter().filter(|instance| instance.triangles > 0) {
        meshes.entry(instance.root).or_insert(instance);
    }
    let mut built = 0.0;
    for instance in meshes.values() {
        let indices = &scene.mesh_data()[instance.first_index as usize..][..3 * instance.triangles as usize];
        let vertices = indices.iter().max().map_or(0, |most| *most as usize + 1);
        let first = instance.first_vertex as usize;
        let positions = scene.positions()[first..first + vertices].to_vec();
        let attributes = scene.attributes()[first..first + vertices].to_vec();
        let mesh = Mesh::new(positions, attributes, indices.to_vec())?;
        let start = Instant::now();
        std::hint::black_box(Bvh::build(&mesh, &Sequential));
        built += start.elapsed().as_secs_f64();
    }
    let start = Instant::now();
    std::hint::black_box(Tree::new(scene, &Sequential));
    Ok((built + start.elapsed().as_secs_f64()) * 1e3)
}

/// One ray a pixel.
fn camera_rays(eye: Vec3, look_at: Vec3, up: Vec3, fov_y: f32) -> Vec<Ray> {
    let along = (look_at - eye).normalize();
    let right = along.cross(up).normalize();
    let above = right.cross(along);
    let half = (fov_y * 0.5).tan();
    let pixel = |number: u32| {
        let (x, y) = ((number % WIDTH) as f32 + 0.5, (number / WIDTH) as f32 + 0.5);
        let [x, y] =
            [x - WIDTH as f32 * 0.5, HEIGHT as f32 * 0.5 - y].map(|c| c * half * 2.0 / HEIGHT as f32);
        Ray::new(eye, along + right * x + above * y)
    };
    (0..WIDTH * HEIGHT).map(pixel).collect()
}

/// Numbers that look random.
struct Random(u64);

impl Random {
    fn word(&mut self) -> u32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as u32
    }
    /// Within 0 .. 1.
    fn share(&mut self) -> f32 {
        (self.word() >> 7) as f32 / (1 << 24) as f32
    }
    /// A direction of length 1 on the side of a normal.
    fn around(&mut self, normal: Vec3) -> Vec3 {
        loop {
            let v = Vec3::new(self.share(), self.share(), self.share()) * 2.0 - 1.0;
            let squared = v.length_squared();
            if squared > 1e-3 && squared <= 1.0 {
                return v / squared.sqrt() * if v.dot(normal) < 0.0 { -1.0 } else { 1.0 };
            }
        }
    }
}

/// Points of surfaces.
struct Points<'a> {
    scene: &'a Scene,
    world: &'a World<'a>,
    /// The triangles of the instances up to each.
    sums: Vec<u64>,
}

impl<'a> Points<'a> {
    fn new(scene: &'a Scene, world: &'a World<'a>) -> Self {
        let mut sum = 0;
        let mut add = |triangles: u32| {
            sum += u64::from(triangles);
            sum
        };
        Self { scene, world, sums: scene.instances().iter().map(|i| add(i.triangles)).collect() }
    }

    /// A ray that leaves a random point of a random triangle, on its front.
    fn ray(&self, random: &mut Random) -> Ray {
        loop {
            let all = self.sums.last().copied().unwrap_or(1);
            let number = (u64::from(random.word()) << 31 | u64::from(random.word())) % all;
            let index = self.sums.partition_point(|&sum| sum <= number);
            let instance = &self.scene.instances()[index];
            let (u, v) = (random.share(), random.share());
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            let triangle = (number + u64::from(instance.triangles) - self.sums[index]) as u32;
            let Some(instance) = self.scene.instance_index(index as u32) else { continue };
            let Some(surface) = self.world.surface(&Hit { t: 0.0, instance, triangle, u, v }) else {
                continue;
            };
            let direction = random.around(surface.normal.into());
            let ray = Ray::new(surface.start(direction), direction);
            if self.world.closest(&ray).is_ok() {
                return ray;
            }
        }
    }
}

/// Each instance's tree, one after the other.
struct Each<'a> {
    geometry: Geometry<'a>,
}

impl<'a> Each<'a> {
    fn new(scene: &'a Scene, low: Vec3, high: Vec3) -> Self {
        let geometry = Geometry {
            instances: scene.instances(),
            nodes: scene.nodes(),
            mesh_data: scene.mesh_data(),
            positions: scene.positions(),
            texels: scene.texels(),
            magnitude: low.abs().max(high.abs()).max_element(),
        };
        Self { geometry }
    }

    fn ask(&self, ray: &Ray, filter: impl HitFilter<f32>) -> Answer {
        let asked = KernelRay::<f32>::new(V3::splat((), ray.origin), V3::splat((), ray.direction));
        let magnitude = ray.origin.iter().fold(self.geometry.magnitude, |most, c| most.max(c.abs()));
        let (mut hits, mut filters) =
            (PacketHits::new([ClosestHit::none(ray.to.min(f32::MAX))]), [Twice { filter }]);
        for (number, instance) in (0..).zip(self.geometry.instances) {
            let (low, high) = instance.padded_aabb(magnitude);
            if ray_hit_mask(&[asked], &low, &high, 1, &hits.closest) == 0 {
                continue;
            }
            let rays = [if instance.is_identity == 1 { asked } else { asked.to_object(instance) }];
            let packet = Packet { rays: &rays, tiles: &Tiles::of(&rays, &hits.closest, 1) };
            traverse(&self.geometry, number, &packet, 1, &mut hits, &mut filters);
            if hits.closest[0].t < 0.0 {
                return (0.0, 0, 0);
            }
        }
        let hit = hits.closest[0].rows().hit(0);
        (hit.t, hit.instance, hit.triangle)
    }
}

/// A filter that sees both sides.
#[derive(Clone, Copy)]
struct Twice<F> {
    filter: F,
}

impl<F: HitFilter<f32>> HitFilter<f32> for Twice<F> {
    const TERMINATES: bool = F::TERMINATES;
    const FACES: Faces = Faces::Both;

    #[inline(always)]
    fn accept(
        &mut self,
        geometry: &Geometry<'_>,
        instance: u32,
        triangle: u32,
        intersection: &rtrt_core::kernel::triangle::Intersection<f32>,
        closest: &mut ClosestHit<f32>,
    ) -> bool {
        self.filter.accept(geometry, instance, triangle, intersection, closest)
    }
}

/// All triangles, world space, in `f64`.
struct Brute {
    triangles: Vec<[DVec3; 3]>,
    /// The largest coordinate.
    size: f64,
}

/// A ray that passes an edge by less than this share of a triangle is not judged by that triangle alone.
const EDGE: f64 = 1e-4;

impl Brute {
    fn new(scene: &Scene) -> Self {
        let mut triangles = vec![];
        for instance in scene.instances() {
            for triangle in 0..instance.triangles {
                triangles.push(instance.corners(scene.mesh_data(), triangle).map(|vertex| {
                    let p = scene.positions()[vertex as usize].map(f64::from);
                    DVec3::from(instance.to_world.map(|row| {
                        let row = row.map(f64::from);
                        row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3]
                    }))
                }));
            }
        }
        let size = triangles.iter().flatten().fold(0.0_f64, |most, p| most.max(p.abs().max_element()));
        Self { triangles, size }
    }

    /// Whether an answer is right; `None` where it is too close to call.
    fn agrees(&self, ray: &Ray, answer: Answer, is_any: bool) -> Option<bool> {
        let (o, d) = (DVec3::from(ray.origin.map(f64::from)), DVec3::from(ray.direction.map(f64::from)));
        let doubt = 1e-5 * self.size / d.length();
        let limit = f64::from(ray.to);
        // The nearest hit that is beyond doubt, and all that may be hits.
        let mut sure = f64::INFINITY;
        let mut possible = vec![];
        for [a, b, c] in &self.triangles {
            let (ab, ac, s) = (*b - *a, *c - *a, o - *a);
            let across = d.cross(ac);
            let determinant = ab.dot(across);
            if determinant == 0.0 {
                continue;
            }
            let u = s.dot(across) / determinant;
            let turned = s.cross(ab);
            let v = d.dot(turned) / determinant;
            let t = ac.dot(turned) / determinant;
            let inside = u.min(v).min(1.0 - u - v);
            if inside < -EDGE || t < -doubt || t > limit + doubt {
                continue;
            }
            possible.push(t);
            if inside > EDGE && t > doubt && t < limit - doubt {
                sure = sure.min(t);
            }
        }
        let is_hit = answer.1 != NONE;
        if is_any {
            return match (sure.is_finite(), possible.is_empty()) {
                (true, _) => Some(is_hit),
                (false, true) => Some(!is_hit),
                (false, false) => None,
            };
        }
        if !is_hit {
            return if sure.is_finite() { Some(false) } else { possible.is_empty().then_some(true) };
        }
        let t = f64::from(answer.0);
        let near = |other: &f64| (other - t).abs() <= doubt + 1e-5 * t;
        Some(possible.iter().any(near) && t <= sure + doubt + 1e-5 * t)
    }
}

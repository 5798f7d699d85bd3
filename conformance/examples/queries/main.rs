//! How fast single rays are, and whether the answers are right, beside other libraries.
//!
//! ```text
//! apt-get install libembree-dev
//! cargo run --release -p conformance --features embree,peers --example queries -- \
//!     SCENE [--json] [--rays N] [--judged N] [--isa avx2]
//! ```
//!
//! One thread asks the same rays of each library three times; the median counts.
//!
//! | library | call |
//! |---|---|
//! | `rtrt` | `Caster`, ray by ray, with the processor's vectors of eight |
//! | `rtrt-core` | `World`, ray by ray, with the vectors that every processor of its kind has |
//! | `rtrt slices` | `Cpu::closest` and `Cpu::occluded`, all rays at once |
//! | `loop` | each instance's tree of two children a node, one after the other |
//! | `obvhs`, `parry3d`, `bvh` | the crates (feature `peers`), ray by ray |
//! | `embree`, `embree packets` | Embree 3 (feature `embree`), ray by ray and in packets of eight; `--isa` is Embree's |
//!
//! | workload | rays |
//! |---|---|
//! | `closest` | from random points of surfaces, in random directions |
//! | `occluded` | the same, as far as a tenth of the scene's diagonal |
//! | `camera` | one for each pixel of 640 x 360 |
//! | `bake` | 256 from each of some random points of surfaces |
//!
//! `wrong` counts answers that differ from those of a search in `f64` through all triangles, of the first
//! `--judged` rays that are not too close to call. The program fails if two ways of ours differ by a bit.

#[cfg(feature = "embree")]
mod embree;
#[cfg(feature = "embree")]
#[path = "../yardstick/embree3.rs"]
mod embree3;
mod judge;
mod ours;
#[cfg(feature = "peers")]
mod peers;
mod rays;

use judge::Brute;
use ours::{Cast, Core, Each, Slices};
use rays::{Points, Random, camera_rays};
use rtrt::import::Loaded;
use rtrt_core::layout::NONE;
use rtrt_core::query::{Ray, Tree};
use rtrt_core::scene::Projection;
use rtrt_cpu::{Caster, Cpu};
use std::collections::BTreeMap;
use std::error::Error;
use std::path::Path;
use std::time::Instant;

const RUNS: usize = 3;
const USAGE: &str = "SCENE [--json] [--rays N] [--judged N] [--isa ISA]";

/// The nearest hit: `t`, instance and triangle; or only whether there is one.
type Answer = (f32, u32, u32);

const MISS: Answer = (f32::MAX, NONE, NONE);

/// Something that answers rays.
trait Library {
    fn name(&self) -> &'static str;
    /// Whether its answers must be ours to the bit.
    fn is_ours(&self) -> bool {
        false
    }
    /// The closest hits.
    fn closest(&self, rays: &[Ray], answers: &mut [Answer]);
    /// Whether there are hits: any answer but [`MISS`].
    fn occluded(&self, rays: &[Ray], answers: &mut [Answer]);
}

/// Something that answers rays one by one.
trait Single {
    const NAME: &'static str;
    const IS_OURS: bool = false;
    /// The closest hit.
    fn closest(&self, ray: &Ray) -> Answer;
    /// Whether there is a hit: any answer but [`MISS`].
    fn occluded(&self, ray: &Ray) -> Answer;
}

/// Asks ray by ray.
struct OneByOne<S>(S);

impl<S: Single> Library for OneByOne<S> {
    fn name(&self) -> &'static str {
        S::NAME
    }
    fn is_ours(&self) -> bool {
        S::IS_OURS
    }
    fn closest(&self, rays: &[Ray], answers: &mut [Answer]) {
        for (answer, ray) in answers.iter_mut().zip(rays) {
            *answer = self.0.closest(ray);
        }
    }
    fn occluded(&self, rays: &[Ray], answers: &mut [Answer]) {
        for (answer, ray) in answers.iter_mut().zip(rays) {
            *answer = self.0.occluded(ray);
        }
    }
}

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

struct Arguments {
    path: String,
    json: bool,
    rays: usize,
    judged: usize,
    isa: String,
}

fn arguments() -> Result<Arguments, Box<dyn Error>> {
    let mut all =
        Arguments { path: String::new(), json: false, rays: 200_000, judged: 300, isa: "avx2".into() };
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let mut next = || words.next().ok_or(USAGE);
        match word.as_str() {
            "--json" => all.json = true,
            "--rays" => all.rays = next()?.parse()?,
            "--judged" => all.judged = next()?.parse()?,
            "--isa" => all.isa = next()?,
            _ => all.path = word,
        }
    }
    if all.path.is_empty() { Err(USAGE.into()) } else { Ok(all) }
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = arguments()?;
    let Loaded { scene, camera, .. } = rtrt::import::load(Path::new(&arguments.path), &rtrt_cpu::Parallel)?;
    if scene.instances().iter().any(|instance| instance.is_sphere()) {
        return Err("a scene with spheres is not judged".into());
    }
    let (low, high) = scene.extent().ok_or("an empty scene")?;
    let Projection::Perspective { fov_y } = camera.projection else {
        return Err("a camera with a perspective".into());
    };

    let mut tree = Tree::new(&scene, &rtrt_cpu::Parallel);
    let bytes = tree.bytes() as f64 / scene.triangles() as f64;
    let world = tree.world(&scene);
    let points = Points::new(&scene, &world);
    let mut random = Random(1);
    let mut workloads: BTreeMap<&str, Vec<Ray>> = BTreeMap::new();
    let closest: Vec<_> = (0..arguments.rays).map(|_| points.ray(&mut random)).collect();
    let reach = (high - low).length() / 10.0;
    workloads.insert("occluded", closest.iter().map(|ray| ray.until(reach)).collect());
    workloads.insert("closest", closest);
    workloads.insert("camera", camera_rays(camera.eye, camera.look_at, camera.up, fov_y));
    let bake = (0..arguments.rays.div_ceil(256)).flat_map(|_| {
        let from = points.ray(&mut random);
        [0; 256].map(|_| Ray::new(from.origin, random.around(from.direction.into())))
    });
    workloads.insert("bake", bake.collect());

    let cpu = Cpu::new(rtrt_cpu::Options { threads: Some(1), ..Default::default() })?;
    let brute = Brute::new(&scene);
    let mut builds = BTreeMap::new();
    builds.insert("rtrt", ours::build_ms(&scene)?);
    let mut libraries: Vec<Box<dyn Library + '_>> = Vec::new();
    let ours: [Box<dyn Library + '_>; 4] = [
        Box::new(OneByOne(Cast(world, Caster::new()))),
        Box::new(OneByOne(Core(world))),
        Box::new(Slices(world, cpu)),
        Box::new(OneByOne(Each::new(&scene, low, high))),
    ];
    libraries.extend(ours);
    #[cfg(feature = "peers")]
    for (library, build) in peers::libraries(&brute.single())? {
        builds.insert(library.name(), build);
        libraries.push(library);
    }
    #[cfg(feature = "embree")]
    {
        let (both, embree::Builds { medium, high }) = embree::libraries(&scene, &arguments.isa)?;
        libraries.extend(both.into_iter().map(|library| library as Box<dyn Library>));
        builds.extend([("embree medium", medium), ("embree high", high)]);
    }

    let mut table: BTreeMap<&str, BTreeMap<&str, Row>> = BTreeMap::new();
    for (name, rays) in &workloads {
        let is_any = *name == "occluded";
        let mut first = None;
        for library in &libraries {
            let (mrays, answers) = timed(library.as_ref(), rays, is_any);
            let verdicts: Vec<_> = rays
                .iter()
                .zip(&answers)
                .filter_map(|(ray, answer)| brute.agrees(ray, *answer, is_any))
                .take(arguments.judged)
                .collect();
            let wrong = verdicts.iter().filter(|is_right| !**is_right).count();
            let row = Row { mrays, wrong, judged: verdicts.len() };
            table.entry(name).or_default().insert(library.name(), row);
            if library.is_ours() && *first.get_or_insert_with(|| answers.clone()) != answers {
                return Err(format!("{name}: {} differs", library.name()).into());
            }
        }
    }
    if arguments.json {
        let mut all = serde_json::to_value(&table)?;
        all["build_ms"] = serde_json::to_value(&builds)?;
        all["bytes_per_triangle"] = serde_json::json!({ "rtrt": bytes });
        println!("{}", serde_json::to_string_pretty(&all)?);
        return Ok(());
    }
    println!("{:>10} {:>14} {:>9} {:>7} {:>7}", "workload", "library", "M rays/s", "wrong", "judged");
    for (name, libraries) in &table {
        for (library, Row { mrays, wrong, judged }) in libraries {
            println!("{name:>10} {library:>14} {mrays:>9.2} {wrong:>7} {judged:>7}");
        }
    }
    for (library, build) in &builds {
        println!("{:>10} {library:>14} {build:>9.1} ms", "build");
    }
    println!("{:>10} {:>14} {bytes:>9.1} bytes a triangle", "memory", "rtrt");
    Ok(())
}

/// Millions of rays a second, and the answers.
fn timed(library: &dyn Library, rays: &[Ray], is_any: bool) -> (f64, Vec<Answer>) {
    let mut seconds = [0.0; RUNS];
    let mut answers = vec![MISS; rays.len()];
    for seconds in &mut seconds {
        let start = Instant::now();
        if is_any {
            library.occluded(rays, &mut answers);
        } else {
            library.closest(rays, &mut answers);
        }
        *seconds = start.elapsed().as_secs_f64();
    }
    seconds.sort_by(f64::total_cmp);
    (rays.len() as f64 / seconds[RUNS / 2] / 1e6, answers)
}

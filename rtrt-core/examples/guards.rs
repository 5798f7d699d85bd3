//! A thousand guards look at each other through a market of columns, crates and balls.
//!
//! ```text
//! $ cargo run --release -p rtrt-core --example guards
//! tick 0: 52839 pairs of guards are near, 22199 of them see each other
//! tick 1: 52780 pairs of guards are near, 22670 of them see each other
//! tick 2: 52797 pairs of guards are near, 22303 of them see each other
//! ```
//!
//! Each pair is one ray, asked with `occluded`; a guard does not stand in its own way, nor in that of
//! who looks at it. The loop does not allocate.

use glam::{Mat4, Vec3};
use rtrt_core::query::{Hit, QueryError, Ray, Tree, World};
use rtrt_core::scene::{InstanceIndex, Material, Scene, SceneError, Sequential};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::error::Error;
use std::time::Instant;

const GUARDS: usize = 1000;
const COLUMNS: usize = 400;
/// The side of the market.
const SIDE: f32 = 200.0;
/// How far a guard sees.
const SIGHT: f32 = 40.0;

/// A guard's eyes.
#[derive(Clone, Copy)]
struct Guard {
    body: InstanceIndex,
    eye: Vec3,
    step: Vec3,
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut scene = Scene::new();
    let material = scene.add_material(Material::default())?;
    let mut random = Random(1);
    for _ in 0..COLUMNS {
        let size = Vec3::new(0.4 + random.share(), 3.0, 0.4 + random.share());
        scene.add_sphere(material, Mat4::from_translation(random.place()) * Mat4::from_scale(size))?;
    }
    let mut guards = Vec::new();
    for _ in 0..GUARDS {
        let eye = random.place();
        let step = Vec3::new(random.share() - 0.5, 0.0, random.share() - 0.5);
        guards.push(Guard { body: scene.add_sphere(material, body(eye))?, eye, step });
    }
    let mut tree = Tree::new(&scene, &Sequential);
    let (mut seen, mut seconds) = ([[0; 2]; 3], [0.0; 3]);
    let before = ALLOCATIONS.get();
    for tick in 0..3 {
        let start = Instant::now();
        walk(&mut scene, &mut guards)?;
        seen[tick] = look(&tree.world(&scene), &guards)?;
        seconds[tick] = start.elapsed().as_secs_f64();
    }
    assert_eq!(ALLOCATIONS.get(), before, "the loop allocates");
    for (tick, [near, seen]) in seen.into_iter().enumerate() {
        println!("tick {tick}: {near} pairs of guards are near, {seen} of them see each other");
    }
    eprintln!("{:.1} ms a tick", seconds.iter().sum::<f64>() / 3.0 * 1e3);
    assert_eq!(seen, EXPECTED);
    Ok(())
}

/// What is seen, on every machine.
const EXPECTED: [[u32; 2]; 3] = [[52_839, 22_199], [52_780, 22_670], [52_797, 22_303]];

/// All guards take a step.
fn walk(scene: &mut Scene, guards: &mut [Guard]) -> Result<(), SceneError> {
    for guard in &mut *guards {
        guard.eye += guard.step;
    }
    scene.set_transforms(guards.iter().map(|guard| (guard.body, body(guard.eye))))
}

/// How many pairs are near, and how many of those see each other.
fn look(world: &World<'_>, guards: &[Guard]) -> Result<[u32; 2], QueryError> {
    let (mut near, mut seen) = (0, 0);
    for (number, one) in guards.iter().enumerate() {
        for other in &guards[number + 1..] {
            if one.eye.distance_squared(other.eye) > SIGHT * SIGHT {
                continue;
            }
            near += 1;
            let in_the_way = |hit: &Hit| hit.instance != other.body;
            let ray = Ray::between(one.eye, other.eye).skip(one.body);
            seen += u32::from(!world.occluded_where(&ray, in_the_way)?);
        }
    }
    Ok([near, seen])
}

/// Where a guard's body is, whose eyes are there.
fn body(eye: Vec3) -> Mat4 {
    Mat4::from_translation(eye) * Mat4::from_scale(Vec3::new(0.3, 0.9, 0.3))
}

/// Numbers that look random.
struct Random(u32);

impl Random {
    /// Within 0 .. 1.
    fn share(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (self.0 >> 8) as f32 / (1 << 24) as f32
    }
    /// A place in the market.
    fn place(&mut self) -> Vec3 {
        Vec3::new(self.share() * SIDE, 1.6, self.share() * SIDE)
    }
}

std::thread_local! {
    /// How often this thread has asked for memory.
    static ALLOCATIONS: Cell<u32> = const { Cell::new(0) };
}

/// Counts, and passes on.
struct Counting;

// SAFETY: every call goes on to the system's allocator as it is.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.set(ALLOCATIONS.get() + 1);
        // SAFETY: the caller's promise.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        // SAFETY: the caller's promise.
        unsafe { System.dealloc(memory, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

#[test]
fn runs() {
    main().expect("no error");
}

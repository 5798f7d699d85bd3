//! A game asks rays of its world with `rtrt-core` alone: what is under the cursor, and who sees whom.
//!
//! ```text
//! $ cargo run --release -p rtrt-core --example embed_core
//! tick 0: the cursor is on crate 2, 3.4999998 away; the guard is seen
//! tick 1: the cursor is on crate 2, 3.4999998 away; the guard is seen
//! tick 2: the cursor is on the guard, 2.4999998 away; the guard is seen
//! tick 3: the cursor is on crate 2, 3.4999998 away; the guard is hidden
//! nothing was allocated
//! ```
//!
//! Building the world allocates (feature `alloc`). The loop does not, and what it calls needs neither `alloc`
//! nor `std`. There is no renderer: the kernels are called on the game's own rays, one at a time.

use glam::{Mat4, Vec3};
use rtrt_core::backend::{Hit, NONE};
use rtrt_core::kernel::closest_hit::ClosestHit;
use rtrt_core::kernel::geometry::Geometry;
use rtrt_core::kernel::hit_filter::{Any, Closest, HitFilter};
use rtrt_core::kernel::packet::{Packet, PacketHits, ray_hit_mask};
use rtrt_core::kernel::ray::Ray;
use rtrt_core::kernel::tiles::Tiles;
use rtrt_core::kernel::traverse::traverse;
use rtrt_core::lane::V3;
use rtrt_core::scene::{Attribute, Bvh, InstanceIndex, Material, Mesh, Scene, Sequential};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let mut scene = Scene::new();
    let material = scene.add_material(Material::new([0.5; 3]))?;
    let cube = cube()?;
    let cube = scene.add_mesh(&cube, &Bvh::build(&cube, &Sequential))?;
    let mut place = |x: f32| scene.add_instance(cube, material, Mat4::from_translation(Vec3::X * x));
    let guard = place(-3.0)?;
    place(2.0)?;
    place(0.0)?;

    // Player and cursor, and where the guard goes.
    let (player, along) = ([0.0, 0.0, 4.0], [0.0, 0.0, -1.0]);
    let walk = [[-3.0, 0.0, 0.0], [-1.5, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -3.0]];
    let before = ALLOCATIONS.get();
    let mut seen = [(NONE, 0.0, false); 4];
    for (tick, place) in walk.into_iter().enumerate() {
        scene.set_transform(guard, Mat4::from_translation(place.into()))?;
        let picked = pick(&scene, player, along);
        seen[tick] = (picked.instance, picked.t, sees(&scene, player, place, guard));
    }
    assert_eq!(ALLOCATIONS.get(), before, "the loop allocates");

    for (tick, (instance, distance, is_seen)) in seen.into_iter().enumerate() {
        let name = if instance == guard.number() { "the guard".into() } else { format!("crate {instance}") };
        let word = if is_seen { "seen" } else { "hidden" };
        println!("tick {tick}: the cursor is on {name}, {distance} away; the guard is {word}");
    }
    println!("nothing was allocated");
    // Rounded, but the same on every machine.
    let (near, far) = (2.499_999_8, 3.499_999_8);
    let expected = [(2, far, true), (2, far, true), (guard.number(), near, true), (2, far, false)];
    assert_eq!(seen, expected);
    Ok(())
}

/// The closest hit on the ray, of the instance and triangle with the least numbers where several are as close;
/// [`Hit::MISS`] if there is none. `direction` may have any length; `t` counts in it.
fn pick(scene: &Scene, origin: [f32; 3], direction: [f32; 3]) -> Hit {
    let mut best = ClosestHit::new(&Hit::MISS);
    ask(scene, origin, direction, Closest, None, &mut best);
    best.rows().hit(0)
}

/// Whether nothing but `to` itself is between two points.
fn sees(scene: &Scene, from: [f32; 3], at: [f32; 3], to: InstanceIndex) -> bool {
    // The ray ends where it arrives, at t = 1.
    let mut best = ClosestHit::new(&Hit { t: 1.0, ..Hit::MISS });
    let along = [0, 1, 2].map(|axis| at[axis] - from[axis]);
    ask(scene, from, along, Any, Some(to), &mut best);
    // Whatever is met ends the search.
    best.t > 0.0
}

/// Asks the ray of every instance but one. A world of thousands would ask a grid of its own first.
fn ask(
    scene: &Scene,
    origin: [f32; 3],
    direction: [f32; 3],
    filter: impl HitFilter<f32>,
    but: Option<InstanceIndex>,
    best: &mut ClosestHit<f32>,
) {
    let (low, high) = scene.extent().unwrap_or_default();
    // Of all coordinates the largest: by its rounding error, boxes in the world are wider.
    let largest = |v: Vec3| v.abs().max_element();
    let magnitude = largest(low).max(largest(high)).max(largest(origin.into()));
    let geometry = Geometry {
        instances: scene.instances(),
        nodes: scene.nodes(),
        mesh_data: scene.mesh_data(),
        positions: scene.positions(),
        texels: scene.texels(),
        magnitude,
    };
    let ray = Ray::<f32>::new(V3::splat((), origin), V3::splat((), direction));
    // A packet of one ray, in one tile.
    let (mut hits, mut filters) = (PacketHits::new([*best]), [filter]);
    for (number, instance) in (0..).zip(scene.instances()) {
        let (low, high) = instance.padded_aabb(magnitude);
        if but.is_some_and(|but| but.number() == number)
            || ray_hit_mask(&[ray], &low, &high, 1, &hits.closest) == 0
        {
            continue;
        }
        let rays = [ray.to_object(instance)];
        let packet = Packet { rays: &rays, tiles: &Tiles::of(&rays, &hits.closest, 1) };
        traverse(&geometry, number, &packet, 1, &mut hits, &mut filters);
    }
    *best = hits.closest[0];
}

/// A cube with sides of 1 around the origin.
fn cube() -> Result<Mesh, Box<dyn Error>> {
    let corner = |i: u32| [0, 1, 2].map(|axis| if i >> axis & 1 == 1 { 0.5 } else { -0.5 });
    let sides = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
    let triangles = sides.into_iter().flat_map(|[a, b, c, d]| [a, b, c, a, c, d]);
    let attribute = Attribute { normal: [0.0; 3], uv: [0.0; 2], color: u32::MAX };
    Ok(Mesh::new((0..8).map(corner).collect(), vec![attribute; 8], triangles.collect())?)
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

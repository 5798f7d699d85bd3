//! A game asks rays of its world with `rtrt-core` alone: what is under the cursor, and who sees whom, while
//! things move.
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
//! Building the world allocates. The loop does not, and needs no `std`. There is no renderer.

use glam::{Mat4, Vec3};
use rtrt_core::query::{Ray, Tree};
use rtrt_core::scene::{Attribute, Bvh, Material, Mesh, Scene, Sequential};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    // A guard, who is a sphere, and two crates.
    let mut scene = Scene::new();
    let material = scene.add_material(Material::new([0.5; 3]))?;
    let cube = cube()?;
    let cube = scene.add_mesh(&cube, &Bvh::build(&cube, &Sequential))?;
    let at = |place: Vec3| Mat4::from_translation(place);
    let guard = scene.add_sphere(material, at(Vec3::X * -3.0) * Mat4::from_scale(Vec3::splat(0.5)))?;
    scene.add_instance(cube, material, at(Vec3::X * 2.0))?;
    scene.add_instance(cube, material, at(Vec3::ZERO))?;
    let mut tree = Tree::new(&scene, &Sequential);

    // Player and cursor, and where the guard goes.
    let (player, along) = (Vec3::new(0.0, 0.0, 4.0), Vec3::NEG_Z);
    let walk = [[-3.0, 0.0, 0.0], [-1.5, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -3.0]];
    let before = ALLOCATIONS.get();
    let mut seen = [(guard, 0.0, false); 4];
    for (tick, place) in walk.map(Vec3::from).into_iter().enumerate() {
        scene.set_transform(guard, at(place) * Mat4::from_scale(Vec3::splat(0.5)))?;
        let world = tree.world(&scene);
        let picked = world.closest(&Ray::new(player, along))?.ok_or("there is always a crate")?;
        let is_hidden = world.occluded(&Ray::between(player, place).skip(guard))?;
        seen[tick] = (picked.instance, picked.t, !is_hidden);
    }
    assert_eq!(ALLOCATIONS.get(), before, "the loop allocates");

    for (tick, (instance, distance, is_seen)) in seen.into_iter().enumerate() {
        let name = if instance == guard { "the guard" } else { &format!("crate {}", instance.number()) };
        let word = if is_seen { "seen" } else { "hidden" };
        println!("tick {tick}: the cursor is on {name}, {distance} away; the guard is {word}");
    }
    println!("nothing was allocated");
    // Rounded, but the same on every machine.
    let (near, far) = (2.499_999_8, 3.499_999_8);
    let crate_2 = scene.instance_index(2).ok_or("a crate")?;
    let expected = [(crate_2, far, true), (crate_2, far, true), (guard, near, true), (crate_2, far, false)];
    assert_eq!(seen, expected);
    Ok(())
}

/// A cube with sides of 1 around the origin.
fn cube() -> Result<Mesh, Box<dyn Error>> {
    let corner = |i: u32| [0, 1, 2].map(|axis| if i >> axis & 1 == 1 { 0.5 } else { -0.5 });
    let sides = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
    let triangles = sides.into_iter().flat_map(|[a, b, c, d]| [a, b, c, a, c, d]);
    let attribute = Attribute { normal: [0.0; 3], uv: [0.0; 2], color: Attribute::WHITE };
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

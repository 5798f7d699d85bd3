//! A lightmap of a floor under a few balls: how much of the sky each point sees.
//!
//! ```text
//! $ cargo run --release -p rtrt-core --example bake -- floor.pgm
//! the floor sees 86.2 % of the sky on average
//!
//!
//!        .. .  .
//!       ....:.... .      ..=-.
//!    ...::------:.. ..  ..:--..
//!   ...::+**##=+-:...  . .  .
//!   ..::-+#@@%*=-:::.... .
//!   ...:-=+*#*+=-:-::--:...
//!   ...::::-----::--+%%*-...
//!   .  .....:::..::-+*#*=:.  .
//!          ....::.:::--:...
//!        .................
//!         .   .... ......
//!            . ... ...  .
//!              . ...
//! ```
//!
//! 256 rays from each point, traced together; `floor.pgm` has a pixel for each. The loop does not allocate, and the
//! picture has the same bytes on every machine.

use glam::{Mat4, Vec3};
use rtrt_core::query::{QueryError, Ray, Tree, World};
use rtrt_core::scene::{Material, Scene, Sequential};
use std::error::Error;

/// Texels along each side.
const SIDE: usize = 64;
const RAYS: usize = 256;
/// The floor, in world units.
const SIZE: f32 = 8.0;

fn main() -> Result<(), Box<dyn Error>> {
    let mut scene = Scene::new();
    let material = scene.add_material(Material::default())?;
    for (x, y, z, radius) in
        [(-1.5, 1.0, -1.0, 1.0), (1.0, 0.6, 0.3, 0.6), (0.0, 2.5, 1.8, 0.8), (2.4, 0.3, -2.2, 0.3)]
    {
        let place = Mat4::from_translation(Vec3::new(x, y, z)) * Mat4::from_scale(Vec3::splat(radius));
        scene.add_sphere(material, place)?;
    }
    let mut tree = Tree::new(&scene, &Sequential);
    let mut texels = [0_u8; SIDE * SIDE];
    bake(&tree.world(&scene), &mut texels)?;

    let average = texels.iter().map(|&texel| f64::from(texel)).sum::<f64>() / texels.len() as f64;
    println!("the floor sees {:.1} % of the sky on average", average / 2.55);
    for row in texels.chunks(SIDE).step_by(4) {
        let letter = |texel: &u8| b"@%#*+=-:. "[usize::from(*texel) * 10 / 256] as char;
        println!("{}", row.iter().step_by(2).map(letter).collect::<String>().trim_end());
    }
    if let Some(path) = std::env::args().nth(1).filter(|path| path.ends_with(".pgm")) {
        let header = format!("P5 {SIDE} {SIDE} 255\n");
        std::fs::write(path, [header.as_bytes(), &texels[..]].concat())?;
    }
    assert_eq!(texels.iter().map(|&texel| u32::from(texel)).sum::<u32>(), EXPECTED);
    Ok(())
}

/// The sum of all texels, on every machine.
const EXPECTED: u32 = 900_710;

/// The share of the sky that each point of the floor sees, weighted by the cosine: 255 for all of it.
fn bake(world: &World<'_>, texels: &mut [u8]) -> Result<(), QueryError> {
    for (number, texel) in texels.iter_mut().enumerate() {
        let at = |place: usize| (place as f32 + 0.5) * (SIZE / SIDE as f32) - SIZE * 0.5;
        let point = Vec3::new(at(number % SIDE), 0.0, at(number / SIDE));
        let rays: [Ray; RAYS] =
            core::array::from_fn(|ray| Ray::new(point, direction(ray as u32, number as u32)));
        let mut occluded = [Ok(false); RAYS];
        world.occluded_each(&rays, &mut occluded);
        let mut seen = 0;
        for occluded in occluded {
            seen += usize::from(!occluded?);
        }
        *texel = (seen * 255 / RAYS) as u8;
    }
    Ok(())
}

/// A direction above the floor. A point that is evenly spread over a disc, raised to the hemisphere, is spread by the cosine
/// (Malley's method).
fn direction(ray: u32, seed: u32) -> Vec3 {
    let mut state = ray.wrapping_mul(0x9e37_79b9) ^ seed.wrapping_mul(0x85eb_ca6b);
    let mut next = || {
        state = (state ^ state >> 15).wrapping_mul(0x2c1b_3c6d).wrapping_add(0x6d2b_79f5);
        ((state ^ state >> 13) >> 8) as f32 / (1 << 23) as f32 - 1.0
    };
    loop {
        let (x, z) = (next(), next());
        let left = 1.0 - x * x - z * z;
        if left > 1e-4 {
            return Vec3::new(x, left.sqrt(), z);
        }
    }
}

#[test]
fn runs() {
    main().expect("no error");
}

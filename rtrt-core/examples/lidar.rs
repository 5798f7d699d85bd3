//! A lidar on a robot scans a hall with pillars: 8 beams, 128 directions, and what it sees from above.
//!
//! ```text
//! $ cargo run --release -p rtrt-core --example lidar
//! 285 returns from walls, 232 from pillars, 86 from the ball
//! nothing is nearer than 2.023
//!       # ############    ############ #
//!
//!
//!
//!              #      #  #      #
//!             #        ##        #             #
//!                                              #
//!                                              #
//!                       R                      #
//!                          ++                  #
//!             #        ##  +                   #
//!              #       ##                      #
//! ```
//!
//! A return has a distance, the cosine of the angle at which the beam arrives, and the number that the user gave to
//! what it hits. The scan does not allocate.

use glam::{Mat4, Vec3};
use rtrt_core::query::{QueryError, Ray, Tree, World};
use rtrt_core::scene::{Material, Scene, Sequential};
use std::error::Error;

const BEAMS: usize = 8;
const TURNS: usize = 128;
/// No return comes from farther away.
const REACH: f32 = 12.0;
/// Characters of the map.
const MAP: [usize; 2] = [49, 17];

/// What a beam returns.
#[derive(Debug, Clone, Copy, Default)]
struct Return {
    distance: f32,
    cosine: f32,
    /// 0 for no return.
    what: u32,
    place: Vec3,
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut scene = Scene::new();
    let material = scene.add_material(Material::default())?;
    let mut put = |what: u32, center: [f32; 3], size: [f32; 3]| {
        let place = Mat4::from_translation(center.into()) * Mat4::from_scale(size.into());
        let ball = scene.add_sphere(material, place)?;
        scene.set_user_data(ball, what)
    };
    // Walls that are almost flat, six pillars and a ball.
    for (center, size) in [([11.0, 1.0, 0.0], [0.5, 9.0, 40.0]), ([0.0, 1.0, -7.5], [40.0, 9.0, 0.5])] {
        put(1, center, size)?;
    }
    for number in 0..6_u8 {
        let (x, z) = (f32::from(number % 3) * 5.0 - 6.0, f32::from(number / 3) * 7.0 - 3.5);
        put(2, [x, 1.0, z], [0.7, 9.0, 0.7])?;
    }
    put(3, [1.5, 0.6, 2.0], [0.9; 3])?;
    let mut tree = Tree::new(&scene, &Sequential);
    let mut scan = [[Return::default(); TURNS]; BEAMS];
    let robot = Vec3::new(-1.0, 0.8, 0.5);
    turn(&tree.world(&scene), robot, &mut scan)?;

    let count = |what: u32| scan.as_flattened().iter().filter(|found| found.what == what).count();
    println!("{} returns from walls, {} from pillars, {} from the ball", count(1), count(2), count(3));
    let nearest = scan.as_flattened().iter().filter(|found| found.what > 0).map(|found| found.distance);
    println!("nothing is nearer than {:.3}", nearest.fold(REACH, f32::min));
    for row in map(robot, &scan) {
        println!("{}", String::from_utf8_lossy(&row).trim_end());
    }
    assert_eq!([count(1), count(2), count(3)], EXPECTED);
    Ok(())
}

/// What is seen, on every machine.
const EXPECTED: [usize; 3] = [285, 232, 86];

/// Turns once around.
fn turn(world: &World<'_>, eye: Vec3, scan: &mut [[Return; TURNS]; BEAMS]) -> Result<(), QueryError> {
    for (beam, scan) in scan.iter_mut().enumerate() {
        // Points on a circle by adding a rotation again and again: machines agree on sums and products.
        let (mut x, mut z) = (1.0_f32, 0.0_f32);
        let height = beam as f32 * 0.06 - 0.2;
        for found in scan {
            let direction = Vec3::new(x, height, z).normalize();
            *found = Return::default();
            let hit = world.closest(&Ray::new(eye, direction).until(REACH))?;
            if let Some((hit, surface)) = hit.and_then(|hit| Some((hit, world.surface(&hit)?))) {
                *found = Return {
                    distance: hit.t,
                    cosine: -direction.dot(surface.normal.into()),
                    what: surface.user,
                    place: surface.position.into(),
                };
            }
            const STEP: [f32; 2] = [0.998_795_5, 0.049_067_674];
            (x, z) = (x * STEP[0] - z * STEP[1], x * STEP[1] + z * STEP[0]);
        }
    }
    Ok(())
}

/// The scan from above: darker where beams arrive straight.
fn map(robot: Vec3, scan: &[[Return; TURNS]; BEAMS]) -> [[u8; MAP[0]]; MAP[1]] {
    let mut map = [[b' '; MAP[0]]; MAP[1]];
    let mut put = |place: Vec3, letter: u8| {
        let (column, row) = ((place.x + 12.0) * 2.0, (place.z + 8.0) * 1.0);
        if column >= 0.0
            && row >= 0.0
            && let Some(cell) = map.get_mut(row as usize).and_then(|row| row.get_mut(column as usize))
        {
            *cell = letter;
        }
    };
    for found in scan.as_flattened().iter().filter(|found| found.what > 0) {
        put(found.place, if found.cosine > 0.5 { b'#' } else { b'+' });
    }
    put(robot, b'R');
    map
}

#[test]
fn runs() {
    main().expect("no error");
}

//! The studio: neutral surroundings for scenes that bring neither lights nor an environment.

use crate::scene::{Light, Panorama};
use core::f64::consts::{PI, TAU};
use glam::DVec3;

/// Rows of the panorama.
const HEIGHT: u32 = 128;

/// A lit rectangle, far away.
struct Softbox {
    /// Angle from +z toward +x, and above the horizon, degrees, of its middle.
    at: [f64; 2],
    /// Half its width and height at distance 1.
    half: [f64; 2],
    /// Its light.
    radiance: f64,
}

/// One above, a large one beside the key light, a wide one opposite of it, and two narrow ones behind,
/// which draw the edges of what is smooth.
const SOFTBOXES: [Softbox; 5] = [
    Softbox { at: [0.0, 90.0], half: [0.8, 0.6], radiance: 0.9 },
    Softbox { at: [-38.0, 38.0], half: [0.3, 0.36], radiance: 2.2 },
    Softbox { at: [75.0, 14.0], half: [0.6, 0.75], radiance: 0.55 },
    Softbox { at: [-148.0, 22.0], half: [0.14, 0.8], radiance: 1.8 },
    Softbox { at: [152.0, 22.0], half: [0.14, 0.8], radiance: 1.8 },
];
/// How wide the edge of a softbox is, as a share of its half width.
const EDGE: f64 = 0.12;
/// Light of the floor straight below, of floor and walls at the horizon, and of the ceiling.
const ROOM: [f64; 3] = [0.12, 0.26, 0.14];
/// Illuminance of the key light, lux: with the room's, a white surface that faces it is about as bright
/// as white.
const KEY: f32 = 1.7;
/// Half the angle under which the key light is seen, radians.
const KEY_RADIUS: f32 = 0.045;

/// The built-in surroundings: a panorama of a gray room with softboxes, all of it neutral, and the key
/// light that goes with it, a sun with soft shadows from the upper left of who looks along −z. A white
/// surface that faces the key light reflects about 1.
///
/// ```
/// # use rtrt_core::scene::{Scene, studio};
/// let mut scene = Scene::new();
/// let (panorama, key) = studio();
/// scene.set_environment(&panorama)?;
/// scene.add_light(key);
/// # Ok::<(), rtrt_core::scene::SceneError>(())
/// ```
pub fn studio() -> (Panorama, Light) {
    let (width, height) = (2 * HEIGHT, HEIGHT);
    let texel = |i: u32| {
        let (column, row) = (f64::from(i % width) + 0.5, f64::from(i / width) + 0.5);
        // Columns start at −x and go on toward −z.
        let (around, down) = ((column / f64::from(width) - 0.5) * TAU, row / f64::from(height) * PI);
        let across = libm::sin(down);
        let toward = DVec3::new(across * libm::cos(around), libm::cos(down), across * libm::sin(around));
        [radiance(toward) as f32; 3]
    };
    let panorama = Panorama { width, height, rgb: (0..width * height).map(texel).collect() };
    let key = -direction(SOFTBOXES[1].at);
    (panorama, Light::sun(key.as_vec3()).color([KEY; 3]).radius(KEY_RADIUS))
}

/// A direction by its angles in degrees.
fn direction([around, above]: [f64; 2]) -> DVec3 {
    let (around, above) = (around.to_radians(), above.to_radians());
    let across = libm::cos(above);
    DVec3::new(across * libm::sin(around), libm::sin(above), across * libm::cos(around))
}

/// The light from a direction of unit length.
fn radiance(toward: DVec3) -> f64 {
    let [low, middle, high] = ROOM;
    let end = if toward.y < 0.0 { low } else { high };
    let room = middle + (end - middle) * toward.y.abs();
    SOFTBOXES
        .iter()
        .fold(room, |light, lamp| light + (lamp.radiance - light).max(0.0) * covered(lamp, toward))
}

/// How much of a softbox there is in a direction, 0 ..= 1.
fn covered(lamp: &Softbox, toward: DVec3) -> f64 {
    let middle = direction(lamp.at);
    let around = lamp.at[0].to_radians();
    let right = DVec3::new(libm::cos(around), 0.0, -libm::sin(around));
    let up = middle.cross(right);
    let ahead = toward.dot(middle);
    if ahead <= 0.0 {
        return 0.0;
    }
    let side = |axis: DVec3, half: f64| {
        let inside = (1.0 - (toward.dot(axis) / ahead).abs() / half) / EDGE;
        let inside = inside.clamp(0.0, 1.0);
        inside * inside * (3.0 - 2.0 * inside)
    };
    side(right, lamp.half[0]) * side(up, lamp.half[1])
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::println;

    /// What a white surface reflects of the room.
    fn reflected(normal: DVec3) -> f64 {
        let (panorama, _) = studio();
        let (width, height) = (f64::from(panorama.width), f64::from(panorama.height));
        let mut sum = 0.0;
        for (i, light) in panorama.rgb.iter().enumerate() {
            let (x, y) = ((i as f64 % width).floor() + 0.5, (i as f64 / width).floor() + 0.5);
            let (around, down) = ((x / width - 0.5) * TAU, y / height * PI);
            let d = DVec3::new(down.sin() * around.cos(), down.cos(), down.sin() * around.sin());
            let angle = TAU / width * PI / height * down.sin();
            sum += f64::from(light[0]) * d.dot(normal).max(0.0) * angle;
        }
        sum / PI
    }

    #[test]
    fn white_that_faces_the_key_light_is_about_white_and_nothing_is_black() {
        let (_, key) = studio();
        let to_key = -key.direction.as_dvec3();
        for n in [DVec3::Y, DVec3::Z, DVec3::X, -DVec3::X, -DVec3::Z, -DVec3::Y, to_key] {
            let key = f64::from(KEY) / PI * n.dot(to_key).max(0.0);
            println!("{n} {:.3} + {key:.3}", reflected(n));
        }
        let facing = reflected(to_key) + f64::from(KEY) / PI;
        assert!((0.9..1.2).contains(&facing), "{facing}");
        assert!(reflected(-DVec3::Y) > 0.15 && reflected(-to_key) > 0.15);
    }

    #[test]
    fn the_studio_is_neutral() {
        let (panorama, key) = studio();
        assert!(panorama.rgb.iter().all(|[r, g, b]| r == g && g == b && (0.1..4.0).contains(r)));
        assert_eq!(key.color, glam::Vec3::splat(KEY));
    }
}

//! The sun in an environment: its brightest disc, taken out as a light that casts shadows.

use crate::scene::cube::direction;
use crate::scene::{Cube, Light, Panorama};
use alloc::vec::Vec;
use core::f64::consts::{PI, TAU};
use glam::DVec3;

/// How far from the brightest texel the sun may reach, and its surroundings begin; and where they end.
/// Degrees.
const REACH: [f64; 2] = [8.0, 16.0];
/// What is left of the sun: so many times the mean of its surroundings.
const REST: f64 = 4.0;
/// The least illuminance of a sun, as a share of what everything else sheds on a surface that faces it.
const LEAST: f64 = 0.25;
/// The most that a channel counts (2³⁰).
const BRIGHTEST: f64 = 1_073_741_824.0;

impl Panorama {
    /// Takes the sun out of the panorama, if there is one.
    ///
    /// The brightest texel is its middle. What is within 8° of it and more than four times as bright
    /// as the ring from 8° to 16° around it is the sun, and is darkened to that. The illuminance that
    /// this takes away, lux where the panorama is in nits, is the color of the light, and goes where
    /// most of it comes from; the light's radius is that of a disc over which it would be spread as
    /// far. There is no sun if everything else sheds more than four times as much on a surface that
    /// faces it, or if the panorama's size and pixels do not fit.
    pub fn take_sun(&mut self) -> Option<Light> {
        let &mut Self { width, height, ref mut rgb } = self;
        if rgb.len() as u64 != u64::from(width) * u64::from(height) {
            return None;
        }
        let turn = |i: u32, of: u32, all: f64| (f64::from(i) + 0.5) / f64::from(of) * all;
        let columns: Vec<_> = (0..width).map(|x| libm::sincos(turn(x, width, TAU) - PI)).collect();
        let rows: Vec<_> = (0..height).map(|y| libm::sincos(turn(y, height, PI))).collect();
        let size = TAU / f64::from(width) * PI / f64::from(height);
        take(&mut [rgb], |_, i| {
            let ((z, x), (across, up)) = (columns[i % columns.len()], rows[i / columns.len()]);
            (DVec3::new(across * x, up, across * z), size * across)
        })
    }
}

impl Cube {
    /// Takes the sun out of the cube, if there is one; see [`Panorama::take_sun`].
    pub fn take_sun(&mut self) -> Option<Light> {
        self.check().ok()?;
        let side = self.side as usize;
        // The faces are at distance 1, and 2 wide.
        let area = 4.0 / (side * side) as f64;
        take(&mut self.faces.each_mut(), |face, i| {
            let place = [i % side, i / side].map(|c| (c as f64 + 0.5) / side as f64);
            let toward = direction(face, place);
            let squared = toward.length_squared();
            let length = libm::sqrt(squared);
            (toward / length, area / (squared * length))
        })
    }
}

/// Luminance (ITU-R BT.709).
fn luminance(rgb: DVec3) -> f64 {
    rgb.dot(DVec3::new(0.2126, 0.7152, 0.0722))
}

/// A texel's light as it counts.
fn light(rgb: &[f32; 3]) -> DVec3 {
    DVec3::from(rgb.map(|c| if c > 0.0 { f64::from(c).min(BRIGHTEST) } else { 0.0 }))
}

/// Takes the sun out of these pictures. `place` says where a texel of a picture is seen, and how large,
/// steradians.
fn take(pictures: &mut [&mut Vec<[f32; 3]>], place: impl Fn(usize, usize) -> (DVec3, f64)) -> Option<Light> {
    let middle = brightest(pictures, &place)?;
    let [inner, outer] = REACH.map(|degrees| libm::cos(degrees.to_radians()));
    let (mut sum, mut angle) = (0.0, 0.0);
    each(pictures, &place, |toward, size, light| {
        if (outer..inner).contains(&toward.dot(middle)) {
            (sum, angle) = (sum + luminance(light) * size, angle + size);
        }
    });
    let rest = REST * sum / angle;
    // What of a texel stays; less than 1 in the sun.
    let share = |toward: DVec3, light: DVec3| {
        let luminance = luminance(light);
        if toward.dot(middle) > inner && luminance > rest { rest / luminance } else { 1.0 }
    };
    let (mut color, mut direction) = (DVec3::ZERO, DVec3::ZERO);
    each(pictures, &place, |toward, size, light| {
        let taken = light * ((1.0 - share(toward, light)) * size);
        (color, direction) = (color + taken, direction + toward * luminance(taken));
    });
    let (illuminance, length) = (luminance(color), libm::sqrt(direction.length_squared()));
    if !(illuminance > 0.0 && length > 0.0) {
        return None;
    }
    let direction = direction / length;
    let (mut spread, mut others) = (0.0, 0.0);
    each(pictures, &place, |toward, size, light| {
        let (all, share, cosine) = (luminance(light) * size, share(toward, light), toward.dot(direction));
        if share < 1.0 {
            let off = libm::acos(cosine.clamp(-1.0, 1.0));
            spread += all * (1.0 - share) * off * off;
        }
        others += all * share * cosine.max(0.0);
    });
    if illuminance < LEAST * others {
        return None;
    }
    for (number, picture) in pictures.iter_mut().enumerate() {
        for (i, rgb) in picture.iter_mut().enumerate() {
            let share = share(place(number, i).0, light(rgb));
            if share < 1.0 {
                *rgb = (light(rgb) * share).as_vec3().to_array();
            }
        }
    }
    // Over a disc the mean square of the distance from its middle is half the square of its radius.
    let radius = libm::sqrt(2.0 * spread / illuminance) as f32;
    Some(Light::sun((-direction).as_vec3()).color(color.as_vec3()).radius(radius))
}

/// Where the brightest texel is seen; none if all is black.
fn brightest(
    pictures: &[&mut Vec<[f32; 3]>],
    place: &impl Fn(usize, usize) -> (DVec3, f64),
) -> Option<DVec3> {
    let (mut most, mut at) = (0.0, None);
    for (number, picture) in pictures.iter().enumerate() {
        for (i, rgb) in picture.iter().enumerate() {
            let luminance = luminance(light(rgb));
            if luminance > most {
                (most, at) = (luminance, Some((number, i)));
            }
        }
    }
    at.map(|(number, i)| place(number, i).0)
}

/// Visits each texel: where it is, how large, and its light.
fn each(
    pictures: &[&mut Vec<[f32; 3]>],
    place: &impl Fn(usize, usize) -> (DVec3, f64),
    mut visit: impl FnMut(DVec3, f64, DVec3),
) {
    for (number, picture) in pictures.iter().enumerate() {
        for (i, rgb) in picture.iter().enumerate() {
            let (toward, size) = place(number, i);
            visit(toward, size, light(rgb));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec;

    const WIDTH: u32 = 512;
    const HEIGHT: u32 = 256;

    /// Where a texel of a panorama is seen, and how large it is.
    fn place(i: usize) -> (DVec3, f64) {
        let around = ((i % WIDTH as usize) as f64 + 0.5) / f64::from(WIDTH) * TAU - PI;
        let down = ((i / WIDTH as usize) as f64 + 0.5) / f64::from(HEIGHT) * PI;
        let d = DVec3::new(down.sin() * around.cos(), down.cos(), down.sin() * around.sin());
        (d, TAU / f64::from(WIDTH) * PI / f64::from(HEIGHT) * down.sin())
    }

    /// A sky of this light, with a disc of this radius (degrees) and light around a direction.
    fn sky(sky: f32, toward: DVec3, degrees: f64, disc: [f32; 3]) -> Panorama {
        let edge = libm::cos(degrees.to_radians());
        let texel = |i: u32| if place(i as usize).0.dot(toward) > edge { disc } else { [sky; 3] };
        Panorama { width: WIDTH, height: HEIGHT, rgb: (0..WIDTH * HEIGHT).map(texel).collect() }
    }

    #[test]
    fn a_sun_is_found_where_it_is_as_large_and_bright_as_it_is() {
        let toward = DVec3::new(2.0, 3.0, -1.0).normalize();
        let mut panorama = sky(1.0, toward, 3.0, [900.0, 800.0, 600.0]);
        let sun = panorama.take_sun().unwrap();
        assert!(sun.direction.as_dvec3().dot(-toward) > 0.9999);
        assert!((sun.radius.to_degrees() - 3.0).abs() < 0.15, "{}", sun.radius.to_degrees());
        // Steradians of the cap, times the light less what stays.
        let cap = TAU * (1.0 - libm::cos(3_f64.to_radians()));
        let kept = 4.0 / luminance(DVec3::new(900.0, 800.0, 600.0));
        for (is, light) in sun.color.to_array().iter().zip([900.0, 800.0, 600.0]) {
            let expected = light * (1.0 - kept) * cap;
            assert!((f64::from(*is) - expected).abs() < 0.05 * expected, "{is} {expected}");
        }
        let brightest = panorama.rgb.iter().map(|&rgb| luminance(light(&rgb))).fold(0.0, f64::max);
        assert!((brightest - 4.0).abs() < 1e-5);
    }

    #[test]
    fn what_is_taken_is_what_is_missing() {
        let toward = DVec3::new(-1.0, 0.5, 1.0).normalize();
        let before = sky(0.5, toward, 1.0, [20_000.0; 3]);
        let mut after = before.clone();
        let sun = after.take_sun().unwrap();
        // On a surface that faces the sun, in f64.
        let shed = |panorama: &Panorama| -> f64 {
            let texel = |(i, rgb): (usize, &[f32; 3])| {
                let (d, size) = place(i);
                f64::from(rgb[1]) * d.dot(-sun.direction.as_dvec3()).max(0.0) * size
            };
            panorama.rgb.iter().enumerate().map(texel).sum()
        };
        let (all, rest) = (shed(&before), shed(&after));
        assert!((all - rest - f64::from(sun.color.y)).abs() < 1e-3 * all, "{all} {rest} {}", sun.color.y);
    }

    #[test]
    fn an_even_sky_a_large_window_and_a_faint_moon_are_no_suns() {
        let toward = DVec3::Y;
        for (degrees, disc) in [(1.0, 1.0), (30.0, 50.0), (1.0, 20.0)] {
            let mut panorama = sky(1.0, toward, degrees, [disc; 3]);
            let before = panorama.clone();
            assert_eq!(panorama.take_sun(), None);
            assert_eq!(panorama, before);
        }
        assert_eq!(sky(0.0, toward, 1.0, [0.0; 3]).take_sun(), None);
        assert_eq!(Panorama { width: 8, height: 4, rgb: vec![] }.take_sun(), None);
        assert_eq!(Panorama { width: 0, height: 0, rgb: vec![] }.take_sun(), None);
    }

    #[test]
    fn a_cube_has_the_sun_that_its_panorama_has() {
        let toward = DVec3::new(0.4, 0.9, -0.3).normalize();
        let mut panorama = sky(1.0, toward, 4.0, [700.0, 600.0, 500.0]);
        let side = 128;
        let faces = core::array::from_fn(|face| {
            let texel = |i: u32| {
                let place = [i % side, i / side].map(|c| (f64::from(c) + 0.5) / f64::from(side));
                panorama.toward(direction(face, place).normalize()).as_vec3().to_array()
            };
            (0..side * side).map(texel).collect()
        });
        let mut cube = Cube { side, faces };
        let (a, b) = (panorama.take_sun().unwrap(), cube.take_sun().unwrap());
        assert!(a.direction.dot(b.direction) > 0.9999);
        assert!((a.color.y / b.color.y - 1.0).abs() < 0.02 && (a.radius / b.radius - 1.0).abs() < 0.05);
    }
}

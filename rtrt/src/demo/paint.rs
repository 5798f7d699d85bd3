//! The textures of the demo, painted in code.

use super::noise::{Cloudy, Smooth, hash};
use crate::halves::each;
use rtrt_core::scene::{Image, Join};

/// sRGB, each 0 ..= 1.
type Color = [f32; 3];

/// A picture of `color(u, v)`, averaged over four points a pixel. Workers of `join` paint rows.
fn picture([width, height]: [u32; 2], join: &impl Join, color: impl Fn(f32, f32) -> Color + Sync) -> Image {
    let pixel = |x: u32, y: u32| {
        let mut sum = [0.0; 3];
        for (dx, dy) in [(0.25, 0.25), (0.75, 0.25), (0.25, 0.75), (0.75, 0.75)] {
            let c = color((x as f32 + dx) / width as f32, (y as f32 + dy) / height as f32);
            sum = [sum[0] + c[0], sum[1] + c[1], sum[2] + c[2]];
        }
        let [r, g, b] = sum.map(|s| (s * 0.25).clamp(0.0, 1.0) * 255.0 + 0.5).map(|c| c as u8);
        [r, g, b, 255]
    };
    let row = |&y: &u32| (0..width).flat_map(|x| pixel(x, y)).collect::<Vec<u8>>();
    let rows: Vec<u32> = (0..height).collect();
    Image { width, height, rgba: each(join, &rows, &row).concat() }
}

fn mix(a: Color, b: Color, share: f32) -> Color {
    let share = share.clamp(0.0, 1.0);
    [0, 1, 2].map(|i| a[i] + (b[i] - a[i]) * share)
}

fn scale(color: Color, by: f32) -> Color {
    color.map(|c| c * by)
}

/// 0 below `from`, 1 above `to`, smooth between them.
fn step(from: f32, to: f32, x: f32) -> f32 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Eight planks across, along `v`, of two lengths each; repeats.
pub(super) fn planks(join: &impl Join) -> Image {
    const ACROSS: f32 = 8.0;
    let rings: Vec<_> = (0..16).map(|plank| Cloudy::new([24, 2], 11 + plank)).collect();
    let fibers = Smooth::new([256, 16], 5);
    picture([512, 512], join, |u, v| {
        let row = (u * ACROSS) as u32;
        let shifted = v + hash(row, 0, 7);
        let shifted = (shifted - shifted as u32 as f32) * 2.0;
        let (x, y) = (u * ACROSS - row as f32, shifted - shifted as u32 as f32);
        let plank = row * 2 + shifted as u32;
        let tone = hash(plank, 1, 7);
        // Rings seen from the side: noise stretched along the plank, cut into bands.
        let rings = rings[plank as usize].at(u, v) * 5.0 + x;
        let band = (rings - rings as u32 as f32 - 0.5).abs() * 2.0;
        let fiber = fibers.at(u, v);
        let wood = mix([0.50, 0.31, 0.17], [0.70, 0.47, 0.27], 0.75 * tone + 0.25 * band);
        let wood = scale(wood, 0.84 + 0.1 * band + 0.12 * fiber);
        let edge = (x.min(1.0 - x) / ACROSS).min(y.min(1.0 - y) * 0.5);
        scale(wood, 0.35 + 0.65 * step(0.001, 0.005, edge))
    })
}

/// Lime plaster, nearly white; repeats.
pub(super) fn plaster(join: &impl Join) -> Image {
    let (stains, trowel) = (Cloudy::new([3, 3], 21), Cloudy::new([12, 40], 22));
    picture([512, 512], join, |u, v| {
        let grain = hash((u * 512.0) as u32, (v * 512.0) as u32, 23);
        scale([0.93, 0.89, 0.81], 0.84 + 0.1 * stains.at(u, v) + 0.07 * trowel.at(u, v) + 0.03 * grain)
    })
}

/// Eight by eight glazed tiles; repeats.
pub(super) fn tiles(join: &impl Join) -> Image {
    const SIDE: f32 = 8.0;
    let (cloudy, grainy) = (Cloudy::new([16, 16], 32), Cloudy::new([64, 64], 33));
    picture([512, 512], join, |u, v| {
        let (column, row) = ((u * SIDE) as u32, (v * SIDE) as u32);
        let (x, y) = (u * SIDE - column as f32, v * SIDE - row as f32);
        let edge = x.min(1.0 - x).min(y.min(1.0 - y));
        let tone = hash(column, row, 31);
        let glaze = mix([0.10, 0.33, 0.36], [0.22, 0.50, 0.49], tone);
        let glaze = scale(glaze, 0.88 + 0.2 * cloudy.at(u, v));
        // The rim is worn: lighter above and left, darker below and right.
        let rim = if x < y { 1.0 - x.min(y) } else { 1.0 - y.min(x) };
        let light = if x.min(y) < 1.0 - x.max(y) { 1.12 } else { 0.86 };
        let glaze = scale(glaze, 1.0 + (light - 1.0) * (1.0 - step(0.05, 0.13, edge)) * rim);
        let grout = scale([0.72, 0.70, 0.65], 0.8 + 0.2 * grainy.at(u, v));
        mix(grout, glaze, step(0.025, 0.05, edge))
    })
}

/// Gray board with fibers; repeats.
pub(super) fn board(join: &impl Join) -> Image {
    let [along, across] = [([128, 12], 41), ([12, 128], 42)].map(|(cells, seed)| Smooth::new(cells, seed));
    let stains = Cloudy::new([4, 4], 43);
    picture([256, 256], join, |u, v| {
        let fibers = along.at(u, v) * 0.5 + across.at(u, v) * 0.5;
        scale([0.80, 0.70, 0.55], 0.86 + 0.1 * fibers + 0.08 * stains.at(u, v))
    })
}

/// The striking surface: dark, grainy, in a pattern of lozenges; repeats.
pub(super) fn striker(join: &impl Join) -> Image {
    picture([256, 128], join, |u, v| {
        let (a, b) = (u * 24.0 + v * 12.0, u * 24.0 + 12.0 - v * 12.0);
        let line = |x: f32| ((x - x as u32 as f32) - 0.5).abs() * 2.0;
        let grain = hash((u * 256.0) as u32, (v * 128.0) as u32, 51);
        let dark = scale([0.26, 0.13, 0.10], 0.7 + 0.6 * grain);
        mix(dark, [0.45, 0.25, 0.18], 0.7 * step(0.75, 0.95, line(a).max(line(b))))
    })
}

/// A picture to hang up: hills at sunset.
pub(super) fn landscape(join: &impl Join) -> Image {
    let clouds = Cloudy::new([3, 9], 61);
    let ridges = [0, 1, 2].map(|hill| Cloudy::new([3 + hill, 1], 62 + hill));
    picture([384, 256], join, |u, v| {
        let sky = mix([0.25, 0.30, 0.52], [0.98, 0.70, 0.38], step(0.0, 0.62, v));
        let sky = mix(sky, [1.0, 0.86, 0.70], 0.6 * step(0.55, 0.8, clouds.at(u, v)));
        let from_sun = [(u - 0.66) * 1.5, v - 0.5];
        let distance = from_sun[0] * from_sun[0] + from_sun[1] * from_sun[1];
        let mut color = mix([1.0, 0.95, 0.78], sky, step(0.006, 0.0075, distance));
        let hills = [
            ([0.50, 0.36, 0.47], 0.52, 0.20),
            ([0.32, 0.27, 0.40], 0.62, 0.22),
            ([0.13, 0.15, 0.22], 0.76, 0.18),
        ];
        for (hill, (tone, height, steepness)) in hills.into_iter().enumerate() {
            let ridge = height + steepness * (ridges[hill].at(u, 0.5) - 0.5);
            color = mix(color, tone, step(ridge - 0.003, ridge + 0.003, v));
        }
        color
    })
}

/// The label of the matchbox: a flame in a sun, within a border, with words.
pub(super) fn label(join: &impl Join) -> Image {
    const ASPECT: f32 = 1.5;
    let stains = Cloudy::new([6, 4], 71);
    picture([768, 512], join, |u, v| {
        let paper = scale([0.96, 0.90, 0.74], 0.93 + 0.09 * stains.at(u, v));
        let (red, gold, ink) = ([0.72, 0.11, 0.09], [0.93, 0.66, 0.16], [0.16, 0.07, 0.06]);
        let (x, y) = (u * ASPECT, v);
        let edge = x.min(ASPECT - x).min(y.min(1.0 - y));
        let mut color = mix(red, paper, step(0.035, 0.039, edge));
        color = mix(color, red, step(0.052, 0.055, edge) - step(0.061, 0.064, edge));

        // A disk with rays around it, narrower outward.
        let (dx, dy) = (x - ASPECT * 0.5, y - 0.505);
        let radius = libm::sqrtf(dx * dx + dy * dy);
        let turn = libm::atan2f(dy, dx) * (24.0 / core::f32::consts::TAU) + 24.0;
        let ray = (turn - turn as u32 as f32 - 0.5).abs() * 2.0;
        let rays = step(0.215, 0.222, radius) * (1.0 - step(0.325, 0.33, radius));
        color = mix(color, gold, rays * step(0.45, 0.55, ray - (radius - 0.22) * 3.0 + 0.12));
        color = mix(color, red, 1.0 - step(0.205, 0.21, radius));
        color = flame(color, [dx, dy + 0.01], 0.175, gold);
        color = flame(color, [dx, dy - 0.05], 0.095, [1.0, 0.95, 0.75]);

        let words = text("RTRT", [x - ASPECT * 0.5, y - 0.125], 0.018)
            || text("SAFETY MATCHES", [x - ASPECT * 0.5, y - 0.885], 0.0098);
        let sides =
            text("CPU", [x - 0.25, y - 0.505], 0.011) || text("GPU", [x - ASPECT + 0.25, y - 0.505], 0.011);
        if words || sides { ink } else { color }
    })
}

/// A drop of `size` with its tip up, leaning a little.
fn flame(color: Color, [x, y]: [f32; 2], size: f32, fill: Color) -> Color {
    // From −1 at the tip to 1 at the bottom.
    let along = y / size;
    if !(-1.0..=1.0).contains(&along) {
        return color;
    }
    let lean = 0.12 * (1.0 - along * along) * along;
    let from_tip = (along + 1.0) * 0.5;
    let half = 0.62 * from_tip * libm::sqrtf((1.0 - from_tip) * (1.0 + from_tip)) * 1.25;
    mix(fill, color, step(half - 0.02, half + 0.02, (x / size - lean).abs()))
}

/// Whether the point, seen from the middle of a line of text, is on a letter whose dots are
/// `dot` wide.
fn text(text: &str, [x, y]: [f32; 2], dot: f32) -> bool {
    let columns = text.len() as f32 * 6.0 - 1.0;
    let (column, row) = (x / dot + columns * 0.5, y / dot + 3.5);
    if !(0.0..columns).contains(&column) || !(0.0..7.0).contains(&row) {
        return false;
    }
    let (letter, column) = (column as usize / 6, column as u32 % 6);
    column < 5 && glyph(text.as_bytes()[letter])[row as usize] >> (4 - column) & 1 == 1
}

/// A letter: seven rows of five dots, the leftmost highest.
fn glyph(letter: u8) -> [u8; 7] {
    match letter {
        b'A' => [0b01110, 0b10001, 0b10001, 0b11111, 0b10001, 0b10001, 0b10001],
        b'C' => [0b01110, 0b10001, 0b10000, 0b10000, 0b10000, 0b10001, 0b01110],
        b'E' => [0b11111, 0b10000, 0b10000, 0b11110, 0b10000, 0b10000, 0b11111],
        b'F' => [0b11111, 0b10000, 0b10000, 0b11110, 0b10000, 0b10000, 0b10000],
        b'G' => [0b01110, 0b10001, 0b10000, 0b10111, 0b10001, 0b10001, 0b01110],
        b'H' => [0b10001, 0b10001, 0b10001, 0b11111, 0b10001, 0b10001, 0b10001],
        b'M' => [0b10001, 0b11011, 0b10101, 0b10101, 0b10001, 0b10001, 0b10001],
        b'P' => [0b11110, 0b10001, 0b10001, 0b11110, 0b10000, 0b10000, 0b10000],
        b'R' => [0b11110, 0b10001, 0b10001, 0b11110, 0b10100, 0b10010, 0b10001],
        b'S' => [0b01111, 0b10000, 0b10000, 0b01110, 0b00001, 0b00001, 0b11110],
        b'T' => [0b11111, 0b00100, 0b00100, 0b00100, 0b00100, 0b00100, 0b00100],
        b'U' => [0b10001, 0b10001, 0b10001, 0b10001, 0b10001, 0b10001, 0b01110],
        b'Y' => [0b10001, 0b10001, 0b01010, 0b00100, 0b00100, 0b00100, 0b00100],
        _ => [0; 7],
    }
}

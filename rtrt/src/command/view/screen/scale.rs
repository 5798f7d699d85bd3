//! Pictures scaled to the window.

/// Fills `out`, rows of `to[0]` pixels, with a picture: red, green, blue and alpha, row by row. A pixel of `out` has red
/// in bits 16 to 23, green below, blue lowest.
///
/// Between the centers of pixels, colors are interpolated along both axes, with weights of 1/256; beyond the outermost
/// centers they are those of the edge. A picture of the same size keeps its colors.
pub fn scale(picture: &[u8], from: [u32; 2], out: &mut [u32], to: [u32; 2]) {
    let [width, height] = from.map(|side| side as usize);
    let [across, down] = to.map(|side| side as usize);
    if picture.len() < 4 * width * height || out.len() < across * down || width * height * across * down == 0
    {
        return;
    }
    let row = |y: usize| &picture[4 * width * y..4 * width * (y + 1)];
    if from == to {
        for (y, out) in out.chunks_exact_mut(across).take(down).enumerate() {
            for (out, pixel) in out.iter_mut().zip(row(y).chunks_exact(4)) {
                *out = u32::from_be_bytes([0, pixel[0], pixel[1], pixel[2]]);
            }
        }
        return;
    }
    let columns: Vec<Place> = (0..across).map(|x| Place::of(x, across, width)).collect();
    // The two rows between which pixels lie, scaled along their length.
    let mut rows = [(usize::MAX, vec![0; across]), (usize::MAX, vec![0; across])];
    for (y, out) in out.chunks_exact_mut(across).take(down).enumerate() {
        let Place { first, second, weight } = Place::of(y, down, height);
        if rows[0].0 != first {
            rows.swap(0, 1);
        }
        for (slot, number) in [first, second].into_iter().enumerate() {
            if rows[slot].0 != number {
                stretch(row(number), &columns, &mut rows[slot].1);
                rows[slot].0 = number;
            }
        }
        let [(_, upper), (_, lower)] = &rows;
        for ((out, upper), lower) in out.iter_mut().zip(upper).zip(lower) {
            *out = mixed(*upper, *lower, weight);
        }
    }
}

/// Where a pixel lies between two others.
#[derive(Debug, Clone, Copy)]
struct Place {
    first: usize,
    second: usize,
    /// The part of the second in 256.
    weight: u32,
}

impl Place {
    /// The pixel `number` of `count` among `of` others over the same length.
    fn of(number: usize, count: usize, of: usize) -> Self {
        // In 1/256 of the others: the place of its center, from the center of the first.
        let center = ((2 * number + 1) * of * 128 / count).saturating_sub(128);
        let first = (center / 256).min(of - 1);
        Self { first, second: (first + 1).min(of - 1), weight: (center % 256) as u32 }
    }
}

/// A row of a picture at these places.
fn stretch(row: &[u8], columns: &[Place], out: &mut [u32]) {
    let pixel = |number: usize| {
        let pixel = &row[4 * number..4 * number + 4];
        u32::from_be_bytes([0, pixel[0], pixel[1], pixel[2]])
    };
    for (out, Place { first, second, weight }) in out.iter_mut().zip(columns) {
        *out = mixed(pixel(*first), pixel(*second), *weight);
    }
}

/// Two colors mixed: two channels at a time.
#[inline]
fn mixed(a: u32, b: u32, weight: u32) -> u32 {
    const OUTER: u32 = 0x00ff_00ff;
    let mix = |a: u32, b: u32| (a * (256 - weight) + b * weight) >> 8;
    mix(a & OUTER, b & OUTER) & OUTER | mix(a >> 8 & 0xff, b >> 8 & 0xff) << 8
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scaled(picture: &[[u8; 4]], from: [u32; 2], to: [u32; 2]) -> Vec<u32> {
        let mut out = vec![0; (to[0] * to[1]) as usize];
        scale(picture.as_flattened(), from, &mut out, to);
        out
    }

    #[test]
    fn the_same_size_keeps_every_color() {
        let picture: Vec<[u8; 4]> = (0..12).map(|i| [i, 20 * i, 255 - i, 255]).collect();
        let seen = scaled(&picture, [4, 3], [4, 3]);
        assert!(seen.iter().zip(&picture).all(|(seen, [r, g, b, _])| seen.to_be_bytes() == [0, *r, *g, *b]));
    }

    #[test]
    fn pixels_lie_between_centers() {
        let picture = [[0, 0, 0, 255], [100, 200, 40, 255]];
        // Centers of four pixels over two: at -1/4, 1/4, 3/4 and 5/4 of the way from one to the other.
        let colors = [[0, 0, 0], [25, 50, 10], [75, 150, 30], [100, 200, 40]];
        let wanted = colors.map(|[r, g, b]| u32::from_be_bytes([0, r, g, b]));
        assert_eq!(scaled(&picture, [2, 1], [4, 1]), wanted);
        assert_eq!(scaled(&picture, [1, 2], [1, 4]), wanted);
    }

    #[test]
    fn one_color_stays_one_color() {
        for (from, to) in [([3, 2], [31, 17]), ([31, 17], [3, 2]), ([1, 1], [9, 9])] {
            let picture = vec![[9, 200, 255, 255]; (from[0] * from[1]) as usize];
            assert!(scaled(&picture, from, to).iter().all(|seen| *seen == 0x09_c8_ff), "{from:?} {to:?}");
        }
    }

    #[test]
    fn a_picture_that_is_too_short_is_not_shown() {
        assert_eq!(scaled(&[[9; 4]], [2, 2], [1, 1]), [0]);
        assert_eq!(scaled(&[], [0, 0], [1, 1]), [0]);
    }
}

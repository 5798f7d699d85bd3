//! How two pictures differ, in numbers and as a picture.

use crate::debug::heat;

/// The difference of two pictures of one size. Pixels are red, green, blue and alpha, row by row.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Difference {
    /// Pixels that differ.
    pub pixels: usize,
    /// The most steps by which a channel differs.
    pub most: u8,
    /// The smallest box around the pixels: left, top, and the first column and row beyond it.
    pub bounds: [u32; 4],
    /// Column and row of the first of them.
    pub first: [u32; 2],
    /// Its color.
    pub is: [u8; 4],
    /// The color that was expected.
    pub expected: [u8; 4],
}

/// The steps by which the channels of two colors differ, at most.
fn steps(a: [u8; 4], b: [u8; 4]) -> u8 {
    a.iter().zip(b).map(|(a, b)| a.abs_diff(b)).max().unwrap_or(0)
}

/// The pixels that differ by more than `tolerance` steps in a channel; none if there are none.
pub fn difference(is: &[[u8; 4]], expected: &[[u8; 4]], width: u32, tolerance: u8) -> Option<Difference> {
    let mut found: Option<Difference> = None;
    for (number, (&is, &expected)) in is.iter().zip(expected).enumerate() {
        let step = steps(is, expected);
        if step <= tolerance {
            continue;
        }
        let [x, y] = [number as u32 % width, number as u32 / width];
        let bounds = [x, y, x, y];
        let all = found.get_or_insert(Difference { pixels: 0, most: 0, bounds, first: [x, y], is, expected });
        let [left, top, right, bottom] = all.bounds;
        all.pixels += 1;
        all.most = all.most.max(step);
        all.bounds = [left.min(x), top.min(y), right.max(x + 1), bottom.max(y + 1)];
    }
    found
}

/// A picture of the difference: what is equal in dark gray, what differs from red (a step) to white (255 steps).
pub fn picture(is: &[[u8; 4]], expected: &[[u8; 4]]) -> Vec<[u8; 4]> {
    let pixel = |(&is, &expected): (&[u8; 4], &[u8; 4])| {
        let step = steps(is, expected);
        if step == 0 {
            let gray = (u32::from(expected[0]) + u32::from(expected[1]) + u32::from(expected[2])) / 12;
            return [gray as u8, gray as u8, gray as u8, 255];
        }
        let [r, g, b] = heat(0.5 + 0.5 * f32::from(step) / 255.0).map(|channel| (channel * 255.0) as u8);
        [r, g, b, 255]
    };
    is.iter().zip(expected).map(pixel).collect()
}

#[test]
fn a_difference_is_found_where_it_is() {
    let expected = [[10, 20, 30, 255]; 6];
    let mut is = expected;
    assert_eq!(difference(&is, &expected, 3, 0), None);
    is[1][0] = 12;
    is[5][2] = 0;
    let found = difference(&is, &expected, 3, 0).unwrap();
    assert_eq!((found.pixels, found.most, found.bounds), (2, 30, [1, 0, 3, 2]));
    assert_eq!((found.first, found.is, found.expected), ([1, 0], [12, 20, 30, 255], [10, 20, 30, 255]));
    assert_eq!(difference(&is, &expected, 3, 2).unwrap().first, [2, 1]);
    let shown = picture(&is, &expected);
    assert_eq!(shown[0], [5, 5, 5, 255]);
    assert!(shown[1][0] > 200 && shown[1][1] < 60, "{:?}", shown[1]);
}

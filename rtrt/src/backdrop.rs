//! Another background, put behind a frame that is already rendered.

use rtrt_core::backend::Picture;
use rtrt_core::grid::Grid;
use rtrt_core::layout::NONE;
use rtrt_core::stage::resolve::{average, resolve};

/// Gives the sub-rays that hit nothing this color (linear RGB multiplied by alpha, and alpha), and resolves the
/// pixels anew; whether the picture's deferred buffers were kept, without which that cannot be done.
///
/// What is seen through a surface stays as it was. Pixels get straight alpha, deferred colors stay multiplied.
pub fn put_behind(picture: &mut Picture, samples: u32, color: [f32; 4]) -> bool {
    let Some(deferred) = &mut picture.deferred else { return false };
    for (hit, ray) in deferred.hits.iter().zip(&mut deferred.colors) {
        if hit.object == NONE {
            *ray = color;
        }
    }
    let grid = Grid { width: picture.width, height: picture.height, side: samples.isqrt() };
    for (number, pixel) in (0..).zip(&mut picture.pixels) {
        let at = grid.pixel(number);
        let mixed = straight(average(grid, at, &|ray| deferred.colors[ray.0 as usize]));
        *pixel = resolve::<f32>((), Grid { side: 1, ..grid }, |_| at, |_| mixed).0;
    }
    true
}

/// A color that was multiplied by its alpha, as it was before.
pub(crate) fn straight([r, g, b, a]: [f32; 4]) -> [f32; 4] {
    if a > 0.0 && a < 1.0 { [r / a, g / a, b / a, a] } else { [r, g, b, a] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rtrt_core::backend::Deferred;
    use rtrt_core::grid::BLOCK_RAYS;
    use rtrt_core::layout::Hit;

    #[test]
    fn half_a_pixel_is_half_covered() {
        let mut deferred = Deferred {
            hits: vec![Hit::MISS; BLOCK_RAYS as usize],
            colors: vec![[0.25, 0.5, 0.75, 1.0]; BLOCK_RAYS as usize],
            ..Deferred::default()
        };
        let grid = Grid { width: 2, height: 1, side: 2 };
        for place in [[0, 0], [1, 1]] {
            deferred.hits[grid.index(place).0 as usize].object = 3;
        }
        let picture = Picture {
            width: 2,
            height: 1,
            pixels: vec![1; 2],
            deferred: Some(deferred),
            ..Picture::default()
        };
        let bytes = |color| {
            let mut picture = picture.clone();
            assert!(put_behind(&mut picture, 4, color));
            picture.bytes().to_vec()
        };
        let [r, g, b] =
            [0.25_f32, 0.5, 0.75].map(|value| (rtrt_core::num::srgb_encode(value) * 255.0 + 0.5) as u8);
        assert_eq!(bytes([0.0; 4]), [r, g, b, 128, 0, 0, 0, 0]);
        // The color that was there gives what was there.
        assert_eq!(bytes([0.25, 0.5, 0.75, 1.0]), [r, g, b, 255, r, g, b, 255]);
        assert!(!put_behind(&mut Picture::default(), 1, [0.0; 4]));
    }
}

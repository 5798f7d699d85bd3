//! Whether a picture is exposed so that much of it is white or black.

use rtrt_core::backend::Picture;
use rtrt_core::num::srgb_encode;
use rtrt_core::scene::Scene;

/// From this step on a channel counts as white, and up to that one as black.
const ENDS: [u8; 2] = [250, 3];
/// The share of a picture that may be white, and black, percent.
const LIMITS: [usize; 2] = [33, 75];
/// From this step on the brightest channel of a pixel counts as bright.
const BRIGHT: u8 = 128;
/// The share of a picture whose bright pixels may be white, and of these pixels the share that may be, percent.
const LAMPS: [usize; 2] = [5, 75];

/// A line about a picture of which a third is white, or three quarters are black; or whose bright places are white, most
/// of them: what lamps light is then lost, though it is little. Pixels of the background's color do not count, nor do
/// transparent ones.
pub fn clipped(scene: &Scene, picture: &Picture) -> Option<String> {
    let background = scene.background.to_array().map(|c| (srgb_encode(c) * 255.0 + 0.5) as u8);
    let bytes = picture.bytes();
    let pixels = bytes.as_chunks::<4>().0;
    let counted = || pixels.iter().filter(|&&[r, g, b, a]| a > 0 && [r, g, b] != background);
    let all = counted().count();
    let share = |is: fn(u8) -> bool| {
        let clipped = counted().filter(|[r, g, b, _]| is(*r) && is(*g) && is(*b)).count();
        (100 * clipped).checked_div(all).unwrap_or(0)
    };
    let (white, black) = (share(|c| c >= ENDS[0]), share(|c| c <= ENDS[1]));
    let bright = counted().filter(|[r, g, b, _]| *r.max(g).max(b) >= BRIGHT).count();
    let is_lost = white >= LAMPS[0] && white * all >= LAMPS[1] * bright;
    let (percent, what) = if white >= LIMITS[0] || is_lost {
        (white, "white")
    } else if black >= LIMITS[1] {
        (black, "black")
    } else {
        return None;
    };
    Some(format!("{percent} % of the picture is {what}; --exposure auto finds another exposure"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is said of a picture of 100 pixels, of which the first ones have these colors.
    fn said(colors: &[([u8; 4], usize)]) -> Option<String> {
        let mut pixels = vec![[100, 120, 140, 255]; 100];
        let all = colors.iter().flat_map(|&(color, count)| std::iter::repeat_n(color, count));
        pixels.iter_mut().zip(all).for_each(|(pixel, color)| *pixel = color);
        let pixels = pixels.into_iter().map(u32::from_le_bytes).collect();
        let mut scene = Scene::new();
        scene.background = [0.0; 3].into();
        let picture = Picture { width: 10, height: 10, pixels, ..Picture::default() };
        clipped(&scene, &picture)
    }

    #[test]
    fn much_white_or_black_is_named_with_the_option_that_helps() {
        let (white, black, red) = ([255, 252, 250, 255], [1, 2, 3, 255], [255, 0, 0, 255]);
        assert_eq!(said(&[(white, 32), (black, 40), (red, 28)]), None);
        // A lamp's spots in the dark, and a light place in a picture of others.
        let dark = [60, 20, 10, 255];
        assert!(said(&[(white, 5), (dark, 95)]).unwrap().starts_with("5 % of the picture is white"));
        assert_eq!(said(&[(white, 4), (dark, 96)]), None);
        assert_eq!(said(&[(white, 5), (dark, 80)]), None);
        let line = said(&[(white, 33)]).unwrap();
        assert!(
            line.starts_with("33 % of the picture is white") && line.contains("--exposure auto"),
            "{line}"
        );
        assert!(said(&[(black, 75)]).unwrap().starts_with("75 % of the picture is black"));
    }

    #[test]
    fn neither_background_nor_transparent_pixels_count() {
        let (background, clear, white) = ([0, 0, 0, 255], [0; 4], [255; 4]);
        assert_eq!(said(&[(background, 95)]), None);
        assert_eq!(said(&[(clear, 100)]), None);
        let line = said(&[(background, 60), (clear, 20), (white, 10)]).unwrap();
        assert!(line.starts_with("50 %"), "{line}");
    }
}

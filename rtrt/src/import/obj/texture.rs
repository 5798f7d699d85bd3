//! Images of MTL materials, brought into the layout that the renderer has.

use rtrt_core::scene::Image;

/// The channel of an image that a scalar is read from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Channel {
    /// Red, green, blue, alpha.
    Index(usize),
    /// The mean of red, green and blue.
    Luminance,
}

impl Channel {
    /// The channel that `-imfchan` names: `r`, `g`, `b`, `m` (alpha), `l` (luminance). Without it, alpha where an image
    /// has alpha and `prefers_alpha`, else luminance.
    pub fn of(name: Option<char>, image: &Image, prefers_alpha: bool) -> Self {
        match name {
            Some('r') => Self::Index(0),
            Some('g') => Self::Index(1),
            Some('b') => Self::Index(2),
            Some('m') => Self::Index(3),
            None if prefers_alpha && has_alpha(image) => Self::Index(3),
            _ => Self::Luminance,
        }
    }

    fn read(self, texel: [u8; 4]) -> u8 {
        match self {
            Self::Index(index) => texel[index],
            Self::Luminance => (texel[..3].iter().map(|&c| u32::from(c)).sum::<u32>() / 3) as u8,
        }
    }
}

/// Whether a texel is not opaque.
pub(super) fn has_alpha(image: &Image) -> bool {
    image.rgba.chunks_exact(4).any(|texel| texel[3] != 255)
}

/// Whether hardly any texel is partly transparent, as in images of leaves and fences.
///
/// Edges have partly transparent texels too; one in 20 is allowed.
pub(super) fn is_cutout(image: &Image) -> bool {
    let between = image.rgba.chunks_exact(4).filter(|texel| (16..240).contains(&texel[3])).count();
    between * 20 <= image.rgba.len() / 4
}

/// Whether an image may be a normal map: the mean of its texels points along +z. A gray image is one of heights.
pub(super) fn is_normal_map(image: &Image) -> bool {
    let texels = image.rgba.len() as u64 / 4;
    let mean = |channel: usize| {
        image.rgba.iter().skip(channel).step_by(4).map(|&c| u64::from(c)).sum::<u64>() / texels.max(1)
    };
    let [r, g, b] = [mean(0), mean(1), mean(2)];
    b > r + 32 && b > g + 32
}

/// `color` with the scalar in `mask` as alpha.
pub(super) fn with_alpha(color: &Image, mask: &Image, channel: Channel) -> Image {
    combined([color, mask], |[color, mask]| [color[0], color[1], color[2], channel.read(mask)])
}

/// Roughness in green and metalness in blue. An absent one is 255, which multiplies by 1.
pub(super) fn roughness_and_metalness(
    roughness: Option<(&Image, Channel)>,
    metalness: Option<(&Image, Channel)>,
) -> Image {
    let white = Image { width: 1, height: 1, rgba: vec![255; 4] };
    let of = |map: Option<(&Image, Channel)>| map.map_or(Channel::Luminance, |(_, channel)| channel);
    let images = [roughness, metalness].map(|map| map.map_or(&white, |(image, _)| image));
    combined(images, |[r, m]| [255, of(roughness).read(r), of(metalness).read(m), 255])
}

/// Two images, texel by texel, at the size of the one with more texels. Both are looked up at the nearest texel.
fn combined(images: [&Image; 2], texel: impl Fn([[u8; 4]; 2]) -> [u8; 4]) -> Image {
    let [first, second] = images;
    let (width, height) = if second.rgba.len() > first.rgba.len() {
        (second.width, second.height)
    } else {
        (first.width, first.height)
    };
    let at = |image: &Image, x: u32, y: u32| {
        let nearest =
            |at: u32, size: u32, of: u32| (u64::from(at) * u64::from(size) / u64::from(of)) as usize;
        let (x, y) = (nearest(x, image.width, width), nearest(y, image.height, height));
        let place = 4 * (y * image.width as usize + x);
        core::array::from_fn(|channel| image.rgba[place + channel])
    };
    let rows = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let rgba = rows.flat_map(|(x, y)| texel(images.map(|image| at(image, x, y))));
    Image { width, height, rgba: rgba.collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn images_of_different_sizes_are_combined_at_the_larger_size() {
        let color = Image { width: 2, height: 1, rgba: vec![1, 2, 3, 255, 4, 5, 6, 255] };
        let mask = Image { width: 1, height: 3, rgba: [[0, 0, 30, 255], [90; 4], [60; 4]].concat() };
        let both = with_alpha(&color, &mask, Channel::Luminance);
        assert_eq!((both.width, both.height), (1, 3));
        assert_eq!(both.rgba, [1, 2, 3, 10, 1, 2, 3, 90, 1, 2, 3, 60]);
        let both = roughness_and_metalness(None, Some((&color, Channel::Index(2))));
        assert_eq!(both.rgba, [255, 255, 3, 255, 255, 255, 6, 255]);
    }

    #[test]
    fn alpha_is_the_channel_of_a_mask_that_has_it() {
        let mask = Image { width: 1, height: 1, rgba: vec![9, 9, 9, 77] };
        let channel = |name, prefers| Channel::of(name, &mask, prefers).read([9, 9, 9, 77]);
        assert_eq!([channel(None, true), channel(None, false), channel(Some('l'), true)], [77, 9, 9]);
        assert_eq!(channel(Some('m'), false), 77);
    }
}

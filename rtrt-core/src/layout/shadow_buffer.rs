//! Where the shadows of a band of rays are.

use crate::layout::{Frame, ShadowKind};

/// Where the words of a band's shadow rays are in one buffer, in frames whose shadows are not bits.
///
/// | words                | of             | where                                  |
/// |----------------------|----------------|----------------------------------------|
/// | transmittance        | ray and light  | first                                  |
/// | radius of a penumbra | ray and light  | behind, in frames with soft shadows    |
/// | origin               | ray, three     | behind all else                        |
///
/// Before the shadow rays are traced, the word of the transmittance says whether its ray is to be (see
/// [`potentially_lit`](crate::stage::occlusion::potentially_lit)). Origins are here as an entry point of a
/// GPU may bind eight buffers, and with those of the surfaces there would be nine.
#[derive(Clone, Copy, Debug)]
pub struct ShadowBuffer {
    rays: u32,
    lights: u32,
    /// Words of a ray and light.
    words: u32,
}

impl ShadowBuffer {
    /// That of the rays of `frame`, a band or all of them.
    #[inline(always)]
    pub fn new(frame: &Frame) -> Self {
        let words = if frame.shadow_kind() == ShadowKind::Penumbra { 2 } else { 1 };
        Self { rays: frame.rays, lights: frame.lights, words }
    }
    /// Words of a ray.
    #[inline(always)]
    pub fn words_per_ray(&self) -> u32 {
        self.words * self.lights + 3
    }
    /// The transmittance of a light at a ray.
    #[inline(always)]
    pub fn transmittance(&self, ray: u32, light: u32) -> usize {
        (ray * self.lights + light) as usize
    }
    /// The radius of the penumbra there, in frames with soft shadows.
    #[inline(always)]
    pub fn penumbra_radius(&self, ray: u32, light: u32) -> usize {
        (self.rays * self.lights) as usize + self.transmittance(ray, light)
    }
    /// The first of three words: where a ray's shadow rays start.
    #[inline(always)]
    pub fn origin(&self, ray: u32) -> usize {
        (self.rays * self.words * self.lights + 3 * ray) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;
    use std::collections::BTreeSet;

    #[test]
    fn every_word_has_one_owner() {
        for penumbra_window in [0, 24] {
            let frame = Frame { rays: 256, lights: 3, penumbra_window, ..Frame::zeroed() };
            let (buffer, mut words) = (ShadowBuffer::new(&frame), BTreeSet::new());
            for ray in 0..frame.rays {
                words.extend((0..3).map(|i| buffer.origin(ray) + i));
                for light in 0..frame.lights {
                    words.insert(buffer.transmittance(ray, light));
                    if penumbra_window > 0 {
                        words.insert(buffer.penumbra_radius(ray, light));
                    }
                }
            }
            let count = (buffer.words_per_ray() * frame.rays) as usize;
            assert!(words.len() == count && words.last() == Some(&(count - 1)));
        }
    }
}

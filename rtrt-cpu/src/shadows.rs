//! What the rays of a block know of lights, where shadows are not bits: planes of words, a word of each
//! ray.

use crate::block::RAYS;
use alloc::vec::Vec;
use core::ops::Range;
use rtrt_core::layout::{Frame, ShadowKind};

/// The radius of the penumbra where there is none, nor light to ask for.
pub const NO_PENUMBRA: f32 = -1.0;

/// The planes of a light that reaches none of the rays.
static UNREACHED: [[u32; RAYS]; 2] = [[0; RAYS], [NO_PENUMBRA.to_bits(); RAYS]];

/// The first plane of a light that has none.
const ABSENT: u32 = u32::MAX;

/// The transmittance of each light and, where penumbras are filtered, their radii. A light has planes once
/// it is in reach of a packet: so planes follow the lights that reach a block, not all of a scene.
#[derive(Debug, Default)]
pub struct Shadows {
    /// The first of each light's planes.
    firsts: Vec<u32>,
    planes: Vec<[u32; RAYS]>,
    /// Planes of a light: its transmittance and, where penumbras are filtered, the radii.
    count: usize,
}

impl Shadows {
    /// Forgets all lights, and makes room for those of a frame.
    pub fn begin(&mut self, frame: &Frame) {
        self.count = 1 + usize::from(frame.shadow_kind() == ShadowKind::Penumbra);
        self.firsts.clear();
        self.firsts.resize(frame.transmittance_words() as usize, ABSENT);
        self.planes.clear();
    }

    /// Whether a light was in reach of a packet so far.
    #[inline(always)]
    pub fn is_reached(&self, light: u32) -> bool {
        self.firsts[light as usize] != ABSENT
    }

    /// The transmittance of a light.
    #[inline(always)]
    pub fn transmittance(&self, light: u32) -> &[u32; RAYS] {
        match self.firsts[light as usize] {
            ABSENT => &UNREACHED[0],
            first => &self.planes[first as usize],
        }
    }

    /// The transmittance of a light, and the radii of its penumbras.
    #[inline(always)]
    pub fn both(&self, light: u32) -> &[[u32; RAYS]] {
        match self.firsts[light as usize] {
            ABSENT => &UNREACHED,
            first => &self.planes[first as usize..][..2],
        }
    }

    /// The planes of a light, to be written: it has some from now on.
    #[inline(always)]
    pub fn planes_mut(&mut self, light: u32) -> &mut [[u32; RAYS]] {
        if !self.is_reached(light) {
            self.add(light);
        }
        &mut self.planes[self.firsts[light as usize] as usize..][..self.count]
    }

    #[inline(never)]
    fn add(&mut self, light: u32) {
        self.firsts[light as usize] = self.planes.len() as u32;
        self.planes.extend(UNREACHED.iter().take(self.count));
    }

    /// Leaves these rays without light.
    #[inline(always)]
    pub fn clear(&mut self, light: u32, rays: Range<usize>) {
        if self.is_reached(light) {
            for (plane, empty) in self.planes_mut(light).iter_mut().zip(&UNREACHED) {
                plane[rays.clone()].copy_from_slice(&empty[rays.clone()]);
            }
        }
    }

    /// The same for all lights.
    #[inline(always)]
    pub fn clear_all(&mut self, rays: Range<usize>) {
        for light in 0..self.firsts.len() as u32 {
            self.clear(light, rays.clone());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    #[test]
    fn only_lights_in_reach_take_memory() {
        let mut shadows = Shadows::default();
        shadows.begin(&Frame { lights: 1000, penumbra_window: 24, ..Frame::zeroed() });
        shadows.clear_all(0..RAYS);
        assert!(shadows.planes.is_empty() && !shadows.is_reached(7));
        assert_eq!(shadows.both(7), UNREACHED);

        assert_eq!(shadows.planes_mut(7), UNREACHED);
        shadows.planes_mut(7)[0][3..5].fill(5);
        shadows.planes_mut(7)[1][3..5].fill(6);
        shadows.clear(7, 4..RAYS);
        assert!(shadows.is_reached(7) && !shadows.is_reached(8));
        assert_eq!(shadows.transmittance(7)[3..5], [5, 0]);
        assert_eq!(shadows.both(7)[1][3..5], [6, NO_PENUMBRA.to_bits()]);
        assert_eq!(shadows.planes.len(), 2);
    }

    #[test]
    fn frames_without_penumbras_have_no_radii() {
        let frame = Frame { lights: 2, layers: 3, ..Frame::zeroed() };
        let mut shadows = Shadows::default();
        shadows.begin(&frame);
        shadows.planes_mut(1)[0][0] = 9;
        assert_eq!((shadows.transmittance(1)[0], shadows.planes.len()), (9, 1));
        shadows.begin(&frame);
        assert!(!shadows.is_reached(1));
    }
}

//! Which lights reach a packet's surfaces.

use crate::wide::Wide;
use rtrt_core::grid::{BLOCK_RAYS, RayIndex};
use rtrt_core::lane::{Bits, groups};
use rtrt_core::layout::Frame;
use rtrt_core::stage::context::Context;
use rtrt_core::stage::occlusion;
use rtrt_core::stage::surface::Surfaces;

/// Which lights reach a packet's surfaces.
pub enum Shadows<'a, L: Wide, const G: usize> {
    /// The words of the shadow mask; the usual scene has only the first.
    Bits { first: [L::Bits; G], more: Vec<[L::Bits; G]> },
    /// The transmittance of each light, where shadows are not bits: a block's words, light after light,
    /// from the packet's first on.
    Transmittance(L::Token, &'a [u32]),
}

impl<'a, L: Wide, const G: usize> Shadows<'a, L, G> {
    /// Hard shadows. Where not every instance is opaque, they are stored in `transmittance`.
    #[inline(always)]
    pub fn new(
        token: L::Token,
        context: &Context<'_>,
        ray: RayIndex,
        surfaces: &[Surfaces<L>; G],
        transmittance: &'a mut [u32],
    ) -> Self {
        let Context { frame, views, .. } = context;
        // Loops, not iterators: what is called back is not compiled for the instruction set.
        if frame.layers != 0 {
            let origins = groups(
                #[inline(always)]
                |g| surfaces[g].origin,
            );
            for light in 0..frame.lights {
                let active = groups(
                    #[inline(always)]
                    |g| {
                        let ray = RayIndex(ray.0 + (g * L::WIDTH) as u32);
                        occlusion::potentially_lit(frame, views, light, ray, &surfaces[g])
                    },
                );
                let arrivals = L::outlined(
                    token,
                    #[inline(always)]
                    || occlusion::transmittance::<L, false, G>(context, light, ray, &origins, &active),
                );
                for (g, arrival) in arrivals.into_iter().enumerate() {
                    L::store(
                        arrival.transmittance,
                        &mut transmittance[(light * BLOCK_RAYS) as usize + g * L::WIDTH..],
                    );
                }
            }
            return Self::Transmittance(token, transmittance);
        }
        let none = surfaces[0].material.broadcast(0);
        let (mut first, mut more) = ([none; G], Vec::new());
        for word in 0..frame.mask_words {
            let mask = L::outlined(
                token,
                #[inline(always)]
                || occlusion::word::<L, G>(context, word, ray, surfaces),
            );
            if word == 0 {
                first = mask;
            } else {
                more.push(mask);
            }
        }
        Self::Bits { first, more }
    }

    /// A word of the shadow mask of a group; `none` is 0.
    #[inline(always)]
    pub fn word(&self, frame: &Frame, word: u32, none: L::Bits, g: usize) -> L::Bits {
        match self {
            Self::Bits { first, .. } if word == 0 => first[g],
            Self::Bits { more, .. } => more[word as usize - 1][g],
            Self::Transmittance(..) => occlusion::mask(
                frame,
                word,
                none,
                #[inline(always)]
                |light| self.transmittance(light, none, g),
            ),
        }
    }

    /// The transmittance of a light at a group, where shadows are not bits.
    #[inline(always)]
    pub fn transmittance(&self, light: u32, none: L::Bits, g: usize) -> L::Bits {
        match self {
            Self::Bits { .. } => none,
            Self::Transmittance(token, transmittance) => {
                L::load(*token, &transmittance[(light * BLOCK_RAYS) as usize + g * L::WIDTH..])
            }
        }
    }
}

/// How many words [`Shadows`] are stored in, a block: at least one, so that every block has some.
pub fn transmittance_words(frame: &Frame) -> usize {
    let is_kept = frame.layers != 0 && frame.penumbra_window == 0;
    if is_kept { (BLOCK_RAYS * frame.lights).max(1) as usize } else { 1 }
}

//! What every block of a frame shares, and the stages of a packet.

use crate::shadows::Shadows;
use crate::wide::Wide;
use rtrt_core::grid::RayIndex;
use rtrt_core::kernel::closest_hit::ClosestHit;
use rtrt_core::kernel::texture::Maps;
use rtrt_core::lane::{Bits, V3, groups};
use rtrt_core::layout::{Attribute, Frame};
use rtrt_core::stage::context::Context;
use rtrt_core::stage::detail::detail;
use rtrt_core::stage::light::{IncomingLight, ShadowTerms, light};
use rtrt_core::stage::peel::{blend, peel};
use rtrt_core::stage::shade::shade;
use rtrt_core::stage::surface::{Surfaces, Vertices, surface};
use rtrt_core::stage::visibility::visibility;

/// What every block of a frame shares.
pub struct FrameContext<'a> {
    /// What stages read that trace rays.
    pub trace: Context<'a>,
    pub attributes: &'a [Attribute],
    pub maps: Maps<'a>,
}

/// The stages of a packet that need no other packet. Each is one function for all its callers, so that it
/// is compiled once for each instruction set. `frame` is the context's, but for the number of layers that
/// are still to come.
impl FrameContext<'_> {
    /// The closest surfaces; where not all is opaque, the closest behind the last.
    #[inline(always)]
    pub fn seen<L: Wide, const G: usize>(
        &self,
        token: L::Token,
        frame: &Frame,
        ray: RayIndex,
        last: &[ClosestHit<L>; G],
    ) -> [ClosestHit<L>; G] {
        let context = Context { frame, ..self.trace };
        if frame.layers == 0 {
            L::outlined(
                token,
                #[inline(always)]
                || visibility::<L, G>(token, &context, ray),
            )
        } else {
            L::outlined(
                token,
                #[inline(always)]
                || peel::<L, G>(token, &context, ray, last),
            )
        }
    }

    /// What is known about them.
    #[inline(always)]
    pub fn surfaces<L: Wide, const G: usize>(
        &self,
        token: L::Token,
        directions: &[V3<L>; G],
        best: &[ClosestHit<L>; G],
    ) -> [Surfaces<L>; G] {
        let FrameContext { trace: Context { geometry, .. }, attributes, .. } = self;
        let camera = self.trace.camera();
        L::outlined(
            token,
            #[inline(always)]
            || {
                groups(
                    #[inline(always)]
                    |g| surface(camera, geometry, attributes, directions[g], &best[g]),
                )
            },
        )
    }

    /// What normal maps and second texture coordinates tell of them.
    #[inline(always)]
    pub fn detail<L: Wide, const G: usize>(
        &self,
        token: L::Token,
        best: &[ClosestHit<L>; G],
        surfaces: &mut [Surfaces<L>; G],
    ) {
        let FrameContext { trace: Context { frame, geometry, .. }, attributes, maps } = self;
        if frame.details != 0 {
            let vertices =
                Vertices { instances: geometry.instances, mesh_data: geometry.mesh_data, attributes };
            L::outlined(
                token,
                #[inline(always)]
                || {
                    for g in 0..G {
                        surfaces[g] = detail(maps, &vertices, &best[g], &surfaces[g]);
                    }
                },
            );
        }
    }

    /// The light that arrives there.
    #[inline(always)]
    pub fn arriving<L: Wide, const G: usize>(
        &self,
        token: L::Token,
        frame: &Frame,
        first: RayIndex,
        directions: &[V3<L>; G],
        surfaces: &[Surfaces<L>; G],
        shadows: &Shadows<'_, L, G>,
    ) -> [IncomingLight<L>; G] {
        let views = self.trace.views;
        let none = surfaces[0].material.broadcast(0);
        L::outlined(
            token,
            #[inline(always)]
            || {
                groups(
                    #[inline(always)]
                    |g| {
                        let terms = ShadowTerms::new(
                            #[inline(always)]
                            |word| shadows.word(frame, word, none, g),
                            #[inline(always)]
                            |light| shadows.transmittance(light, none, g),
                        );
                        let first = RayIndex(first.0 + (g * L::WIDTH) as u32);
                        light(frame, views, &self.maps, &terms, first, directions[g], &surfaces[g])
                    },
                )
            },
        )
    }

    /// Adds the colors of a layer to those before it.
    #[inline(always)]
    pub fn shade<L: Wide, const G: usize>(
        &self,
        token: L::Token,
        frame: &Frame,
        directions: &[V3<L>; G],
        surfaces: &[Surfaces<L>; G],
        arriving: &[IncomingLight<L>; G],
        sums: &mut [[L; 4]; G],
    ) {
        L::outlined(
            token,
            #[inline(always)]
            || {
                for g in 0..G {
                    let shaded = shade(frame, &self.maps, directions[g], &surfaces[g], &arriving[g]);
                    sums[g] = if frame.layers == 0 { shaded } else { blend(frame, sums[g], shaded) };
                }
            },
        );
    }
}

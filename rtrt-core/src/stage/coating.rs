//! Coating: what lies on a surface, a sheen and over it a clear coat (KHR_materials_sheen,
//! KHR_materials_clearcoat).
//!
//! ```text
//! color = (base · (1 − max(sheen) · E) + sheen light) · (1 − C) + C · coat light
//! C     = coat · (0.04 + 0.96 · (1 − |n_c·v|)⁵)
//! ```
//!
//! `E` is the share of light that a white sheen scatters (see [`sheen`](crate::kernel::sheen)). The coat has the
//! index of refraction 1.5, mirrors with a lobe of its own around a normal of its own, which the surface's normal
//! map does not turn, and dims what the surface emits. Only frames whose materials have one of the two come here.

use crate::kernel::environment::mirrored;
use crate::kernel::microfacet::{Microfacets, alpha_squared, lambert, schlick};
use crate::kernel::sheen::Sheen;
use crate::kernel::tangent::unpack_direction;
use crate::kernel::texture::{Maps, MaterialField, MaterialLookup, sample};
use crate::lane::{Lane, V3, times};
use crate::layout::{Frame, MaterialRecord};
use crate::num::{clamp, flush, flush3};
use crate::stage::surface::Surfaces;

/// What a coat mirrors head-on.
const HEAD_ON: f32 = 0.04;

/// The coatings of a group of surfaces, and where they are seen from.
#[derive(Clone, Copy)]
pub(super) struct Coating<L: Lane> {
    /// `C`.
    coat: L,
    coat_normal: V3<L>,
    coat_facets: Microfacets<L>,
    coat_roughness: L,
    sheen_color: V3<L>,
    sheen: Sheen<L>,
    sheen_roughness: L,
    /// `E`.
    scattered: L,
}

impl<L: Lane> Coating<L> {
    /// The coatings of these materials, seen along the opposite of `to_viewer`, of unit length.
    #[inline(always)]
    pub(super) fn new(
        frame: &Frame,
        maps: &Maps<'_>,
        materials: L::Bits,
        surfaces: &Surfaces<L>,
        to_viewer: V3<L>,
    ) -> Self {
        let token = surfaces.footprint.token();
        let zero = surfaces.footprint.broadcast(0.0);
        let chosen = MaterialLookup::new(materials);
        let tex_coords = surfaces.tex_coords();
        let [coat, coat_roughness, r, g, b, sheen_roughness] = chosen.numbers::<Coatings, 6>(token, maps);
        let mut coating = Self {
            coat: zero,
            coat_normal: surfaces.normal,
            coat_facets: Microfacets::new(surfaces.normal, to_viewer, zero),
            coat_roughness,
            sheen_color: V3 { x: r, y: g, z: b },
            sheen: Sheen::new(surfaces.normal, to_viewer, sheen_roughness),
            sheen_roughness,
            scattered: zero,
        };
        if frame.has(MaterialRecord::HAS_COAT) {
            let [share, ..] = sample::<L, { MaterialRecord::COAT }, false>(maps, &chosen, &tex_coords);
            let [_, rough, ..] =
                sample::<L, { MaterialRecord::COAT_ROUGHNESS }, false>(maps, &chosen, &tex_coords);
            let normal = unpack_direction(surfaces.coat_normal);
            let fresnel = schlick(normal.dot(to_viewer).abs()) * (1.0 - HEAD_ON) + HEAD_ON;
            coating.coat = coat * share * fresnel;
            coating.coat_normal = normal;
            coating.coat_roughness = coat_roughness * rough;
            let width = alpha_squared(coating.coat_roughness, zero);
            coating.coat_facets = Microfacets::new(normal, to_viewer, width);
        }
        if frame.has(MaterialRecord::HAS_SHEEN) {
            let [x, y, z, _] = sample::<L, { MaterialRecord::SHEEN }, true>(maps, &chosen, &tex_coords);
            let [.., rough] =
                sample::<L, { MaterialRecord::SHEEN_ROUGHNESS }, false>(maps, &chosen, &tex_coords);
            coating.sheen_color = times(coating.sheen_color, V3 { x, y, z });
            coating.sheen_roughness = sheen_roughness * rough;
            coating.sheen = Sheen::new(surfaces.normal, to_viewer, coating.sheen_roughness);
            coating.scattered = coating.sheen.albedo(coating.sheen_roughness);
        }
        coating
    }

    /// The share of a surface's light that a coat lets through to the viewer.
    #[inline(always)]
    pub(super) fn through_coat(&self) -> L {
        self.coat.broadcast(1.0) - self.coat
    }

    /// The share of what is below the sheen that reaches the coat.
    #[inline(always)]
    pub(super) fn through_sheen(&self) -> L {
        let most = self.sheen_color.x.max(self.sheen_color.y).max(self.sheen_color.z);
        clamp(most.broadcast(1.0) - most * self.scattered, 0.0, 1.0)
    }

    /// What the coatings make of light of unit strength from this direction, of unit length, at whose cosine the
    /// surface is.
    #[inline(always)]
    pub(super) fn respond(&self, frame: &Frame, to_light: V3<L>, cosine: L) -> V3<L> {
        let mut sum = V3::splat(self.coat.token(), [0.0; 3]);
        if frame.has(MaterialRecord::HAS_SHEEN) {
            let share = self.sheen.respond(to_light, cosine) * self.through_coat();
            sum = self.sheen_color.scale(share);
        }
        if frame.has(MaterialRecord::HAS_COAT) {
            let one = cosine.broadcast(1.0);
            let response = self.coat_facets.respond(to_light, lambert(self.coat_normal, to_light), one);
            let share = flush(self.coat * (response.specular + response.grazing));
            sum = sum + V3 { x: share, y: share, z: share };
        }
        flush3(sum)
    }

    /// What the coatings make of the light from all around: of the environment, or of an ambient light without one.
    ///
    /// A sheen takes it from where a lobe of its roughness would mirror it, which is an approximation: its own lobe is
    /// wider and hollow.
    #[inline(always)]
    pub(super) fn mirrored(
        &self,
        frame: &Frame,
        maps: &Maps<'_>,
        normal: V3<L>,
        to_viewer: V3<L>,
        ambient: V3<L>,
    ) -> V3<L> {
        let sky = frame.sky();
        let around = |normal: V3<L>, roughness: L| {
            if sky.first == 0 {
                return ambient;
            }
            let along = normal.scale(normal.dot(to_viewer) * 2.0) - to_viewer;
            flush3(mirrored(maps, sky, along, roughness))
        };
        let mut sum = V3::splat(self.coat.token(), [0.0; 3]);
        if frame.has(MaterialRecord::HAS_SHEEN) {
            let light = around(normal, self.sheen_roughness).scale(self.scattered * self.through_coat());
            sum = flush3(times(light, self.sheen_color));
        }
        if frame.has(MaterialRecord::HAS_COAT) {
            sum = sum + flush3(around(self.coat_normal, self.coat_roughness).scale(self.coat));
        }
        flush3(sum)
    }
}

/// What coatings a material has.
struct Coatings;

impl MaterialField<6> for Coatings {
    #[inline(always)]
    fn pick(material: &MaterialRecord) -> [f32; 6] {
        let [r, g, b] = material.sheen;
        [material.coat, material.coat_roughness, r, g, b, material.sheen_roughness]
    }
}

//! Light: the sum of all lights that reach a surface.

use crate::grid::RayIndex;
use crate::kernel::brushed::Brushed;
use crate::kernel::cone::cone;
use crate::kernel::falloff::falloff;
use crate::kernel::microfacet::{Microfacets, alpha_squared, lambert};
use crate::kernel::tangent::unpack_direction;
use crate::kernel::texture::{Maps, MaterialField, MaterialLookup, sample};
use crate::kernel::transmittance::color;
use crate::lane::{Bits, Lane, Mask, Select, V3, times};
use crate::layout::{Frame, Lit, MaterialRecord, View};
use crate::num::{flush, flush3, normalize, sqrt};
use crate::stage::coating::Coating;
use crate::stage::occlusion::{LIGHTS_PER_WORD, to_light};
use crate::stage::surface::Surfaces;

/// The light that arrives at a group of surfaces (see [`Lit`]).
#[derive(Clone, Copy)]
pub struct IncomingLight<L> {
    /// For the diffuse color.
    pub diffuse: V3<L>,
    /// For the color mirrored head-on.
    pub specular: V3<L>,
    /// For what is mirrored at grazing angles.
    pub grazing: V3<L>,
    /// What coats and sheens send to the viewer.
    pub coating: V3<L>,
}

impl IncomingLight<f32> {
    /// A lane of width 1 from its record.
    #[inline(always)]
    pub fn new(record: &Lit) -> Self {
        Self {
            diffuse: V3::splat((), record.diffuse),
            specular: V3::splat((), record.specular),
            grazing: V3::splat((), record.grazing),
            coating: V3::splat((), record.coating),
        }
    }
}

impl<L: Lane> IncomingLight<L> {
    /// Nothing.
    #[inline(always)]
    pub fn dark(token: L::Token) -> Self {
        let none = V3::splat(token, [0.0; 3]);
        Self { diffuse: none, specular: none, grazing: none, coating: none }
    }
    /// The record of one lane.
    #[inline(always)]
    pub fn lane(&self, lane: usize) -> Lit {
        self.rows().lane(lane)
    }
    /// The lanes one by one. Take them out once, before a loop over lanes.
    #[inline(always)]
    pub fn rows(&self) -> IncomingLightRows<L> {
        IncomingLightRows {
            diffuse: self.diffuse.row(),
            specular: self.specular.row(),
            grazing: self.grazing.row(),
            coating: self.coating.row(),
        }
    }
}

/// An [`IncomingLight`] whose lanes are in memory, one after another.
#[derive(Clone, Copy)]
pub struct IncomingLightRows<L: Lane> {
    diffuse: V3<L::Row>,
    specular: V3<L::Row>,
    grazing: V3<L::Row>,
    coating: V3<L::Row>,
}

impl<L: Lane> IncomingLightRows<L> {
    /// The record of one lane.
    #[inline(always)]
    pub fn lane(&self, lane: usize) -> Lit {
        Lit {
            diffuse: self.diffuse.at(lane),
            specular: self.specular.at(lane),
            grazing: self.grazing.at(lane),
            coating: self.coating.at(lane),
        }
    }
}

/// Which lights reach a group of surfaces, as two functions.
#[derive(Clone, Copy)]
pub struct ShadowTerms<M, T> {
    mask: M,
    transmittance: T,
}

impl<M: Fn(u32) -> B, T: Fn(u32) -> B, B> ShadowTerms<M, T> {
    /// `mask` gives a word of the shadow mask by its number, in frames whose shadows are bits.
    /// `transmittance` gives that of a light by its number, as a word (see
    /// [`crate::kernel::transmittance`]), in the other frames (see [`Frame::has_transmittance`]).
    #[inline(always)]
    pub fn new(mask: M, transmittance: T) -> Self {
        Self { mask, transmittance }
    }
}

/// The light that arrives at a group of surfaces from all lights, in their order. The rays that hit the
/// surfaces are numbered from `first` on, and have these directions.
///
/// On a surface that catches shadows ([`MaterialRecord::CATCHES_SHADOWS`]) it is the illuminance that arrives, as diffuse
/// light, and that which shadows take away, as specular light.
#[inline(always)]
pub fn light<L: Lane>(
    frame: &Frame,
    views: &[View],
    maps: &Maps<'_>,
    shadows: &ShadowTerms<impl Fn(u32) -> L::Bits, impl Fn(u32) -> L::Bits>,
    first: RayIndex,
    direction: V3<L>,
    surfaces: &Surfaces<L>,
) -> IncomingLight<L> {
    let answered = answered(frame, views, maps, shadows, first, direction, surfaces);
    if frame.has(MaterialRecord::IS_SHADOW_CATCHER) {
        caught(frame, views, maps, shadows, first, surfaces, &answered)
    } else {
        answered
    }
}

/// `light`, but what arrives (diffuse) and what is missing (specular) on surfaces that catch shadows.
#[inline(always)]
fn caught<L: Lane>(
    frame: &Frame,
    views: &[View],
    maps: &Maps<'_>,
    shadows: &ShadowTerms<impl Fn(u32) -> L::Bits, impl Fn(u32) -> L::Bits>,
    first: RayIndex,
    surfaces: &Surfaces<L>,
    light: &IncomingLight<L>,
) -> IncomingLight<L> {
    let token = surfaces.footprint.token();
    let found = surfaces.material.gt(surfaces.material.broadcast(0));
    if !found.any() {
        return *light;
    }
    let [shading]: [L; 1] = MaterialLookup::new(surfaces.material).numbers::<Shading, 1>(token, maps);
    let catches = found & shading.ge(shading.broadcast(MaterialRecord::CATCHES_SHADOWS as f32));
    if !catches.any() {
        return *light;
    }
    let (mut reached, mut missing) = (V3::splat(token, [0.0; 3]), V3::splat(token, [0.0; 3]));
    let mut number = 0;
    while number < frame.lights {
        let view = &views[frame.light_view(number) as usize];
        let beam = Beam::new(frame, view, first, surfaces.origin, surfaces.normal);
        let sent = flush3(V3::splat(token, view.color).scale(flush(beam.strength * beam.cosine)));
        let passed = if frame.has_transmittance() {
            flush3(times(sent, color((shadows.transmittance)(number))))
        } else {
            let lit = (shadows.mask)(number / LIGHTS_PER_WORD) >> (number % LIGHTS_PER_WORD);
            let is_lit = (lit & lit.broadcast(1)).gt(lit.broadcast(0));
            V3::select(is_lit, sent, V3::splat(token, [0.0; 3]))
        };
        reached = reached + passed;
        missing = missing + (sent - passed);
        number += 1;
    }
    IncomingLight {
        diffuse: V3::select(catches, reached, light.diffuse),
        specular: V3::select(catches, missing, light.specular),
        ..*light
    }
}

/// How a light reaches surfaces.
#[derive(Clone, Copy)]
struct Beam<L> {
    /// The direction to the light, of unit length.
    toward: V3<L>,
    /// Of the normal and `toward`, at least 0.
    cosine: L,
    /// The share that distance and cone leave.
    strength: L,
}

impl<L: Lane> Beam<L> {
    #[inline(always)]
    fn new(frame: &Frame, light: &View, first: RayIndex, origin: V3<L>, normal: V3<L>) -> Self {
        let (to_light, _) = to_light(frame, light, first, origin);
        let toward = normalize(to_light);
        let cosine = lambert(normal, toward);
        let strength = falloff(light, sqrt(to_light.dot(to_light)));
        let strength = if light.cone_scale == 0.0 { strength } else { strength * cone(light, toward) };
        Self { toward, cosine, strength }
    }
}

/// [`MaterialRecord::unlit`].
struct Shading;

impl MaterialField<1> for Shading {
    #[inline(always)]
    fn pick(material: &MaterialRecord) -> [f32; 1] {
        [material.unlit as f32]
    }
}

/// What surfaces answer.
#[inline(always)]
fn answered<L: Lane>(
    frame: &Frame,
    views: &[View],
    maps: &Maps<'_>,
    shadows: &ShadowTerms<impl Fn(u32) -> L::Bits, impl Fn(u32) -> L::Bits>,
    first: RayIndex,
    direction: V3<L>,
    surfaces: &Surfaces<L>,
) -> IncomingLight<L> {
    let ShadowTerms { mask, transmittance } = shadows;
    let mut sum = IncomingLight::dark(surfaces.footprint.token());
    let none = surfaces.material.broadcast(0);
    let mut lit = none;
    let (mut next, parts) = (0, if frame.has_transmittance() { frame.lights } else { frame.mask_words });
    while next < parts {
        lit = lit | if frame.has_transmittance() { transmittance(next) } else { mask(next) };
        next += 1;
    }
    let lit = lit.gt(none);
    if !lit.any() {
        return sum;
    }
    let materials = lit.select(surfaces.material, none);
    let finish = Finish::new(frame, maps, materials, surfaces);
    let alpha_squared = alpha_squared(finish.roughness, surfaces.variance);
    let to_viewer = normalize(-direction);
    let facets = Microfacets::new(surfaces.normal, to_viewer, alpha_squared);
    let (origin, normal) = (surfaces.origin, surfaces.normal);
    let mut receiver = Receiver { first, origin, normal, facets, finish, brushed: None, coating: None };
    if frame.has(MaterialRecord::IS_BRUSHED) {
        let tangent = unpack_direction(surfaces.tangent);
        let brushed = Brushed::new(surfaces.normal, tangent, to_viewer, alpha_squared, finish.brushed);
        receiver.brushed = Some(brushed);
    }
    if frame.has(MaterialRecord::HAS_COAT | MaterialRecord::HAS_SHEEN) {
        receiver.coating = Some(Coating::new(frame, maps, materials, surfaces, to_viewer));
    }
    let mut light = 0;
    while light < frame.lights {
        let transmittance = if frame.has_transmittance() {
            transmittance(light)
        } else {
            let lit = mask(light / LIGHTS_PER_WORD) >> (light % LIGHTS_PER_WORD);
            // The next light of the word that reaches any lane.
            let ahead = L::union(lit);
            if ahead == 0 {
                light = (light / LIGHTS_PER_WORD + 1) * LIGHTS_PER_WORD;
                continue;
            }
            let ahead = ahead.trailing_zeros();
            light += ahead;
            if light >= frame.lights {
                break;
            }
            (lit >> ahead) & lit.broadcast(1)
        };
        sum = receiver.add(frame, &views[frame.light_view(light) as usize], transmittance, &sum);
        light += 1;
    }
    sum
}

/// What the highlights of surfaces depend on, by their materials; any numbers where there is no material.
#[derive(Clone, Copy)]
struct Finish<L> {
    roughness: L,
    /// The share that surfaces mirror at grazing angles if they are no metals.
    strength: L,
    /// How much rougher they are along their tangents.
    brushed: L,
}

impl<L: Lane> Finish<L> {
    #[inline(always)]
    fn new(frame: &Frame, maps: &Maps<'_>, materials: L::Bits, surfaces: &Surfaces<L>) -> Self {
        let (token, tex_coords) = (surfaces.footprint.token(), surfaces.tex_coords());
        let zero = surfaces.footprint.broadcast(0.0);
        let chosen = MaterialLookup::new(materials);
        let [roughness, strength]: [L; 2] = chosen.numbers::<Highlight, 2>(token, maps);
        let [_, rough, ..] = sample::<L, { MaterialRecord::ROUGHNESS }, false>(maps, &chosen, &tex_coords);
        let mut finish = Self { roughness: roughness * rough, strength, brushed: zero };
        if frame.has(MaterialRecord::SPECULAR_MAPS) {
            let [.., share] = sample::<L, { MaterialRecord::SPECULAR }, false>(maps, &chosen, &tex_coords);
            finish.strength = strength * share;
        }
        if frame.has(MaterialRecord::IS_BRUSHED) {
            finish.brushed = brushed(maps, &chosen, surfaces);
        }
        finish
    }
}

/// How much rougher surfaces are along their tangents, 0 ..= 1; 0 for those without tangents.
#[inline(always)]
pub(super) fn brushed<L: Lane>(maps: &Maps<'_>, chosen: &MaterialLookup<L>, surfaces: &Surfaces<L>) -> L {
    let tex_coords = surfaces.tex_coords();
    let [strength]: [L; 1] = chosen.numbers::<Strength, 1>(surfaces.footprint.token(), maps);
    let [_, _, share, _] = sample::<L, { MaterialRecord::BRUSHED }, false>(maps, chosen, &tex_coords);
    let has_tangent = surfaces.tangent.gt(surfaces.tangent.broadcast(0));
    has_tangent.select(strength * share, strength.broadcast(0.0))
}

/// What a highlight depends on.
struct Highlight;

impl MaterialField<2> for Highlight {
    #[inline(always)]
    fn pick(material: &MaterialRecord) -> [f32; 2] {
        [material.roughness, material.strength]
    }
}

/// How brushed a surface is.
struct Strength;

impl MaterialField<1> for Strength {
    #[inline(always)]
    fn pick(material: &MaterialRecord) -> [f32; 1] {
        [material.brushed]
    }
}

/// What lights arrive at: surfaces, and the rays that hit them.
struct Receiver<L: Lane> {
    first: RayIndex,
    origin: V3<L>,
    normal: V3<L>,
    facets: Microfacets<L>,
    finish: Finish<L>,
    /// In frames that have such.
    brushed: Option<Brushed<L>>,
    coating: Option<Coating<L>>,
}

impl<L: Lane> Receiver<L> {
    /// `sum` plus what a light adds to it in the lanes whose `transmittance` is not 0: a color, or, in
    /// frames whose shadows are bits, 1.
    #[inline(always)]
    fn add(
        &self,
        frame: &Frame,
        light: &View,
        transmittance: L::Bits,
        sum: &IncomingLight<L>,
    ) -> IncomingLight<L> {
        let Self { first, origin, normal, facets, finish, brushed, coating } = *self;
        let token = normal.x.token();
        let reached = transmittance.gt(transmittance.broadcast(0));
        if !reached.any() {
            return *sum;
        }
        let Beam { toward, cosine, strength } = Beam::new(frame, light, first, origin, normal);
        let strength = reached.select(strength, strength.broadcast(0.0));
        // Off its peak a lobe is so small that some devices keep its products and others do not.
        let arriving = V3::splat(token, light.color).scale(flush(strength));
        let arriving =
            if frame.has_transmittance() { times(arriving, color(transmittance)) } else { arriving };
        let arriving = flush3(arriving);
        let mut response = facets.respond(toward, cosine, finish.strength);
        if let Some(brushed) = brushed {
            let is_brushed = finish.brushed.gt(cosine.broadcast(0.0));
            let other = brushed.respond(toward, cosine, finish.strength);
            response.specular = is_brushed.select(other.specular, response.specular);
            response.grazing = is_brushed.select(other.grazing, response.grazing);
        }
        let mut sum = IncomingLight {
            diffuse: sum.diffuse + flush3(arriving.scale(response.diffuse)),
            specular: sum.specular + flush3(arriving.scale(response.specular)),
            grazing: sum.grazing + flush3(arriving.scale(response.grazing)),
            coating: sum.coating,
        };
        if let Some(coating) = coating {
            sum.coating = sum.coating + flush3(times(arriving, coating.respond(frame, toward, cosine)));
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lane::Word;
    use crate::layout::ViewKind;
    use bytemuck::Zeroable;

    /// What a light sends to a surface at the origin that faces +z, seen from there.
    fn sent(light: View, shadow: u32, layers: u32) -> Lit {
        let frame = Frame { lights: 1, mask_words: 1, layers, ..Frame::zeroed() };
        let mut views = [View::zeroed(); 7];
        views[1] = View { color: [0.5, 1.0, 2.0], ..light };
        let materials = [MaterialRecord { roughness: 1.0, ..MaterialRecord::zeroed() }];
        let maps = Maps { materials: &materials, texels: &[] };
        let shadows = ShadowTerms::new(|_| Word(shadow), |_| Word(shadow));
        light_of(&frame, &views, &maps, &shadows)
    }

    /// The light on a surface at the origin that faces +z, seen from there.
    fn light_of(
        frame: &Frame,
        views: &[View],
        maps: &Maps<'_>,
        shadows: &ShadowTerms<impl Fn(u32) -> Word, impl Fn(u32) -> Word>,
    ) -> Lit {
        let at = |v| V3::<f32>::splat((), v);
        let surfaces = Surfaces {
            origin: at([0.0; 3]),
            normal: at([0.0, 0.0, 1.0]),
            material: Word(1),
            color: [Word(u32::MAX); 2],
            uv: [0.0; 2],
            footprint: 0.0,
            second_uv: [0.0; 2],
            second_footprint: 0.0,
            variance: 0.0,
            coat_normal: Word(0),
            tangent: Word(0),
        };
        light(frame, views, maps, shadows, RayIndex(0), at([0.0, 0.0, -1.0]), &surfaces).lane(0)
    }

    fn lamp(center: [f32; 3]) -> View {
        View { kind: ViewKind::Point as u32, center, inv_reach: 0.125, ..View::zeroed() }
    }

    fn near(found: [f32; 3], share: f32) -> bool {
        // A white surface sends 1/π of what arrives everywhere.
        let share = share * core::f32::consts::FRAC_1_PI;
        found.iter().zip([0.5, 1.0, 2.0]).all(|(found, color)| (found - color * share).abs() < 1e-5)
    }

    #[test]
    fn light_falls_off_with_distance_and_by_the_cosine() {
        // Half of its reach away, straight above: a half, which a matte lobe sends back by 1/4π.
        let above = sent(lamp([0.0, 0.0, 4.0]), 1, 0);
        assert!(near(above.diffuse, 0.5) && near(above.specular, 0.125), "{above:?}");
        // 5 away, at a cosine of 4/5.
        let aside = sent(lamp([3.0, 0.0, 4.0]), 1, 0);
        assert!(near(aside.diffuse, (1.0 - 5.0 / 8.0) * 0.8), "{aside:?}");
        assert!(near(sent(lamp([3.0, 0.0, -4.0]), 1, 0).diffuse, 0.0));
        let sun = View { kind: ViewKind::Sun as u32, along: [0.0, -3.0, -4.0], ..View::zeroed() };
        assert!(near(sent(sun, 1, 0).diffuse, 0.8));
    }

    #[test]
    fn the_lights_of_a_mask_count_in_their_order_and_no_others() {
        let frame = Frame { lights: 70, mask_words: 3, ..Frame::zeroed() };
        let mut views = [View::zeroed(); 421];
        for light in 0..70_u8 {
            let color = [f32::from(light) + 0.1, 1.0 / (f32::from(light) + 3.0), 0.3];
            views[frame.light_view(light.into()) as usize] = View { color, ..lamp([0.0, 0.0, 4.0]) };
        }
        let materials = [MaterialRecord { roughness: 1.0, ..MaterialRecord::zeroed() }];
        let maps = Maps { materials: &materials, texels: &[] };
        let lit = |mask: [u32; 3]| {
            let words = |word: u32| Word(mask[word as usize]);
            light_of(&frame, &views, &maps, &ShadowTerms::new(words, words)).diffuse
        };
        let alone =
            |light: u32| lit([0, 1, 2].map(|word| if word == light / 32 { 1 << (light % 32) } else { 0 }));
        let masks = [
            [0, 0, 0],
            [1 << 31, 0, 0b10_0001],
            [0, 1 << 31 | 1, 0],
            [1 << 5, 1, 1 << 2],
            [0x8421_0003, 0xffff_ffff, 0b11_1111],
            // Bits behind the last light.
            [0, 0b100, 0xffff_ff80],
            [0, 0, 0xffff_ffff],
        ];
        for mask in masks {
            let lights = (0..70).filter(|light| mask[*light as usize / 32] >> (light % 32) & 1 == 1);
            let sum =
                lights.map(alone).fold([0.0; 3], |sum, light| [0, 1, 2].map(|i: usize| sum[i] + light[i]));
            assert_eq!(lit(mask), sum, "{mask:x?}");
        }
    }

    #[test]
    fn what_catches_shadows_learns_what_is_missing() {
        let extensions = MaterialRecord::IS_SHADOW_CATCHER;
        let frame = Frame { lights: 2, mask_words: 1, layers: 3, extensions, ..Frame::zeroed() };
        let mut views = [View::zeroed(); 13];
        views[1] = View { color: [0.5, 1.0, 2.0], ..lamp([0.0, 0.0, 4.0]) };
        views[7] = View { color: [4.0; 3], ..lamp([0.0, 0.0, 6.0]) };
        let unlit = MaterialRecord::CATCHES_SHADOWS;
        let materials = [MaterialRecord { unlit, ..MaterialRecord::zeroed() }];
        let maps = Maps { materials: &materials, texels: &[] };
        // All of the first light, and of the second a quarter of its red.
        let words = |light: u32| Word(if light == 0 { (1 << 30) - 1 } else { 512 });
        let light = light_of(&frame, &views, &maps, &ShadowTerms::new(words, words));
        let is = |found: [f32; 3], expected: [f32; 3]| (0..3).all(|i| (found[i] - expected[i]).abs() < 2e-3);
        // Half of the first one arrives at half of its reach, a quarter of the second one at three quarters.
        assert!(is(light.diffuse, [0.25 + 0.25, 0.5, 1.0]), "{light:?}");
        assert!(is(light.specular, [0.75, 1.0, 1.0]), "{light:?}");
    }

    #[test]
    fn shadows_take_light_away() {
        assert_eq!(sent(lamp([0.0, 0.0, 4.0]), 0, 0), Lit::zeroed());
        // A word of 10 bits a channel, each the square root of its share: red 1, green 1/4, blue 0.
        let [r, g, b] = sent(lamp([0.0, 0.0, 4.0]), 1023 | 512 << 10, 1).diffuse;
        let [r, g] = [r, g].map(|c| c * core::f32::consts::PI);
        assert!((r - 0.25).abs() < 1e-6 && (g - 0.125).abs() < 1e-3 && b == 0.0, "{r} {g} {b}");
    }
}

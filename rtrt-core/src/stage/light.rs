//! Light: what arrives at a surface from all lights that reach it.

use crate::grid::RayIndex;
use crate::kernel::cone::cone;
use crate::kernel::falloff::falloff;
use crate::kernel::reflect::{blinn_phong, lambert, shininess};
use crate::kernel::texture::{Maps, MaterialField, MaterialLookup, TexCoords, sample};
use crate::kernel::transmittance::color;
use crate::lane::{Bits, Lane, Mask, Select, V3, times};
use crate::layout::{Frame, Lit, MaterialRecord, View};
use crate::num::{flush3, normalize, sqrt};
use crate::stage::occlusion::{LIGHTS_PER_WORD, to_light};
use crate::stage::surface::Surfaces;

/// The light that arrives at a group of surfaces; see [`Lit`].
#[derive(Clone, Copy)]
pub struct IncomingLight<L> {
    /// For the diffuse color.
    pub diffuse: V3<L>,
    /// For the highlight.
    pub specular: V3<L>,
}

impl IncomingLight<f32> {
    /// A lane of width 1 from its record.
    #[inline(always)]
    pub fn new(record: &Lit) -> Self {
        Self { diffuse: V3::splat((), record.diffuse), specular: V3::splat((), record.specular) }
    }
}

impl<L: Lane> IncomingLight<L> {
    /// Nothing.
    #[inline(always)]
    pub fn dark(token: L::Token) -> Self {
        Self { diffuse: V3::splat(token, [0.0; 3]), specular: V3::splat(token, [0.0; 3]) }
    }
    /// The record of one lane.
    #[inline(always)]
    pub fn lane(&self, lane: usize) -> Lit {
        self.rows().lane(lane)
    }
    /// The lanes one by one. Take them out once, before a loop over lanes.
    #[inline(always)]
    pub fn rows(&self) -> ArrivingRows<L> {
        ArrivingRows { diffuse: self.diffuse.row(), specular: self.specular.row() }
    }
}

/// An [`IncomingLight`] whose lanes are in memory, one after another.
#[derive(Clone, Copy)]
pub struct ArrivingRows<L: Lane> {
    diffuse: V3<L::Row>,
    specular: V3<L::Row>,
}

impl<L: Lane> ArrivingRows<L> {
    /// The record of one lane.
    #[inline(always)]
    pub fn lane(&self, lane: usize) -> Lit {
        Lit { diffuse: self.diffuse.at(lane), specular: self.specular.at(lane) }
    }
}

/// The light that arrives at a group of surfaces from all lights, in their order.
/// `mask(word)` is a word of the shadow mask; in frames whose shadows are not bits,
/// `transmittance(light)`, the color of a light's shadow, is asked instead. The rays that found the surfaces
/// are numbered from `first` on, and have these directions.
#[inline(always)]
#[allow(clippy::too_many_arguments, reason = "each is a number of its own")]
pub fn light<L: Lane>(
    frame: &Frame,
    views: &[View],
    maps: &Maps<'_>,
    mask: impl Fn(u32) -> L::Bits,
    transmittance: impl Fn(u32) -> L::Bits,
    first: RayIndex,
    direction: V3<L>,
    surfaces: &Surfaces<L>,
) -> IncomingLight<L> {
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
    let shininess = exponent(maps, lit.select(surfaces.material, none), &surfaces.tex_coords());
    let mut light = 0;
    while light < frame.lights {
        let left = if frame.has_transmittance() {
            transmittance(light)
        } else {
            let lit = mask(light / LIGHTS_PER_WORD) >> (light % LIGHTS_PER_WORD);
            lit & lit.broadcast(1)
        };
        sum = add(frame, views, light, left, first, direction, surfaces, shininess, &sum);
        light += 1;
    }
    sum
}

/// The exponents of the highlights of surfaces of these materials, at least one; any number
/// where there is none.
#[inline(always)]
fn exponent<L: Lane>(maps: &Maps<'_>, materials: L::Bits, tex_coords: &TexCoords<L>) -> L {
    let token = tex_coords.footprint[0].token();
    let chosen = MaterialLookup::new(materials);
    let [exponent, roughness, levels]: [L; 3] = chosen.numbers::<Gloss, 3>(token, maps);
    let textured = levels.gt(levels.broadcast(0.0));
    if !textured.any() {
        return exponent;
    }
    let texture = sample::<L, { MaterialRecord::ROUGHNESS }, false>(maps, &chosen, tex_coords);
    textured.select(shininess(roughness * texture[1]), exponent)
}

/// What the highlight of a material depends on.
struct Gloss;

impl MaterialField<3> for Gloss {
    #[inline(always)]
    fn pick(material: &MaterialRecord) -> [f32; 3] {
        let levels = material.textures[MaterialRecord::ROUGHNESS].levels as f32;
        [material.shininess, material.roughness, levels]
    }
}

/// `sum` and what the light adds to it, in the lanes where anything of it is `left`: its bit of
/// the shadow mask, or the color of its shadow in frames whose shadows are not bits.
#[inline(always)]
#[allow(clippy::too_many_arguments, reason = "each is a number of its own")]
fn add<L: Lane>(
    frame: &Frame,
    views: &[View],
    light: u32,
    left: L::Bits,
    first: RayIndex,
    direction: V3<L>,
    surfaces: &Surfaces<L>,
    shininess: L,
    sum: &IncomingLight<L>,
) -> IncomingLight<L> {
    let token = surfaces.footprint.token();
    let reached = left.gt(left.broadcast(0));
    if !reached.any() {
        return *sum;
    }
    let view = &views[frame.light_view(light) as usize];
    let (way, _) = to_light(frame, view, first, surfaces.origin);
    let toward = normalize(way);
    let strength = lambert(surfaces.normal, toward) * falloff(view, sqrt(way.dot(way)));
    let strength = if view.cone_scale == 0.0 { strength } else { strength * cone(view, toward) };
    let strength = reached.select(strength, strength.broadcast(0.0));
    let lobe = blinn_phong(surfaces.normal, toward, normalize(-direction), shininess);
    // Off its peak a lobe is so small that some devices keep its products and others do not.
    let light = V3::splat(token, view.color).scale(strength);
    let light = if frame.has_transmittance() { times(light, color(left)) } else { light };
    let diffuse = flush3(light);
    IncomingLight { diffuse: sum.diffuse + diffuse, specular: sum.specular + flush3(diffuse.scale(lobe)) }
}

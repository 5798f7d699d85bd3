//! Light: what arrives at a surface from all lights that reach it.

use crate::kernel::cone::cone;
use crate::kernel::falloff::falloff;
use crate::kernel::ray::Ray;
use crate::kernel::reflect::{blinn_phong, lambert};
use crate::lane::{Bits, Lane, Mask, Row, Select, V3};
use crate::layout::{Frame, Lit, Material, View};
use crate::num::{flush3, normalize, sqrt};
use crate::stage::occlusion::{LIGHTS_PER_WORD, to_light};
use crate::stage::surface::Surfaces;

/// The light that arrives at a group of surfaces; see [`Lit`].
#[derive(Clone, Copy)]
pub struct Arriving<L> {
    /// For the diffuse color.
    pub diffuse: V3<L>,
    /// For the highlight.
    pub specular: V3<L>,
}

impl Arriving<f32> {
    /// A lane of width 1 from its record.
    #[inline(always)]
    pub fn new(record: &Lit) -> Self {
        Self { diffuse: V3::splat((), record.diffuse), specular: V3::splat((), record.specular) }
    }
}

impl<L: Lane> Arriving<L> {
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

/// An [`Arriving`] whose lanes are in memory, one after another.
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
/// `mask(word)` is a word of the shadow mask.
#[inline(always)]
pub fn light<L: Lane>(
    frame: &Frame,
    views: &[View],
    materials: &[Material],
    mask: impl Fn(u32) -> L::Bits,
    ray: &Ray<L>,
    surfaces: &Surfaces<L>,
) -> Arriving<L> {
    let mut sum = Arriving::dark(surfaces.footprint.token());
    let mut light = 0;
    while light < frame.lights {
        let lit = mask(light / LIGHTS_PER_WORD);
        sum = add(frame, views, materials, light, lit, ray, surfaces, &sum);
        light += 1;
    }
    sum
}

/// `sum` and what the light adds to it, in the lanes where `lit` has the light's bit.
/// `lit` is the word of the shadow mask that the light belongs to.
#[inline(always)]
fn add<L: Lane>(
    frame: &Frame,
    views: &[View],
    materials: &[Material],
    light: u32,
    lit: L::Bits,
    ray: &Ray<L>,
    surfaces: &Surfaces<L>,
    sum: &Arriving<L>,
) -> Arriving<L> {
    let token = surfaces.footprint.token();
    let bit = (lit >> (light % LIGHTS_PER_WORD)) & lit.like(1);
    let reached = bit.equal(lit.like(1));
    if !reached.any() {
        return *sum;
    }
    let view = &views[frame.light_view(light) as usize];
    let (way, _) = to_light(view, surfaces.origin);
    let toward = normalize(way);
    let indices = surfaces.material.row();
    let shininess = L::from_fn(
        token,
        #[inline(always)]
        |lane| {
            let material = indices.at(lane);
            if material == 0 { 1.0 } else { materials[material as usize - 1].shininess }
        },
    );
    let strength = lambert(surfaces.normal, toward) * falloff(view, sqrt(way.dot(way)));
    let strength = if view.cone_scale == 0.0 { strength } else { strength * cone(view, toward) };
    let strength = reached.select(strength, strength.like(0.0));
    let lobe = blinn_phong(surfaces.normal, toward, normalize(-ray.direction), shininess);
    // Off its peak a lobe is so small that some devices keep its products and others do not.
    let diffuse = flush3(V3::splat(token, view.color).scale(strength));
    Arriving { diffuse: sum.diffuse + diffuse, specular: sum.specular + flush3(diffuse.scale(lobe)) }
}

//! Shade: the color that a ray brings back.

use crate::kernel::texture::{Chosen, Maps, Pick, Places, sample};
use crate::lane::{Bits, Lane, Mask, Select};
use crate::layout::{Frame, Material};
use crate::num::flush;
use crate::stage::light::Arriving;
use crate::stage::surface::{Surfaces, channel};

/// Linear RGB and alpha of what a group of rays has found:
///
/// ```text
/// base · (ambient + diffuse light) + specular · specular light + emission
/// base = material · texture · vertex color
/// ```
///
/// or the background where it found nothing. Alpha is 1: every surface is opaque.
#[inline(always)]
pub fn shade<L: Lane>(
    frame: &Frame,
    maps: &Maps<'_>,
    surfaces: &Surfaces<L>,
    arriving: &Arriving<L>,
) -> [L; 4] {
    let token = surfaces.footprint.token();
    let one = surfaces.footprint.like(1.0);
    let background =
        [one.like(frame.background_r), one.like(frame.background_g), one.like(frame.background_b)];
    let found = surfaces.material.like(0).less_than(surfaces.material);
    if !found.any() {
        return [background[0], background[1], background[2], one];
    }
    let chosen = Chosen::new(surfaces.material);
    let places =
        Places { uv: [surfaces.uv, surfaces.uv], footprint: [surfaces.footprint, surfaces.footprint] };
    let [dr, dg, db, sr, sg, sb, er, eg, eb] = chosen.numbers::<Colors, 9>(token, maps);
    let texture = sample::<L, { Material::COLOR }, true>(maps, &chosen, &places);
    let (diffuse, specular) = (&arriving.diffuse, &arriving.specular);
    let color = |base: L, ambient: f32, diffuse: L, specular: L, specular_light: L, emission: L| {
        let answer = flush(base * (diffuse.like(ambient) + diffuse));
        flush(answer + flush(specular * specular_light) + emission)
    };
    let base = |number: u32, diffuse: L, texture: L| diffuse * texture * channel::<L>(surfaces.color, number);
    let r = color(base(0, dr, texture[0]), frame.ambient_r, diffuse.x, sr, specular.x, er);
    let g = color(base(1, dg, texture[1]), frame.ambient_g, diffuse.y, sg, specular.y, eg);
    let b = color(base(2, db, texture[2]), frame.ambient_b, diffuse.z, sb, specular.z, eb);
    [found.select(r, background[0]), found.select(g, background[1]), found.select(b, background[2]), one]
}

/// The colors of a material: diffuse, specular, emission.
struct Colors;

impl Pick<9> for Colors {
    #[inline(always)]
    fn pick(material: &Material) -> [f32; 9] {
        let (d, s, e) = (&material.diffuse, &material.specular, &material.emission);
        [d[0], d[1], d[2], s[0], s[1], s[2], e[0], e[1], e[2]]
    }
}

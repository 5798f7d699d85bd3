//! Shade: the color that a ray brings back.

use crate::kernel::environment::{arriving as arriving_from, mirrored};
use crate::kernel::texture::{Maps, MaterialField, MaterialLookup, channel, sample};
use crate::lane::{Bits, Lane, Mask, Select, V3, times};
use crate::layout::{AlphaKind, Frame, MaterialRecord, Sky};
use crate::num::{FLOOR, clamp, flush, flush3, normalize, recip};
use crate::stage::light::IncomingLight;
use crate::stage::surface::Surfaces;

/// Linear RGB and alpha of the surfaces of a group of rays:
///
/// ```text
/// diffuse · (ambient · occlusion + diffuse light) + highlight · specular light + emission
///
/// base      = material · texture · vertex color
/// diffuse   = base · (1 − metallic / 2)
/// mirror    = specular + (base − specular) · metallic
/// highlight = mirror · (1 − roughness / 2)
/// ```
///
/// or the base color alone, of a material that is unlit, or the environment where it found nothing. `metallic`,
/// `roughness`, `occlusion` and `emission` are the material's times its textures. Alpha is 1, but of a material that blends: the material's, times the texture's and
/// the vertex color's; and 0 where it found nothing, unless the frame shows the environment there. A surface that
/// catches shadows is black, and its alpha is how dark they are.
///
/// An environment is the background, unless the frame says otherwise. It takes the place of the ambient light, by the
/// surface's normal. It is mirrored, more where the surface is seen at a grazing angle, by
/// Schlick's approximation (1994), which a rough surface follows less (Lagarde 2011):
///
/// ```text
/// + environment · (mirror + (max(1 − roughness, mirror) − mirror) · (1 − n · v)⁵)
/// ```
///
/// and a metal then has no diffuse color: `base · (1 − metallic)`. Nothing occludes what is
/// mirrored, as in the paper.
#[inline(always)]
pub fn shade<L: Lane>(
    frame: &Frame,
    maps: &Maps<'_>,
    direction: V3<L>,
    surfaces: &Surfaces<L>,
    arriving: &IncomingLight<L>,
) -> [L; 4] {
    let token = surfaces.footprint.token();
    let one = surfaces.footprint.broadcast(1.0);
    let sky = frame.sky();
    let found = surfaces.material.gt(surfaces.material.broadcast(0));
    let shows_sky = frame.shows_sky();
    let clear = one.broadcast(if shows_sky { 1.0 } else { 0.0 });
    let background = if shows_sky && (!found).any() {
        flush3(mirrored(maps, sky, direction, one.broadcast(frame.backdrop_blur)))
    } else {
        V3::splat(token, [0.0; 3])
    };
    if !found.any() {
        return [background.x, background.y, background.z, clear];
    }
    let surface_material = surface_material(maps, surfaces, if sky.first == 0 { 0.5 } else { 1.0 });
    let ambient = if sky.first == 0 {
        V3::splat(token, [frame.ambient_r, frame.ambient_g, frame.ambient_b])
    } else {
        flush3(arriving_from(maps, sky, surfaces.normal))
    };
    let diffuse =
        flush3(times(surface_material.diffuse, ambient.scale(surface_material.occlusion) + arriving.diffuse));
    let specular = flush3(times(surface_material.highlight, arriving.specular));
    let lit = flush3(diffuse + specular + surface_material.emission);
    let lit = if sky.first == 0 {
        lit
    } else {
        flush3(lit + reflection(maps, sky, direction, surfaces, &surface_material))
    };
    let color =
        V3::select(found, V3::select(surface_material.unlit, flush3(surface_material.base), lit), background);
    let alpha = if surface_material.catches.any() {
        let alpha = flush(shadow(ambient, arriving));
        surface_material.catches.select(alpha, surface_material.alpha)
    } else {
        surface_material.alpha
    };
    [color.x, color.y, color.z, found.select(alpha, clear)]
}

/// The alpha of a surface that catches shadows:
///
/// ```text
/// missing / (ambient + reached + missing)
/// ```
///
/// of the luminances of what arrives, so that black with this alpha darkens what is behind it as much as the shadow
/// would.
#[inline(always)]
fn shadow<L: Lane>(ambient: V3<L>, arriving: &IncomingLight<L>) -> L {
    let missing = luminance(arriving.specular);
    let all = luminance(ambient) + luminance(arriving.diffuse) + missing;
    let none = all.broadcast(0.0);
    all.gt(all.broadcast(FLOOR)).select(clamp(missing * recip(all), 0.0, 1.0), none)
}

/// Luminance (ITU-R BT.709).
#[inline(always)]
fn luminance<L: Lane>(light: V3<L>) -> L {
    light.x * 0.2126 + light.y * 0.7152 + light.z * 0.0722
}

/// The base color of a group of surfaces, linear RGB: material · texture · vertex color.
#[inline(always)]
pub fn base<L: Lane>(maps: &Maps<'_>, surfaces: &Surfaces<L>) -> V3<L> {
    flush3(surface_material(maps, surfaces, 0.0).base)
}

/// What the surfaces mirror of the environment.
#[inline(always)]
fn reflection<L: Lane>(
    maps: &Maps<'_>,
    sky: Sky,
    direction: V3<L>,
    surfaces: &Surfaces<L>,
    surface_material: &SurfaceMaterial<L>,
) -> V3<L> {
    let toward = normalize(-direction);
    let normal = surfaces.normal;
    let cosine = normal.dot(toward);
    let (zero, one) = (cosine.broadcast(0.0), cosine.broadcast(1.0));
    let light = mirrored(maps, sky, normal.scale(cosine * 2.0) - toward, surface_material.roughness);
    let grazing = one - clamp(cosine, 0.0, 1.0);
    let square = grazing * grazing;
    let grazing = flush(square * square * grazing);
    let smooth = (one - surface_material.roughness).max(zero);
    let share = |mirror: L| mirror + (smooth.max(mirror) - mirror) * grazing;
    let mirror = surface_material.mirror;
    flush3(times(light, V3 { x: share(mirror.x), y: share(mirror.y), z: share(mirror.z) }))
}

/// What a group of surfaces surface_material like, its textures included.
struct SurfaceMaterial<L: Lane> {
    base: V3<L>,
    diffuse: V3<L>,
    mirror: V3<L>,
    roughness: L,
    highlight: V3<L>,
    emission: V3<L>,
    /// The share of the ambient light that arrives.
    occlusion: L,
    unlit: L::Mask,
    /// Whether they show shadows and nothing else.
    catches: L::Mask,
    alpha: L,
}

/// The surface_material; a metal loses this share of its diffuse color.
#[inline(always)]
fn surface_material<L: Lane>(maps: &Maps<'_>, surfaces: &Surfaces<L>, metal: f32) -> SurfaceMaterial<L> {
    let token = surfaces.footprint.token();
    let one = surfaces.footprint.broadcast(1.0);
    let chosen = MaterialLookup::new(surfaces.material);
    let tex_coords = surfaces.tex_coords();
    let [br, bg, bb, sr, sg, sb, er, eg, eb, metallic, roughness, strength, unlit, alpha] =
        chosen.numbers::<Numbers, 14>(token, maps);
    let texture = sample::<L, { MaterialRecord::COLOR }, true>(maps, &chosen, &tex_coords);
    let painted = |number: u32| channel::<L>(surfaces.color, number);
    let base = V3 {
        x: br * texture[0] * painted(0),
        y: bg * texture[1] * painted(1),
        z: bb * texture[2] * painted(2),
    };
    let [_, green, blue, _] = sample::<L, { MaterialRecord::ROUGHNESS }, false>(maps, &chosen, &tex_coords);
    let (metallic, roughness) = (metallic * blue, roughness * green);
    let [occluded, _, _, _] = sample::<L, { MaterialRecord::OCCLUSION }, false>(maps, &chosen, &tex_coords);
    let glow = sample::<L, { MaterialRecord::EMISSION }, true>(maps, &chosen, &tex_coords);
    let specular = V3 { x: sr, y: sg, z: sb };
    let mirror = specular + (base - specular).scale(metallic);
    SurfaceMaterial {
        base,
        diffuse: base.scale(one - metallic * metal),
        mirror,
        roughness,
        highlight: mirror.scale(one - roughness * 0.5),
        emission: V3 { x: flush(er * glow[0]), y: flush(eg * glow[1]), z: flush(eb * glow[2]) },
        occlusion: one + (occluded - one) * strength,
        unlit: unlit.ge(one),
        catches: unlit.ge(one.broadcast(MaterialRecord::CATCHES_SHADOWS as f32)),
        alpha: alpha
            .lt(one.broadcast(0.0))
            .select(one, flush(clamp(alpha * texture[3] * painted(3), 0.0, 1.0))),
    }
}

/// What a material says of its surface_material.
struct Numbers;

impl MaterialField<14> for Numbers {
    #[inline(always)]
    fn pick(material: &MaterialRecord) -> [f32; 14] {
        let (b, s, e) = (&material.base, &material.specular, &material.emission);
        let (metallic, roughness) = (material.metallic, material.roughness);
        let (occlusion, unlit) = (material.occlusion, material.unlit as f32);
        // Negative for opaque surfaces.
        let alpha = if material.alpha_mode == AlphaKind::Blend as u32 { material.alpha } else { -1.0 };
        [b[0], b[1], b[2], s[0], s[1], s[2], e[0], e[1], e[2], metallic, roughness, occlusion, unlit, alpha]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lane::Word;
    use bytemuck::Zeroable;

    /// The color of a white surface, or of nothing, in this frame, with ambient light of 1/8 and a
    /// background of (1/4, 0, 1); half of the light that arrives makes a highlight.
    fn shaded(frame: Frame, material: Option<MaterialRecord>) -> [f32; 4] {
        let [ambient_r, ambient_g, ambient_b] = [0.125; 3];
        let [background_r, background_g, background_b] = [0.25, 0.0, 1.0];
        let frame =
            Frame { ambient_r, ambient_g, ambient_b, background_r, background_g, background_b, ..frame };
        let materials = [material.unwrap_or(MaterialRecord::zeroed())];
        let maps = Maps { materials: &materials, texels: &[] };
        let zero = V3::<f32>::splat((), [0.0; 3]);
        let surfaces = Surfaces {
            origin: zero,
            normal: V3::splat((), [0.0, 0.0, 1.0]),
            material: Word(material.is_some() as u32),
            color: Word(u32::MAX),
            uv: [0.0; 2],
            footprint: 0.0,
            second_uv: [0.0; 2],
            second_footprint: 0.0,
        };
        let arriving =
            IncomingLight { diffuse: V3::splat((), [1.0, 2.0, 0.0]), specular: V3::splat((), [0.5; 3]) };
        shade(&frame, &maps, V3::splat((), [0.0, 0.0, -1.0]), &surfaces, &arriving)
    }

    fn dielectric() -> MaterialRecord {
        let (base, specular) = ([0.5, 0.25, 1.0], [0.0625; 3]);
        MaterialRecord { base, specular, occlusion: 1.0, ..MaterialRecord::zeroed() }
    }

    fn near(a: [f32; 4], b: [f32; 4]) -> bool {
        a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6)
    }

    #[test]
    fn a_surface_adds_diffuse_light_highlight_and_emission() {
        // diffuse · (ambient + light) + specular · highlight
        let lit = shaded(Frame::zeroed(), Some(dielectric()));
        assert!(near(lit, [0.5 * 1.125 + 0.03125, 0.25 * 2.125 + 0.03125, 0.125 + 0.03125, 1.0]), "{lit:?}");
        let glowing = MaterialRecord { emission: [0.0, 3.0, 0.0], ..dielectric() };
        assert!((shaded(Frame::zeroed(), Some(glowing))[1] - lit[1] - 3.0).abs() < 1e-5);
        // A metal has half of the diffuse color, and a highlight of its own color; a rough one half of it.
        let metal = MaterialRecord { metallic: 1.0, roughness: 1.0, ..dielectric() };
        let lit = shaded(Frame::zeroed(), Some(metal));
        assert!(
            near(lit, [0.25 * 1.125 + 0.125, 0.125 * 2.125 + 0.0625, 0.5 * 0.125 + 0.25, 1.0]),
            "{lit:?}"
        );
    }

    #[test]
    fn an_unlit_surface_shows_its_base_color_and_what_hits_nothing_covers_nothing() {
        let unlit = MaterialRecord { unlit: 1, ..dielectric() };
        assert_eq!(shaded(Frame::zeroed(), Some(unlit)), [0.5, 0.25, 1.0, 1.0]);
        assert_eq!(shaded(Frame::zeroed(), None), [0.0; 4]);
    }

    #[test]
    fn what_catches_shadows_is_as_dark_as_the_light_that_is_missing() {
        let (unlit, alpha_mode) = (MaterialRecord::CATCHES_SHADOWS, AlphaKind::Blend as u32);
        let catcher = MaterialRecord { unlit, alpha_mode, ..MaterialRecord::zeroed() };
        // Of 1/8 from everywhere, of (1, 2, 0) that arrives, and of 1/2 that does not.
        let all = 0.125 + 0.2126 + 2.0 * 0.7152 + 0.5;
        assert!(near(shaded(Frame::zeroed(), Some(catcher)), [0.0, 0.0, 0.0, 0.5 / all]));
    }

    #[test]
    fn only_what_blends_has_an_alpha() {
        let with = |kind: AlphaKind| {
            let material = MaterialRecord { alpha: 0.25, alpha_mode: kind as u32, ..dielectric() };
            shaded(Frame::zeroed(), Some(material))[3]
        };
        assert_eq!(
            [with(AlphaKind::Opaque), with(AlphaKind::Mask), with(AlphaKind::Blend)],
            [1.0, 1.0, 0.25]
        );
    }
}

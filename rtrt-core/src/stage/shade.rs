//! Shade: the color that a ray brings back.

use crate::kernel::brushed::bent;
use crate::kernel::environment::{arriving as arriving_from, mirrored};
use crate::kernel::microfacet::widened;
use crate::kernel::split_sum::albedo;
use crate::kernel::tangent::unpack_direction;
use crate::kernel::texture::{Maps, MaterialField, MaterialLookup, TexCoords, sample};
use crate::kernel::thin_film::Film;
use crate::kernel::vertex_color::channels;
use crate::lane::{Bits, Lane, Mask, Select, V3, times};
use crate::layout::{AlphaKind, Frame, MaterialRecord};
use crate::num::{FLOOR, clamp, flush, flush3, normalize, recip};
use crate::stage::beyond::{Beyond, Pane};
use crate::stage::coating::Coating;
use crate::stage::light::{IncomingLight, brushed};
use crate::stage::surface::Surfaces;

/// What a group of rays has found.
#[derive(Clone, Copy)]
pub struct Shaded<L> {
    /// Linear RGB.
    pub color: V3<L>,
    /// How much of what is behind it that covers, 0 ..= 1.
    pub alpha: L,
    /// The share of light from behind that comes through what is covered, a channel; 0 but for glass.
    pub through: V3<L>,
    /// Where that light comes from, in frames with [deflecting layers](Frame::has_deflecting_layers).
    pub beyond: Beyond<L>,
}

impl<L: Lane> Shaded<L> {
    /// The record of an opaque surface, or of a background.
    #[inline(always)]
    pub fn record(&self) -> [L; 4] {
        [self.color.x, self.color.y, self.color.z, self.alpha]
    }
}

/// The color and alpha of what a group of rays has found, by glTF's metallic-roughness model (glTF 2.0,
/// Appendix B):
///
/// ```text
/// diffuse · ((1 − F₀) · diffuse light + (1 − R) · ambient · occlusion)
///     + mirror · specular light + F₉₀ · grazing light
///     + M · mirrored · mirrored share
///     + emission
///
/// through = base · (1 − metallic) · transmission · (1 − R)
///
/// occlusion      = texture of occlusion, or else the share that [`ambient`](crate::stage::ambient) finds
/// mirrored share = texture of occlusion, or else share + (1 − share) · (1 − roughness)²
///
/// base    = material · texture · vertex color
/// diffuse = base · (1 − metallic) · (1 − transmission)
/// F₀      = strength · specular, what a surface that is no metal mirrors head-on
/// mirror  = F₀ + (base − F₀) · metallic
/// F₉₀     = strength + (1 − strength) · metallic
/// R, M    = what F₀ and mirror give back of light from all around (see `split_sum`)
/// ```
///
/// or the base color alone, of a material that is unlit, or the environment where it found nothing. `metallic`,
/// `roughness`, `occlusion` and `emission` are the material's times its textures. The parts of light are those of
/// [`Lit`](crate::layout::Lit). Alpha is 1, but of a material that blends: the material's, times the texture's and
/// the vertex color's; and 0 where it found nothing, unless the frame shows the environment there. A surface that
/// catches shadows is black, and its alpha is how dark they are. Extensions of materials change `specular`, `strength`,
/// `mirror` and `F₉₀` (see [`MaterialRecord`]), and lay a sheen and a clear coat over it all (see `coating`).
///
/// `ambient` comes from the environment, by the normal, and `mirrored` from it along the mirrored ray, blurred as
/// the roughness says. Without an environment both are the ambient light, which has one radiance everywhere.
/// An environment is the background too, seen where `beyond` says, unless the frame says otherwise. The paper mirrors it whatever occludes
/// it; here, as in glTF, the texture of occlusion dims all light that comes from no lamp.
#[inline(always)]
pub fn shade<L: Lane>(
    frame: &Frame,
    maps: &Maps<'_>,
    direction: V3<L>,
    beyond: &Beyond<L>,
    surfaces: &Surfaces<L>,
    arriving: &IncomingLight<L>,
    share: L,
) -> Shaded<L> {
    let token = surfaces.footprint.token();
    let one = surfaces.footprint.broadcast(1.0);
    let sky = frame.sky();
    let found = surfaces.material.gt(surfaces.material.broadcast(0));
    let shows_sky = frame.shows_sky();
    let clear = one.broadcast(if shows_sky { 1.0 } else { 0.0 });
    let background = if shows_sky && (!found).any() {
        let mut blur = one.broadcast(frame.backdrop_blur);
        if frame.has_deflecting_layers() {
            blur = blur.max(beyond.roughness());
        }
        let behind = mirrored(maps, sky, beyond.direction, blur);
        flush3(behind.scale(one.broadcast(frame.backdrop_strength)))
    } else {
        V3::splat(token, [0.0; 3])
    };
    if !found.any() {
        return Shaded {
            color: background,
            alpha: clear,
            through: V3::splat(token, [0.0; 3]),
            beyond: *beyond,
        };
    }
    let to_viewer = normalize(-direction);
    let material = surface_material(frame, maps, surfaces, to_viewer);
    let flat = V3::splat(token, [frame.ambient_r, frame.ambient_g, frame.ambient_b]);
    let ambient = if sky.first == 0 { flat } else { flush3(arriving_from(maps, sky, surfaces.normal)) };
    // A material with a texture of occlusion brings its own.
    let share = material.has_occlusion.select(one, share);
    let around = Around { ambient, share };
    let (lit, kept) = lit(frame, maps, to_viewer, surfaces, &material, around, arriving);
    let through = if frame.has_colored_layers() {
        let through = flush3(material.clear.scale(kept));
        V3::select(found, through, V3::splat(token, [0.0; 3]))
    } else {
        V3::splat(token, [0.0; 3])
    };
    let mut beyond = *beyond;
    if frame.has_deflecting_layers() {
        let [refraction]: [L; 1] =
            MaterialLookup::new(surfaces.material).numbers::<Refraction, 1>(token, maps);
        let none = one.broadcast(0.0);
        let clear = through.x.gt(none) | through.y.gt(none) | through.z.gt(none);
        let pane = Pane { normal: surfaces.normal, roughness: material.roughness, refraction };
        beyond = beyond.through(clear, &pane);
    }
    let color = V3::select(found, V3::select(material.unlit, flush3(material.base), lit), background);
    let mut alpha = material.alpha;
    if frame.has(MaterialRecord::IS_SHADOW_CATCHER) {
        alpha = material.catches.select(flush(shadow(ambient, share, arriving)), alpha);
    }
    Shaded { color, alpha: found.select(alpha, clear), through, beyond }
}

/// The light from all around.
#[derive(Clone, Copy)]
struct Around<L> {
    /// That which arrives where nothing hides any, as radiance.
    ambient: V3<L>,
    /// The share of it that arrives past what is near.
    share: L,
}

/// The light that surfaces of these materials send toward the viewer, and the share of what is behind them that they
/// do not mirror away.
#[inline(always)]
fn lit<L: Lane>(
    frame: &Frame,
    maps: &Maps<'_>,
    to_viewer: V3<L>,
    surfaces: &Surfaces<L>,
    material: &SurfaceMaterial<L>,
    around: Around<L>,
    arriving: &IncomingLight<L>,
) -> (V3<L>, L) {
    let Around { ambient, share } = around;
    let &SurfaceMaterial { diffuse, dielectric, mirror, grazing, roughness, .. } = material;
    let &SurfaceMaterial { strength, emission, occlusion, cosine, .. } = material;
    let one = roughness.broadcast(1.0);
    let sky = frame.sky();
    let around = if sky.first == 0 {
        ambient
    } else {
        let mut normal = surfaces.normal;
        if frame.has(MaterialRecord::IS_BRUSHED) {
            normal = bent_normal(maps, surfaces, to_viewer, roughness);
        }
        let along = normal.scale(normal.dot(to_viewer) * 2.0) - to_viewer;
        flush3(mirrored(maps, sky, along, roughness))
    };
    // A smooth surface mirrors one direction, of which the share knows little.
    let glossy = one - roughness;
    let mirrored_share = occlusion * (share + (one - share) * flush(glossy * glossy));
    let occlusion = occlusion * share;
    let albedo = albedo(cosine, roughness);
    let kept = one - albedo.reflectance(dielectric, strength);
    let through = flush3(ambient.scale(occlusion * kept)) + flush3(arriving.diffuse.scale(one - dielectric));
    let reflectance = V3 {
        x: albedo.reflectance(mirror.x, grazing.x),
        y: albedo.reflectance(mirror.y, grazing.y),
        z: albedo.reflectance(mirror.z, grazing.z),
    };
    let reflected = flush3(times(reflectance, around.scale(mirrored_share)));
    let highlight = flush3(times(mirror, arriving.specular) + times(grazing, arriving.grazing));
    let answer = flush3(times(diffuse, through)) + reflected + highlight;
    if !frame.has(MaterialRecord::HAS_COAT | MaterialRecord::HAS_SHEEN) {
        return (flush3(answer + emission), kept);
    }
    let coating = Coating::new(frame, maps, surfaces.material, surfaces, to_viewer);
    let below = flush3(answer.scale(coating.through_sheen()) + emission).scale(coating.through_coat());
    let above = coating.mirrored(frame, maps, surfaces.normal, to_viewer, ambient).scale(mirrored_share);
    let color = flush3(flush3(below) + flush3(above) + arriving.coating);
    (color, kept * coating.through_sheen() * coating.through_coat())
}

/// The normals that the mirrored rays of surfaces are of, bent where they are brushed.
#[inline(always)]
fn bent_normal<L: Lane>(maps: &Maps<'_>, surfaces: &Surfaces<L>, to_viewer: V3<L>, roughness: L) -> V3<L> {
    let strength = brushed(maps, &MaterialLookup::new(surfaces.material), surfaces);
    let is_brushed = strength.gt(strength.broadcast(0.0));
    let tangent = unpack_direction(surfaces.tangent);
    let bent = bent(surfaces.normal, tangent, to_viewer, roughness, strength);
    V3::select(is_brushed, bent, surfaces.normal)
}

/// The alpha of a surface that catches shadows:
///
/// ```text
/// (missing + (1 − share) · π · ambient) / (π · ambient + reached + missing)
/// ```
///
/// of the luminances of what arrives, so that black with this alpha darkens what is behind it as much as the shadow
/// would.
#[inline(always)]
fn shadow<L: Lane>(ambient: V3<L>, share: L, arriving: &IncomingLight<L>) -> L {
    let missing = luminance(arriving.specular);
    let around = luminance(ambient) * core::f32::consts::PI;
    let all = around + luminance(arriving.diffuse) + missing;
    let none = all.broadcast(0.0);
    let missing = missing + flush(around * (none.broadcast(1.0) - share));
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
    let chosen = MaterialLookup::new(surfaces.material);
    let [r, g, b]: [L; 3] = chosen.numbers::<Base, 3>(surfaces.footprint.token(), maps);
    let (base, _) = painted(maps, &chosen, surfaces, V3 { x: r, y: g, z: b });
    flush3(base)
}

/// A material's base color.
struct Base;

impl MaterialField<3> for Base {
    #[inline(always)]
    fn pick(material: &MaterialRecord) -> [f32; 3] {
        material.base
    }
}

/// A color times texture and vertex color, and the alpha of these.
#[inline(always)]
fn painted<L: Lane>(
    maps: &Maps<'_>,
    chosen: &MaterialLookup<L>,
    surfaces: &Surfaces<L>,
    base: V3<L>,
) -> (V3<L>, L) {
    let texture = sample::<L, { MaterialRecord::COLOR }, true>(maps, chosen, &surfaces.tex_coords());
    let [red, green] = channels::<L>(surfaces.color[0]);
    let [blue, alpha] = channels::<L>(surfaces.color[1]);
    let color =
        V3 { x: base.x * texture[0] * red, y: base.y * texture[1] * green, z: base.z * texture[2] * blue };
    (color, texture[3] * alpha)
}

/// What a group of surfaces is like, its textures included.
struct SurfaceMaterial<L: Lane> {
    base: V3<L>,
    diffuse: V3<L>,
    /// The share of light from behind that goes through it where it mirrors nothing.
    clear: V3<L>,
    /// What it would mirror head-on if it were no metal, and at grazing angles.
    dielectric: L,
    strength: L,
    /// What it mirrors head-on, and at grazing angles.
    mirror: V3<L>,
    grazing: V3<L>,
    /// Widened by the variance of its normals.
    roughness: L,
    emission: V3<L>,
    /// The share of the ambient light that arrives, by a texture.
    occlusion: L,
    /// Whether there is such a texture.
    has_occlusion: L::Mask,
    unlit: L::Mask,
    /// Whether they show shadows and nothing else.
    catches: L::Mask,
    alpha: L,
    /// Of the normal and the viewer.
    cosine: L,
}

/// What the surfaces are like, seen from this direction, of unit length.
#[inline(always)]
fn surface_material<L: Lane>(
    frame: &Frame,
    maps: &Maps<'_>,
    surfaces: &Surfaces<L>,
    to_viewer: V3<L>,
) -> SurfaceMaterial<L> {
    let token = surfaces.footprint.token();
    let one = surfaces.footprint.broadcast(1.0);
    let chosen = MaterialLookup::new(surfaces.material);
    let tex_coords = surfaces.tex_coords();
    let [br, bg, bb, er, eg, eb, metallic, roughness, occlusion, unlit, alpha] =
        chosen.numbers::<Numbers, 11>(token, maps);
    let (base, painted_alpha) = painted(maps, &chosen, surfaces, V3 { x: br, y: bg, z: bb });
    let [_, green, blue, _] = sample::<L, { MaterialRecord::ROUGHNESS }, false>(maps, &chosen, &tex_coords);
    let (metallic, roughness) = (metallic * blue, roughness * green);
    let [occluded, _, _, _] = sample::<L, { MaterialRecord::OCCLUSION }, false>(maps, &chosen, &tex_coords);
    let glow = sample::<L, { MaterialRecord::EMISSION }, true>(maps, &chosen, &tex_coords);
    let (specular, strength) = specular(frame, maps, &chosen, surfaces);
    // More than all of the light is never mirrored.
    let mirrored = |base: L, specular: L| clamp(specular + (base - specular) * metallic, 0.0, 1.0);
    let grazing = strength + (one - strength) * metallic;
    let mut material = SurfaceMaterial {
        base,
        diffuse: base.scale(one - metallic),
        clear: V3::splat(token, [0.0; 3]),
        dielectric: specular.x.max(specular.y).max(specular.z),
        strength,
        mirror: V3 {
            x: mirrored(base.x, specular.x),
            y: mirrored(base.y, specular.y),
            z: mirrored(base.z, specular.z),
        },
        grazing: V3 { x: grazing, y: grazing, z: grazing },
        roughness: widened(roughness, surfaces.variance),
        emission: V3 { x: flush(er * glow[0]), y: flush(eg * glow[1]), z: flush(eb * glow[2]) },
        occlusion: one + (occluded - one) * occlusion,
        has_occlusion: occlusion.gt(one.broadcast(0.0)),
        unlit: unlit.ge(one),
        catches: unlit.ge(one.broadcast(MaterialRecord::CATCHES_SHADOWS as f32)),
        alpha: alpha.lt(one.broadcast(0.0)).select(one, flush(clamp(alpha * painted_alpha, 0.0, 1.0))),
        cosine: surfaces.normal.dot(to_viewer),
    };
    if frame.has(MaterialRecord::TRANSMITS) {
        let [share]: [L; 1] = chosen.numbers::<Transmission, 1>(token, maps);
        let [red, ..] = sample::<L, { MaterialRecord::TRANSMISSION }, false>(maps, &chosen, &tex_coords);
        let share = share * red;
        // More light than there is comes through no glass.
        let within = |color: L| clamp(color, 0.0, 1.0) * share;
        let diffuse = material.diffuse;
        material.clear = V3 { x: within(diffuse.x), y: within(diffuse.y), z: within(diffuse.z) };
        material.diffuse = diffuse.scale(one - share);
    }
    if frame.has(MaterialRecord::HAS_FILM) {
        under_film(maps, &chosen, &tex_coords, &mut material);
    }
    material
}

/// What surfaces that are no metals mirror head-on, and at grazing angles.
#[inline(always)]
fn specular<L: Lane>(
    frame: &Frame,
    maps: &Maps<'_>,
    chosen: &MaterialLookup<L>,
    surfaces: &Surfaces<L>,
) -> (V3<L>, L) {
    let [mut r, mut g, mut b, mut strength]: [L; 4] =
        chosen.numbers::<Specular, 4>(surfaces.footprint.token(), maps);
    if frame.has(MaterialRecord::SPECULAR_MAPS) {
        let tex_coords = surfaces.tex_coords();
        let [x, y, z, _] = sample::<L, { MaterialRecord::SPECULAR_COLOR }, true>(maps, chosen, &tex_coords);
        let [.., share] = sample::<L, { MaterialRecord::SPECULAR }, false>(maps, chosen, &tex_coords);
        (r, g, b, strength) = (r * x, g * y, b * z, strength * share);
    }
    let share = |specular: L| specular.min(specular.broadcast(1.0)) * strength;
    (V3 { x: share(r), y: share(g), z: share(b) }, strength)
}

/// What surfaces mirror that are no metals.
struct Specular;

impl MaterialField<4> for Specular {
    #[inline(always)]
    fn pick(material: &MaterialRecord) -> [f32; 4] {
        let [r, g, b] = material.specular;
        [r, g, b, material.strength]
    }
}

/// Changes what surfaces mirror to what they mirror under their thin films: the film's colors at the angle of the viewer,
/// head-on and at grazing angles, since they have the rise toward the rim in them.
#[inline(always)]
fn under_film<L: Lane>(
    maps: &Maps<'_>,
    chosen: &MaterialLookup<L>,
    tex_coords: &TexCoords<L>,
    material: &mut SurfaceMaterial<L>,
) {
    let [film, ior, thin, thick]: [L; 4] = chosen.numbers::<FilmOf, 4>(material.cosine.token(), maps);
    let [share, ..] = sample::<L, { MaterialRecord::FILM }, false>(maps, chosen, tex_coords);
    let [_, thickness, ..] = sample::<L, { MaterialRecord::FILM_THICKNESS }, false>(maps, chosen, tex_coords);
    let share = film * share;
    let film = Film { ior, thickness: thin + (thick - thin) * thickness };
    let seen = film.reflectance(material.cosine, material.mirror);
    let seen = V3 { x: clamp(seen.x, 0.0, 1.0), y: clamp(seen.y, 0.0, 1.0), z: clamp(seen.z, 0.0, 1.0) };
    let most = seen.x.max(seen.y).max(seen.z);
    let under = |seen: L, bare: L| bare + (seen - bare) * share;
    let each =
        |bare: V3<L>| V3 { x: under(seen.x, bare.x), y: under(seen.y, bare.y), z: under(seen.z, bare.z) };
    (material.mirror, material.grazing) = (each(material.mirror), each(material.grazing));
    material.dielectric = under(most, material.dielectric);
    material.strength = under(most, material.strength);
}

/// The thin film of a material.
struct FilmOf;

impl MaterialField<4> for FilmOf {
    #[inline(always)]
    fn pick(material: &MaterialRecord) -> [f32; 4] {
        let [thin, thick] = material.film_thickness;
        [material.film, material.film_ior, thin, thick]
    }
}

/// How much of the light goes through.
struct Transmission;

impl MaterialField<1> for Transmission {
    #[inline(always)]
    fn pick(material: &MaterialRecord) -> [f32; 1] {
        [material.transmission]
    }
}

/// How much the body of a material turns light.
struct Refraction;

impl MaterialField<1> for Refraction {
    #[inline(always)]
    fn pick(material: &MaterialRecord) -> [f32; 1] {
        [material.refraction]
    }
}

/// What a material says of its surfaces, but for what they mirror.
struct Numbers;

impl MaterialField<11> for Numbers {
    #[inline(always)]
    fn pick(material: &MaterialRecord) -> [f32; 11] {
        let (b, e) = (&material.base, &material.emission);
        let (metallic, roughness) = (material.metallic, material.roughness);
        let (occlusion, unlit) = (material.occlusion, material.unlit as f32);
        // Negative for opaque surfaces.
        let blends = material.alpha_mode == AlphaKind::Blend as u32
            && material.extensions & MaterialRecord::IGNORES_ALPHA == 0;
        let alpha = if blends { material.alpha } else { -1.0 };
        [b[0], b[1], b[2], e[0], e[1], e[2], metallic, roughness, occlusion, unlit, alpha]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lane::Word;
    use bytemuck::Zeroable;

    /// What is shaded of a surface seen head-on, or of nothing, with ambient light of 1/8.
    fn shaded(frame: Frame, material: Option<MaterialRecord>) -> Shaded<f32> {
        shaded_along([0.0, 0.0, -1.0], frame, material)
    }

    /// The same of a ray in this direction, of unit length.
    fn shaded_along(direction: [f32; 3], frame: Frame, material: Option<MaterialRecord>) -> Shaded<f32> {
        let [ambient_r, ambient_g, ambient_b] = [0.125; 3];
        let frame = Frame { ambient_r, ambient_g, ambient_b, ..frame };
        let materials = [material.unwrap_or(MaterialRecord::zeroed())];
        let maps = Maps { materials: &materials, texels: &[] };
        let zero = V3::<f32>::splat((), [0.0; 3]);
        let surfaces = Surfaces {
            origin: zero,
            normal: V3::splat((), [0.0, 0.0, 1.0]),
            material: Word(material.is_some() as u32),
            color: [Word(u32::MAX); 2],
            uv: [0.0; 2],
            footprint: 0.0,
            second_uv: [0.0; 2],
            second_footprint: 0.0,
            variance: 0.0,
            coat_normal: Word(0),
            tangent: Word(0),
        };
        let arriving = IncomingLight {
            diffuse: V3::splat((), [1.0, 2.0, 0.0]),
            specular: V3::splat((), [0.5; 3]),
            grazing: V3::splat((), [0.25; 3]),
            coating: zero,
        };
        let direction = V3::splat((), direction);
        shade(&frame, &maps, direction, &Beyond::new(direction), &surfaces, &arriving, 1.0)
    }

    /// A smooth surface that is no metal.
    fn dielectric() -> MaterialRecord {
        let (base, specular) = ([0.5, 0.25, 1.0], [0.0625; 3]);
        MaterialRecord { base, specular, strength: 1.0, occlusion: 1.0, ..MaterialRecord::zeroed() }
    }

    /// Within the error of the split sum's fit.
    fn near(a: [f32; 3], b: [f32; 3]) -> bool {
        a.iter().zip(b).all(|(a, b)| (a - b).abs() < 0.01)
    }

    #[test]
    fn a_surface_adds_diffuse_light_highlight_surroundings_and_emission() {
        let lit = shaded(Frame::zeroed(), Some(dielectric())).color.lane(0);
        // The share 1/16 of everything is mirrored, and the rest meets the diffuse color.
        let mirrored = 0.0625 * 0.5 + 0.25 + 0.0625 * 0.125;
        let through = [1.125, 2.125, 0.125].map(|light| light * 0.9375);
        let expected = [0, 1, 2].map(|i| dielectric().base[i] * through[i] + mirrored);
        assert!(near(lit, expected), "{lit:?} {expected:?}");
        let glowing = MaterialRecord { emission: [0.0, 3.0, 0.0], ..dielectric() };
        assert!((shaded(Frame::zeroed(), Some(glowing)).color.y - lit[1] - 3.0).abs() < 1e-5);
        // A metal has no diffuse color. A matte one gives back 1 - ln 2 at once, and more of the rest.
        let metal = MaterialRecord { metallic: 1.0, roughness: 1.0, ..dielectric() };
        let lit = shaded(Frame::zeroed(), Some(metal)).color.lane(0);
        let once = 1.0 - core::f32::consts::LN_2;
        let mean = |base: f32| base + (1.0 - base) / 21.0;
        let back = |base: f32| base * once / (1.0 - mean(base) * core::f32::consts::LN_2);
        let expected = metal.base.map(|base| base * 0.5 + 0.25 + back(base) * 0.125);
        assert!(near(lit, expected), "{lit:?} {expected:?}");
    }

    #[test]
    fn a_film_mirrors_what_its_formula_says_at_any_angle() {
        let frame = Frame { extensions: MaterialRecord::HAS_FILM, ..Frame::zeroed() };
        for thickness in [250.0, 400.0, 550.0] {
            let black = MaterialRecord { base: [0.0; 3], ..dielectric() };
            let filmed =
                MaterialRecord { film: 1.0, film_ior: 1.3, film_thickness: [0.0, thickness], ..black };
            for (sin, cos) in [(0.0, 1.0), (0.8, 0.6), (0.96, 0.28)] {
                let film = Film { ior: 1.3_f32, thickness };
                let seen = film.reflectance(cos, V3::splat((), black.specular)).lane(0);
                // Of 1/8 from everywhere, and of both parts of the light that arrives.
                let expected = seen.map(|seen| seen * (0.125 + 0.5 + 0.25));
                let lit = shaded_along([sin, 0.0, -cos], frame, Some(filmed)).color.lane(0);
                assert!(near(lit, expected), "{thickness} {cos}: {lit:?} {expected:?}");
            }
        }
    }

    #[test]
    fn glass_lets_through_what_it_neither_mirrors_nor_holds_back() {
        let frame = Frame { layers: 2, extensions: MaterialRecord::TRANSMITS, ..Frame::zeroed() };
        let glass = MaterialRecord { transmission: 0.5, ..dielectric() };
        let found = shaded(frame, Some(glass));
        assert!(near(found.through.lane(0), glass.base.map(|base| base * 0.5 * 0.9375)));
        let [opaque, half] =
            [dielectric(), glass].map(|material| shaded(frame, Some(material)).color.lane(0));
        let black = shaded(frame, Some(MaterialRecord { base: [0.0; 3], ..dielectric() })).color.lane(0);
        assert!(near(half, [0, 1, 2].map(|i| (opaque[i] + black[i]) * 0.5)), "{half:?}");
        assert_eq!(shaded(frame, None).through.lane(0), [0.0; 3]);
    }

    #[test]
    fn light_turns_and_scatters_where_there_is_glass() {
        let extensions = MaterialRecord::TRANSMITS | MaterialRecord::DEFLECTS;
        let frame = Frame { layers: 2, extensions, ..Frame::zeroed() };
        let rough = MaterialRecord { transmission: 0.5, roughness: 0.5, refraction: 1.0, ..dielectric() };
        let behind = |material| shaded(frame, Some(material)).beyond.roughness();
        assert!((behind(rough) - 0.5).abs() < 1e-4);
        // What lets nothing through, and frames that do not ask.
        assert_eq!(behind(MaterialRecord { transmission: 0.0, ..rough }), 0.0);
        let plain = Frame { extensions: MaterialRecord::TRANSMITS, ..frame };
        assert_eq!(shaded(plain, Some(rough)).beyond.roughness(), 0.0);
    }

    #[test]
    fn an_unlit_surface_shows_its_base_color_and_what_hits_nothing_covers_nothing() {
        let unlit = MaterialRecord { unlit: 1, ..dielectric() };
        assert_eq!(shaded(Frame::zeroed(), Some(unlit)).record(), [0.5, 0.25, 1.0, 1.0]);
        assert_eq!(shaded(Frame::zeroed(), None).record(), [0.0; 4]);
    }

    #[test]
    fn what_catches_shadows_is_as_dark_as_the_light_that_is_missing() {
        let (unlit, alpha_mode) = (MaterialRecord::CATCHES_SHADOWS, AlphaKind::Blend as u32);
        let catcher = MaterialRecord { unlit, alpha_mode, ..MaterialRecord::zeroed() };
        // Of 1/8 from everywhere, of (1, 2, 0) that arrives, and of 1/2 that does not.
        let all = 0.125 * core::f32::consts::PI + 0.2126 + 2.0 * 0.7152 + 0.5;
        let frame = Frame { extensions: MaterialRecord::IS_SHADOW_CATCHER, ..Frame::zeroed() };
        let found = shaded(frame, Some(catcher));
        assert_eq!(found.color.lane(0), [0.0; 3]);
        assert!((found.alpha - 0.5 / all).abs() < 1e-6, "{}", found.alpha);
    }

    #[test]
    fn only_what_blends_has_an_alpha() {
        let with = |kind: AlphaKind| {
            let material = MaterialRecord { alpha: 0.25, alpha_mode: kind as u32, ..dielectric() };
            shaded(Frame::zeroed(), Some(material)).alpha
        };
        assert_eq!(
            [with(AlphaKind::Opaque), with(AlphaKind::Mask), with(AlphaKind::Blend)],
            [1.0, 1.0, 0.25]
        );
    }
}

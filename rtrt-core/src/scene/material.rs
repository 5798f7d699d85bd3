//! Materials as people write them, and the records that backends read.

use crate::layout::{AlphaKind, COLOR_LIMIT, LIGHT_LIMIT, MaterialRecord, Texture};
use crate::scene::floor::floored;
use crate::scene::{Anisotropy, Clearcoat, Iridescence, SceneError, Sheen};
use bytemuck::Zeroable;
use core::slice;
use glam::Vec3;

/// The light that a surface that is no metal mirrors head-on.
const DIELECTRIC: f32 = 0.04;

/// What the alpha of a surface does.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum AlphaMode {
    /// Nothing.
    #[default]
    Opaque,
    /// The surface is there, and opaque, where alpha is at least `cutoff`; elsewhere there is a hole.
    Mask {
        /// The least alpha of what is there, within ± [`COLOR_LIMIT`].
        cutoff: f32,
    },
    /// Alpha is the share of what is behind the surface that it covers.
    Blend,
    /// The surface shows the shadows on it and nothing else: see [`Material::shadow_catcher`].
    Shadows,
}

/// How a surface answers light: metallic-roughness, as in glTF.
///
/// ```text
/// diffuse  = base · (1 − metallic) · (1 − F) / π
/// mirrored = F · D · V,   F = F₀ + (F₉₀ − F₀) · (1 − v·h)⁵
///
/// F₀  = specular · strength   towards base, by metallic
/// F₉₀ = strength              towards 1, by metallic
/// ```
///
/// `D` is GGX of width `roughness²` and `V` Smith's visibility (glTF 2.0, Appendix B). Maps multiply base color,
/// metalness and roughness before this is computed, for each ray (see [`crate::stage::shade`]).
///
/// ```
/// use rtrt_core::scene::{AlphaMode, Material};
///
/// let gold = Material::new([0.9, 0.6, 0.2]).metallic(1.0).roughness(0.3);
/// assert_eq!((gold.double_sided, gold.alpha_mode), (true, AlphaMode::Opaque));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Material {
    /// Linear RGB within ± [`COLOR_LIMIT`], multiplied with its map and the vertex color. White unless set.
    pub base_color: Vec3,
    /// The map of the base color and of alpha, sRGB.
    pub base_color_map: Option<Texture>,
    /// How much of a metal the surface is, 0 ..= 1. 0 unless set.
    pub metallic: f32,
    /// 0 ..= 1, from a mirror to a matte surface. 1 unless set.
    pub roughness: f32,
    /// The map that multiplies roughness (green) and metalness (blue).
    pub metallic_roughness_map: Option<Texture>,
    /// Linear RGB, 0 ..= [`COLOR_LIMIT`], that a surface that is no metal mirrors head-on; beyond 1 it counts as 1.
    /// `((ior − 1) / (ior + 1))²` of an index of refraction. 0.04 unless set, that of 1.5.
    pub specular: Vec3,
    /// The share of light that a surface that is no metal mirrors at grazing angles, 0 ..= 1; multiplies
    /// `specular`, too. 1 unless set.
    pub specular_strength: f32,
    /// The map whose alpha multiplies `specular_strength`.
    pub specular_map: Option<Texture>,
    /// The map that multiplies `specular`, sRGB.
    pub specular_color_map: Option<Texture>,
    /// Light of its own, linear RGB within ± [`LIGHT_LIMIT`], multiplied with its map. Black unless set.
    pub emission: Vec3,
    /// The map of the emission, sRGB.
    pub emission_map: Option<Texture>,
    /// The map of normals, of [`Content::Normals`](crate::scene::Content): coordinates along tangent, bitangent and
    /// normal.
    pub normal_map: Option<Texture>,
    /// How strongly the map turns normals, within ± [`COLOR_LIMIT`]. 1 unless set.
    pub normal_scale: f32,
    /// The map of how much ambient light arrives (red).
    pub occlusion_map: Option<Texture>,
    /// How much of the ambient light the map may take, 0 ..= 1. 1 unless set.
    pub occlusion_strength: f32,
    /// Multiplied with the alpha of the map and of the vertex color, 0 ..= [`COLOR_LIMIT`]. 1 unless set.
    pub alpha: f32,
    /// What alpha does. Nothing unless set.
    pub alpha_mode: AlphaMode,
    /// Whether cameras and lights see the surface from both sides; otherwise they see only the side from which the
    /// corners of a triangle are counterclockwise, and the outside of a sphere, and nothing else casts a shadow. True
    /// unless set.
    pub double_sided: bool,
    /// Whether the surface shows its base color whatever the light. False unless set.
    pub unlit: bool,
    /// The share of light that goes through it, tinted by the base color, in place of being scattered, 0 ..= 1: the
    /// surface is a thin pane. Of no effect with [`AlphaMode::Mask`]. 0 unless set.
    pub transmission: f32,
    /// The map that multiplies it (red).
    pub transmission_map: Option<Texture>,
    /// The index of refraction, 1 ..= 8, of the body that the surface bounds and through which light goes; its mesh is
    /// closed and has both sides. 1, for a thin pane, unless set.
    pub refraction: f32,
    /// A clear coat. None unless set.
    pub clearcoat: Option<Clearcoat>,
    /// A sheen. None unless set.
    pub sheen: Option<Sheen>,
    /// Scratches along one direction. None unless set.
    pub anisotropy: Option<Anisotropy>,
    /// A thin film. None unless set.
    pub iridescence: Option<Iridescence>,
}

impl Default for Material {
    /// White and matte.
    fn default() -> Self {
        Self {
            base_color: Vec3::ONE,
            base_color_map: None,
            metallic: 0.0,
            roughness: 1.0,
            metallic_roughness_map: None,
            specular: Vec3::splat(DIELECTRIC),
            specular_strength: 1.0,
            specular_map: None,
            specular_color_map: None,
            emission: Vec3::ZERO,
            emission_map: None,
            normal_map: None,
            normal_scale: 1.0,
            occlusion_map: None,
            occlusion_strength: 1.0,
            alpha: 1.0,
            alpha_mode: AlphaMode::Opaque,
            double_sided: true,
            unlit: false,
            transmission: 0.0,
            transmission_map: None,
            refraction: 1.0,
            clearcoat: None,
            sheen: None,
            anisotropy: None,
            iridescence: None,
        }
    }
}

impl Material {
    /// The default material in another base color, linear RGB.
    pub fn new(base_color: impl Into<Vec3>) -> Self {
        Self { base_color: base_color.into(), ..Self::default() }
    }

    /// The material in another base color, linear RGB.
    #[must_use]
    pub fn base_color(self, base_color: impl Into<Vec3>) -> Self {
        Self { base_color: base_color.into(), ..self }
    }

    /// A surface that shows the shadows on it and nothing else, from its front. It darkens what is behind it by the share
    /// of light, with ambient light or the environment, that lights do not shed on it because something is between; it
    /// keeps no light from anything.
    pub fn shadow_catcher() -> Self {
        let nothing = Self { alpha: 0.0, alpha_mode: AlphaMode::Shadows, ..Self::new(Vec3::ZERO) };
        nothing.double_sided(false)
    }

    /// The material with a map of base color and alpha.
    #[must_use]
    pub fn base_color_map(self, map: impl Into<Option<Texture>>) -> Self {
        Self { base_color_map: map.into(), ..self }
    }

    /// The material with another metalness.
    #[must_use]
    pub fn metallic(self, metallic: f32) -> Self {
        Self { metallic, ..self }
    }

    /// The material with another roughness.
    #[must_use]
    pub fn roughness(self, roughness: f32) -> Self {
        Self { roughness, ..self }
    }

    /// The material with a map of roughness and metalness.
    #[must_use]
    pub fn metallic_roughness_map(self, map: impl Into<Option<Texture>>) -> Self {
        Self { metallic_roughness_map: map.into(), ..self }
    }

    /// The material that mirrors this color head-on where it is no metal.
    #[must_use]
    pub fn specular(self, specular: impl Into<Vec3>) -> Self {
        Self { specular: specular.into(), ..self }
    }

    /// The material that mirrors this share of light where it is no metal.
    #[must_use]
    pub fn specular_strength(self, specular_strength: f32) -> Self {
        Self { specular_strength, ..self }
    }

    /// The material with maps of the strength (alpha) and of the color (sRGB) of what it mirrors.
    #[must_use]
    pub fn specular_maps(self, strength: Option<Texture>, color: Option<Texture>) -> Self {
        Self { specular_map: strength, specular_color_map: color, ..self }
    }

    /// The material that lets this share of light through.
    #[must_use]
    pub fn transmission(self, transmission: f32, map: impl Into<Option<Texture>>) -> Self {
        Self { transmission, transmission_map: map.into(), ..self }
    }

    /// The material of a body with this index of refraction.
    #[must_use]
    pub fn refraction(self, refraction: f32) -> Self {
        Self { refraction, ..self }
    }

    /// The material with a clear coat.
    #[must_use]
    pub fn clearcoat(self, clearcoat: impl Into<Option<Clearcoat>>) -> Self {
        Self { clearcoat: clearcoat.into(), ..self }
    }

    /// The material with a sheen.
    #[must_use]
    pub fn sheen(self, sheen: impl Into<Option<Sheen>>) -> Self {
        Self { sheen: sheen.into(), ..self }
    }

    /// The material with scratches along one direction.
    #[must_use]
    pub fn anisotropy(self, anisotropy: impl Into<Option<Anisotropy>>) -> Self {
        Self { anisotropy: anisotropy.into(), ..self }
    }

    /// The material with a thin film.
    #[must_use]
    pub fn iridescence(self, iridescence: impl Into<Option<Iridescence>>) -> Self {
        Self { iridescence: iridescence.into(), ..self }
    }

    /// The material with light of its own.
    #[must_use]
    pub fn emission(self, emission: impl Into<Vec3>) -> Self {
        Self { emission: emission.into(), ..self }
    }

    /// The material with a map of its emission.
    #[must_use]
    pub fn emission_map(self, map: impl Into<Option<Texture>>) -> Self {
        Self { emission_map: map.into(), ..self }
    }

    /// The material with a map of normals, which turns them as strongly as `scale` says.
    #[must_use]
    pub fn normal_map(self, map: impl Into<Option<Texture>>, scale: f32) -> Self {
        Self { normal_map: map.into(), normal_scale: scale, ..self }
    }

    /// The material with a map of occlusion, which takes up to `strength` of the ambient light.
    #[must_use]
    pub fn occlusion_map(self, map: impl Into<Option<Texture>>, strength: f32) -> Self {
        Self { occlusion_map: map.into(), occlusion_strength: strength, ..self }
    }

    /// The material with another alpha, which counts where it is masked or blends.
    #[must_use]
    pub fn alpha(self, alpha: f32) -> Self {
        Self { alpha, ..self }
    }

    /// The material with holes where alpha is below `cutoff`.
    #[must_use]
    pub fn mask(self, cutoff: f32) -> Self {
        Self { alpha_mode: AlphaMode::Mask { cutoff }, ..self }
    }

    /// The material that covers `alpha` of what is behind it.
    #[must_use]
    pub fn blend(self, alpha: f32) -> Self {
        Self { alpha, alpha_mode: AlphaMode::Blend, ..self }
    }

    /// The material that the camera sees from both sides, or from one.
    #[must_use]
    pub fn double_sided(self, double_sided: bool) -> Self {
        Self { double_sided, ..self }
    }

    /// The material that shows its base color whatever the light, or does not.
    #[must_use]
    pub fn unlit(self, unlit: bool) -> Self {
        Self { unlit, ..self }
    }

    /// The material as backends read it: numbers too small to count are 0.
    ///
    /// # Errors
    /// A number is not finite, or out of its range.
    pub(super) fn record(&self) -> Result<MaterialRecord, SceneError> {
        let (kind, cutoff) = match self.alpha_mode {
            AlphaMode::Opaque => (AlphaKind::Opaque, 0.5),
            AlphaMode::Mask { cutoff } => (AlphaKind::Mask, cutoff),
            AlphaMode::Blend | AlphaMode::Shadows => (AlphaKind::Blend, 0.5),
        };
        let transmits = self.transmission > 0.0 && kind != AlphaKind::Mask;
        let ignores_alpha = transmits && kind == AlphaKind::Opaque;
        let kind = if transmits { AlphaKind::Blend } else { kind };
        let mut record = MaterialRecord {
            base: self.base_color.to_array(),
            strength: self.specular_strength,
            specular: self.specular.to_array(),
            metallic: self.metallic,
            emission: self.emission.to_array(),
            roughness: self.roughness,
            bump: self.normal_scale,
            occlusion: if self.occlusion_map.is_some() { self.occlusion_strength } else { 0.0 },
            unlit: match self.alpha_mode {
                AlphaMode::Shadows => MaterialRecord::CATCHES_SHADOWS,
                _ => u32::from(self.unlit),
            },
            alpha: self.alpha,
            alpha_mode: kind as u32,
            cutoff,
            double_sided: u32::from(self.double_sided),
            brushed_turn: [1.0, 0.0],
            transmission: if transmits { self.transmission } else { 0.0 },
            refraction: self.refraction,
            textures: [Texture::NONE; MaterialRecord::TEXTURES],
            ..MaterialRecord::zeroed()
        };
        if self.alpha_mode == AlphaMode::Shadows {
            (record.base, record.alpha) = ([0.0; 3], 0.0);
            record.extensions |= MaterialRecord::IS_SHADOW_CATCHER;
        }
        for (place, map) in [
            (MaterialRecord::COLOR, self.base_color_map),
            (MaterialRecord::NORMAL, self.normal_map),
            (MaterialRecord::ROUGHNESS, self.metallic_roughness_map),
            (MaterialRecord::OCCLUSION, self.occlusion_map),
            (MaterialRecord::EMISSION, self.emission_map),
            (MaterialRecord::SPECULAR, self.specular_map),
            (MaterialRecord::SPECULAR_COLOR, self.specular_color_map),
            (MaterialRecord::TRANSMISSION, self.transmission_map),
        ] {
            record.textures[place] = map.unwrap_or(Texture::NONE);
        }
        if self.specular_map.is_some() || self.specular_color_map.is_some() {
            record.extensions |= MaterialRecord::SPECULAR_MAPS;
        }
        if transmits {
            record.extensions |= MaterialRecord::TRANSMITS;
            if self.roughness > 0.0 || self.refraction > 1.0 {
                record.extensions |= MaterialRecord::DEFLECTS;
            }
        }
        if ignores_alpha {
            record.extensions |= MaterialRecord::IGNORES_ALPHA;
        }
        if let Some(clearcoat) = &self.clearcoat {
            clearcoat.record(&mut record);
        }
        if let Some(sheen) = &self.sheen {
            sheen.record(&mut record);
        }
        if let Some(anisotropy) = &self.anisotropy {
            anisotropy.record(&mut record);
        }
        if let Some(iridescence) = &self.iridescence {
            iridescence.record(&mut record);
        }
        check(&mut record)?;
        Ok(record)
    }
}

/// Makes 0 of numbers too small to count.
///
/// # Errors
/// A number is not finite, or out of its range.
fn check(m: &mut MaterialRecord) -> Result<(), SceneError> {
    within("base color", &mut m.base, -COLOR_LIMIT, COLOR_LIMIT)?;
    within("specular color", &mut m.specular, 0.0, COLOR_LIMIT)?;
    within("emission", &mut m.emission, -LIGHT_LIMIT, LIGHT_LIMIT)?;
    within("color of the sheen", &mut m.sheen, 0.0, 1.0)?;
    within("thickness of the film", &mut m.film_thickness, 0.0, 65_536.0)?;
    within("rotation of scratches", &mut m.brushed_turn, -1.0, 1.0)?;
    for (what, value, low, high) in [
        ("metalness", &mut m.metallic, 0.0, 1.0),
        ("roughness", &mut m.roughness, 0.0, 1.0),
        ("specular strength", &mut m.strength, 0.0, 1.0),
        ("strength of occlusion", &mut m.occlusion, 0.0, 1.0),
        ("strength of the normal map", &mut m.bump, -COLOR_LIMIT, COLOR_LIMIT),
        ("alpha", &mut m.alpha, 0.0, COLOR_LIMIT),
        ("cutoff", &mut m.cutoff, -COLOR_LIMIT, COLOR_LIMIT),
        ("share of the coat", &mut m.coat, 0.0, 1.0),
        ("roughness of the coat", &mut m.coat_roughness, 0.0, 1.0),
        ("strength of the coat's normal map", &mut m.coat_bump, -COLOR_LIMIT, COLOR_LIMIT),
        ("roughness of the sheen", &mut m.sheen_roughness, 0.0, 1.0),
        ("strength of scratches", &mut m.brushed, 0.0, 1.0),
        ("share of the film", &mut m.film, 0.0, 1.0),
        ("transmission", &mut m.transmission, 0.0, 1.0),
        ("index of refraction", &mut m.refraction, 1.0, 8.0),
    ] {
        within(what, slice::from_mut(value), low, high)?;
    }
    if m.extensions & MaterialRecord::HAS_FILM != 0 {
        within("index of refraction of the film", slice::from_mut(&mut m.film_ior), 1.0, 8.0)?;
    }
    for texture in &m.textures {
        let [u, v] = texture.turn;
        let mut numbers = [u[0], u[1], v[0], v[1], texture.shift[0], texture.shift[1], texture.log_size];
        within("placing of a texture", &mut numbers, f32::MIN, f32::MAX)?;
    }
    Ok(())
}

/// Makes 0 of what is too small to count.
///
/// # Errors
/// A number is out of range, as NaN always is.
fn within(what: &'static str, values: &mut [f32], low: f32, high: f32) -> Result<(), SceneError> {
    for value in values {
        if !(low..=high).contains(value) {
            return Err(SceneError::Material { what, value: *value, low, high });
        }
        *value = floored(*value);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_is_one_and_within_its_range() {
        let map = Texture { levels: 1, ..Texture::NONE };
        let usual = Material::new([0.5; 3])
            .metallic(0.5)
            .roughness(0.5)
            .emission([1.0; 3])
            .base_color_map(map)
            .occlusion_map(map, 1.0)
            .emission_map(map);
        assert!(usual.record().is_ok());
        fn placed(map: &mut Option<Texture>) -> &mut Texture {
            map.as_mut().expect("a map")
        }
        let fields: [fn(&mut Material) -> &mut f32; 14] = [
            |m| &mut m.base_color.x,
            |m| &mut m.base_color.z,
            |m| &mut m.specular.y,
            |m| &mut m.emission.x,
            |m| &mut m.specular_strength,
            |m| &mut m.metallic,
            |m| &mut m.roughness,
            |m| &mut m.occlusion_strength,
            |m| &mut m.normal_scale,
            |m| &mut m.alpha,
            |m| {
                m.alpha_mode = AlphaMode::Mask { cutoff: 0.0 };
                let AlphaMode::Mask { cutoff } = &mut m.alpha_mode else { unreachable!("it is a mask") };
                cutoff
            },
            |m| &mut placed(&mut m.occlusion_map).turn[1][0],
            |m| &mut placed(&mut m.emission_map).shift[1],
            |m| &mut placed(&mut m.base_color_map).log_size,
        ];
        for (number, field) in fields.into_iter().enumerate() {
            // Of where textures lie, only what is no number is refused.
            let large = if number < 11 { 1e30 } else { f32::NAN };
            for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, large] {
                let mut wrong = usual;
                *field(&mut wrong) = bad;
                assert!(matches!(wrong.record(), Err(SceneError::Material { .. })), "{number}: {bad}");
            }
        }
        let bright = Material::new([COLOR_LIMIT; 3]).emission([LIGHT_LIMIT; 3]);
        let record = bright.record().unwrap();
        assert_eq!((record.base, record.emission), ([COLOR_LIMIT; 3], [LIGHT_LIMIT; 3]));
    }

    #[test]
    fn a_record_says_what_the_material_says() {
        let rough = Material::default().roughness(0.5).record().unwrap();
        assert_eq!((rough.roughness, rough.specular, rough.strength), (0.5, [DIELECTRIC; 3], 1.0));
        assert_eq!((rough.alpha_mode, rough.double_sided, rough.unlit), (0, 1, 0));
        let leaf = Material::default().mask(0.25).double_sided(false).unlit(true).record().unwrap();
        assert_eq!((leaf.alpha_mode, leaf.cutoff), (AlphaKind::Mask as u32, 0.25));
        assert_eq!((leaf.double_sided, leaf.unlit), (0, 1));
        let ground = Material { alpha: 1.0, ..Material::shadow_catcher() }.record().unwrap();
        assert_eq!((ground.alpha_mode, ground.alpha, ground.unlit, ground.base), (2, 0.0, 2, [0.0; 3]));
        let glass =
            Material::default().blend(0.3).specular([0.5; 3]).specular_strength(0.7).record().unwrap();
        assert_eq!((glass.alpha_mode, glass.alpha), (AlphaKind::Blend as u32, 0.3));
        assert_eq!((glass.strength, glass.specular), (0.7, [0.5; 3]));
        let map = Texture { levels: 3, ..Texture::NONE };
        let mapped = Material::default().normal_map(map, 2.0).record().unwrap();
        assert_eq!((mapped.textures[MaterialRecord::NORMAL], mapped.bump), (map, 2.0));
        assert_eq!(mapped.textures[MaterialRecord::COLOR], Texture::NONE);
    }
}

//! Materials and their textures.

use super::buffer::Buffers;
use super::extensions::{LOD, TEXTURE_TRANSFORM};
use super::primitive::Coordinates;
use crate::import::builder::Builder;
use crate::import::placement::Placement;
use crate::import::{ImportError, error::quoted, picture};
use gltf_json::deserialize::from_value;
use gltf_json::extensions::material::{PbrSpecularGlossiness, Volume};
use gltf_json::extensions::texture::TextureTransform;
use gltf_json::material;
use gltf_json::texture::{self, Info, WrappingMode};
use gltf_json::validation::Checked;
use gltf_json::{Index, Root, Value, image};
use rtrt_core::layout::{COLOR_LIMIT, Filter, LIGHT_LIMIT, Texture, Wrap};
use rtrt_core::scene::{Content, Image, Join, Material, MaterialIndex};
use std::collections::HashMap;

/// The materials and textures of a file. Each is added when it is first used.
pub(super) struct Materials<'a> {
    root: &'a Root,
    buffers: &'a Buffers<'a>,
    /// The materials by index; none is the default material.
    made: HashMap<Option<usize>, (MaterialIndex, Coordinates)>,
    /// The images by index and content: mip levels of colors and of numbers are computed differently.
    /// Samplers share an image.
    images: HashMap<(usize, Content), Texture>,
}

impl<'a> Materials<'a> {
    pub fn new(root: &'a Root, buffers: &'a Buffers<'a>) -> Self {
        Self { root, buffers, made: HashMap::new(), images: HashMap::new() }
    }

    /// A material of the scene, and the sets of texture coordinates that it uses.
    pub fn get<J: Join>(
        &mut self,
        builder: &mut Builder<'_, J>,
        index: Option<Index<material::Material>>,
    ) -> Result<(MaterialIndex, Coordinates), ImportError> {
        let key = index.map(|index| index.value());
        if let Some(made) = self.made.get(&key) {
            return Ok(made.clone());
        }
        let root = self.root;
        let none = material::Material::default();
        let source = match index {
            Some(index) => {
                let number = index.value();
                root.get(index).ok_or_else(|| builder.invalid(format!("there is no material {number}")))?
            }
            None => &none,
        };
        let pbr = &source.pbr_metallic_roughness;
        let extensions = source.extensions.as_ref();
        let glossy = extensions.and_then(|e| e.pbr_specular_glossiness.as_ref());
        if glossy.is_some_and(|glossy| glossy.specular_glossiness_texture.is_some()) {
            builder.not_drawn.insert("textures of specular color and glossiness");
        }
        let (color_texture, roughness_texture) = match glossy {
            Some(glossy) => (&glossy.diffuse_texture, &None),
            None => (&pbr.base_color_texture, &pbr.metallic_roughness_texture),
        };
        let none = || Ok(None);
        // The textures with their sets of texture coordinates.
        let found = [
            color_texture.as_ref().map_or_else(none, |info| {
                self.texture(builder, info.index, base_color_content(source), &texture_use(info))
            })?,
            source.normal_texture.as_ref().map_or_else(none, |info| {
                let others = info.extensions.as_ref().and_then(|e| e.others.get(TEXTURE_TRANSFORM));
                self.texture(builder, info.index, Content::Numbers, &texture_use_of(info.tex_coord, others))
            })?,
            roughness_texture.as_ref().map_or_else(none, |info| {
                self.texture(builder, info.index, Content::Numbers, &texture_use(info))
            })?,
            source.occlusion_texture.as_ref().map_or_else(none, |info| {
                let others = info.extensions.as_ref().and_then(|e| e.others.get(TEXTURE_TRANSFORM));
                self.texture(builder, info.index, Content::Numbers, &texture_use_of(info.tex_coord, others))
            })?,
            source.emissive_texture.as_ref().map_or_else(none, |info| {
                self.texture(builder, info.index, Content::Color, &texture_use(info))
            })?,
        ];
        let mut coordinates = Coordinates::default();
        let maps = found.map(|found| {
            found.map(|(texture, set)| Texture { set: coordinates.slot(set).unwrap_or(0), ..texture })
        });
        let [base_color_map, normal_map, metallic_roughness_map, occlusion_map, emission_map] = maps;
        if found.iter().flatten().any(|(_, set)| !coordinates.sets.contains(&Some(*set))) {
            builder.not_drawn.insert("a third set of texture coordinates in one material");
        }
        coordinates.bump = normal_map.map(|map| map.set);
        if extensions.is_some_and(|e| e.others.contains_key(LOD)) {
            builder.not_drawn.insert("levels of detail of materials");
        }
        let strength = extensions.and_then(|e| e.emissive_strength.as_ref());
        let strength = strength.map_or(1.0, |strength| strength.emissive_strength.0);
        let emission =
            source.emissive_factor.0.map(|e| finite(e * strength).clamp(-LIGHT_LIMIT, LIGHT_LIMIT));
        let (base, answer) = match glossy {
            Some(glossy) => (glossy.diffuse_factor.0, specular_glossiness(glossy)),
            None => {
                let [metallic, roughness] = [pbr.metallic_factor.0, pbr.roughness_factor.0]
                    .map(|factor| finite(factor).clamp(0.0, 1.0));
                (pbr.base_color_factor.0, Material::default().metallic(metallic).roughness(roughness))
            }
        };
        let [r, g, b, a] = base.map(|c| finite(c).clamp(-COLOR_LIMIT, COLOR_LIMIT));
        let normal_scale = source
            .normal_texture
            .as_ref()
            .map_or(1.0, |info| finite(info.scale).clamp(-COLOR_LIMIT, COLOR_LIMIT));
        let occlusion_strength =
            source.occlusion_texture.as_ref().map_or(1.0, |info| finite(info.strength.0).clamp(0.0, 1.0));
        let material = answer
            .base_color([r, g, b])
            .base_color_map(base_color_map)
            .metallic_roughness_map(metallic_roughness_map)
            .normal_map(normal_map, normal_scale)
            .occlusion_map(occlusion_map, occlusion_strength)
            .emission(emission)
            .emission_map(emission_map)
            .double_sided(source.double_sided)
            .unlit(extensions.is_some_and(|e| e.unlit.is_some()));
        let material = see_through(source, a.max(0.0), material);
        let made = (builder.add_material(material)?, coordinates);
        self.made.insert(key, made.clone());
        Ok(made)
    }

    /// A texture of the scene with its sampler's wrapping, and its set of texture coordinates.
    fn texture<J: Join>(
        &mut self,
        builder: &mut Builder<'_, J>,
        index: Index<texture::Texture>,
        content: Content,
        texture_use: &TextureUse,
    ) -> Result<Option<(Texture, u32)>, ImportError> {
        let root = self.root;
        let number = index.value();
        let missing = |what: &str| builder.invalid(format!("texture {number} has no {what} that is there"));
        let texture =
            root.get(index).ok_or_else(|| builder.invalid(format!("there is no texture {number}")))?;
        let ([wrap_u, wrap_v], filter) = match texture.sampler {
            Some(index) => {
                let sampler = root.get(index).ok_or_else(|| missing("sampler"))?;
                ([sampler.wrap_s, sampler.wrap_t].map(wrap), filter(sampler))
            }
            None => ([Wrap::Repeat; 2], Filter::Linear),
        };
        let key = texture.source.value();
        // A texture may have no image; extensions then give one.
        let source = match root.get(texture.source) {
            Some(source) => Some(source),
            None if key == u32::MAX as usize => None,
            None => return Err(missing("image")),
        };
        let image = match self.images.get(&(key, content)) {
            Some(&image) => image,
            None => {
                let (name, image) = match source {
                    Some(source) => (image_name(key, source), self.image(source)),
                    None => (number.to_string(), Err("it has no PNG or JPEG image".into())),
                };
                let image = builder.add_map(&name, image, content)?;
                self.images.insert((key, content), image);
                image
            }
        };
        let texture =
            Texture { wrap_u: wrap_u as u32, wrap_v: wrap_v as u32, filter: filter as u32, ..image };
        Ok(Some((texture_use.apply(texture), texture_use.set)))
    }

    /// The picture of an image.
    ///
    /// # Errors
    /// The reason, in one line.
    fn image(&self, source: &image::Image) -> Result<Image, String> {
        match (&source.uri, source.buffer_view) {
            (Some(uri), _) => picture::decode(&self.buffers.fetch(uri)?),
            (None, Some(view)) => {
                let (bytes, _) = self.buffers.view(self.root, view).map_err(|error| error.to_string())?;
                picture::decode(bytes)
            }
            (None, None) => Err("it has neither a URI nor a buffer view".into()),
        }
    }
}

/// The name of an image in a message.
fn image_name(number: usize, image: &image::Image) -> String {
    let uri = image
        .uri
        .as_ref()
        .filter(|uri| !uri.get(..5).is_some_and(|scheme| scheme.eq_ignore_ascii_case("data:")));
    match uri.or(image.name.as_ref()) {
        Some(name) => quoted(name),
        None => number.to_string(),
    }
}

/// How a material uses a texture.
struct TextureUse {
    /// The set of texture coordinates.
    set: u32,
    /// KHR_texture_transform.
    transform: Option<TextureTransform>,
}

fn texture_use(info: &Info) -> TextureUse {
    let transform = info.extensions.as_ref().and_then(|e| e.texture_transform.clone());
    let set = transform.as_ref().and_then(|t| t.tex_coord).unwrap_or(info.tex_coord);
    TextureUse { set, transform }
}

/// The use of a texture whose extensions the JSON types do not know.
fn texture_use_of(set: u32, transform: Option<&Value>) -> TextureUse {
    let transform: Option<TextureTransform> =
        transform.and_then(|transform| from_value(transform.clone()).ok());
    let set = transform.as_ref().and_then(|t| t.tex_coord).unwrap_or(set);
    TextureUse { set, transform }
}

impl TextureUse {
    /// The texture, placed as the transform says.
    fn apply(&self, texture: Texture) -> Texture {
        let Some(transform) = &self.transform else { return texture };
        let (offset, rotation, scale) = (transform.offset.0, transform.rotation.0, transform.scale.0);
        Placement { offset, rotation, scale }.apply(texture)
    }
}

/// The filter of a sampler: its own choice between mip levels has no effect.
fn filter(sampler: &texture::Sampler) -> Filter {
    use texture::MinFilter as Min;
    let magnified = matches!(sampler.mag_filter, Some(Checked::Valid(texture::MagFilter::Nearest)));
    let minified = matches!(
        sampler.min_filter,
        Some(Checked::Valid(Min::Nearest | Min::NearestMipmapNearest | Min::NearestMipmapLinear))
    );
    match (magnified, minified) {
        (false, false) => Filter::Linear,
        (true, false) => Filter::NearestMagnified,
        (true, true) => Filter::Nearest,
        (false, true) => Filter::NearestMinified,
    }
}

fn wrap(mode: Checked<WrappingMode>) -> Wrap {
    match mode {
        Checked::Valid(WrappingMode::ClampToEdge) => Wrap::Clamp,
        Checked::Valid(WrappingMode::MirroredRepeat) => Wrap::Mirror,
        Checked::Valid(WrappingMode::Repeat) | Checked::Invalid => Wrap::Repeat,
    }
}

/// The number, or 0 if it is not finite: numbers beyond the range of `f32` are infinite, and infinity times black is NaN.
fn finite(number: f32) -> f32 {
    if number.is_finite() { number } else { 0.0 }
}

/// A material without its base color, from KHR_materials_pbrSpecularGlossiness: it is no metal, mirrors its specular
/// color, and `roughness = 1 − glossiness`.
fn specular_glossiness(glossy: &PbrSpecularGlossiness) -> Material {
    let roughness = (1.0 - finite(glossy.glossiness_factor.0)).clamp(0.0, 1.0);
    let specular = glossy.specular_factor.0.map(|c| finite(c).clamp(0.0, COLOR_LIMIT));
    Material::default().specular(specular, None).roughness(roughness)
}

/// What a texture of the base color holds: alpha hides what a mask cuts out, or what blends.
fn base_color_content(source: &material::Material) -> Content {
    match source.alpha_mode {
        Checked::Valid(material::AlphaMode::Blend | material::AlphaMode::Mask) => Content::SeeThrough,
        _ => Content::Color,
    }
}

/// The least alpha of a transmissive surface. Alpha scales highlights, too.
const CLEAREST: f32 = 0.1;

/// The material with the source's alpha. Transmission (KHR_materials_transmission) reduces it: the
/// transmitted share of light becomes the share of the background.
///
/// ```text
/// alpha · max(1 − transmission · mean(base), 0.1)
/// ```
///
/// So dark glass covers more than bright glass. The absorption of a volume (KHR_materials_volume) tints
/// the base color. Light enters and leaves a volume, so each of the two surfaces has half of it:
///
/// ```text
/// base · attenuation color ^ (thickness / (2 · attenuation distance))
/// ```
///
/// Roughness, refraction, the textures of transmission and thickness, and the scale of nodes have no
/// effect.
fn see_through(source: &material::Material, alpha: f32, material: Material) -> Material {
    use material::AlphaMode as Mode;
    let is_blend = matches!(source.alpha_mode, Checked::Valid(Mode::Blend));
    if matches!(source.alpha_mode, Checked::Valid(Mode::Mask)) {
        let cutoff =
            source.alpha_cutoff.map_or(0.5, |cutoff| finite(cutoff.0).clamp(-COLOR_LIMIT, COLOR_LIMIT));
        return material.alpha(alpha).mask(cutoff);
    }
    let transmission = source.extensions.as_ref().and_then(|e| e.transmission.as_ref());
    let transmission = transmission.map_or(0.0, |t| finite(t.transmission_factor.0).clamp(0.0, 1.0));
    if transmission == 0.0 {
        return if is_blend { material.blend(alpha) } else { material };
    }
    let volume = source.extensions.as_ref().and_then(|e| e.volume.as_ref());
    let base = material.base_color.to_array();
    let [r, g, b] = volume.map_or(base, |volume| {
        let Volume { attenuation_color, attenuation_distance, thickness_factor, .. } = volume;
        tinted(base, attenuation_color.0, thickness_factor.0, attenuation_distance.0)
    });
    let covered = (1.0 - transmission * (r + g + b) / 3.0).max(CLEAREST);
    let alpha = if is_blend { alpha } else { 1.0 };
    material.base_color([r, g, b]).blend(alpha * covered)
}

/// A base color, tinted by half of the absorption of a volume.
fn tinted(base: [f32; 3], attenuation: [f32; 3], thickness: f32, distance: f32) -> [f32; 3] {
    let ways = thickness / (2.0 * distance);
    if !(ways > 0.0 && ways.is_finite()) {
        return base;
    }
    core::array::from_fn(|i| base[i] * libm::powf(finite(attenuation[i]).clamp(0.0, 1.0), ways))
}

#[cfg(test)]
mod tests {
    use super::tinted;

    #[test]
    fn a_volume_takes_half_of_its_share_at_each_surface() {
        // A quarter of red crosses this thickness.
        let [r, g, b] = tinted([1.0, 0.5, 0.25], [0.25, 1.0, 0.0], 3.0, 3.0);
        assert!((r - 0.5).abs() < 1e-6 && g == 0.5 && b == 0.0, "{r} {g} {b}");
        for (thickness, distance) in
            [(0.0, 1.0), (2.0, f32::INFINITY), (-1.0, 1.0), (1.0, 0.0), (f32::NAN, 1.0)]
        {
            assert_eq!(tinted([0.3; 3], [0.1; 3], thickness, distance), [0.3; 3]);
        }
    }
}

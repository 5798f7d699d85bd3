//! Materials and their textures.

use super::buffer::{Buffers, of_data};
use super::extended::{Properties, Used};
use super::extensions::{ANISOTROPY, CLEARCOAT, IOR, IRIDESCENCE, LOD, SHEEN, SPECULAR, TEXTURE_TRANSFORM};
use super::primitive::Coordinates;
use crate::halves::each;
use crate::import::builder::Builder;
use crate::import::placement::Placement;
use crate::import::{ImportError, error::quoted, picture};
use glam::Vec3;
use gltf_json::deserialize::from_value;
use gltf_json::extensions::material::Volume;
use gltf_json::extensions::texture::TextureTransform;
use gltf_json::material;
use gltf_json::serialize::to_value;
use gltf_json::texture::{self, Info, WrappingMode};
use gltf_json::validation::Checked;
use gltf_json::{Index, Root, Value, image};
use rtrt_core::layout::{COLOR_LIMIT, Filter, LIGHT_LIMIT, Texture, Wrap};
use rtrt_core::scene::{
    Anisotropy, Clearcoat, Content, Image, Iridescence, Join, Material, MaterialIndex, Sheen,
};
use std::borrow::Cow;
use std::collections::{BTreeSet, HashMap, HashSet};

/// The materials and textures of a file. Each is added when it is first used.
pub(super) struct Materials<'a> {
    root: &'a Root,
    buffers: &'a Buffers<'a>,
    /// The materials by index; none is the default material.
    made: HashMap<Option<usize>, (MaterialIndex, Coordinates)>,
    /// The images by index and kind: mip levels of colors and of numbers are computed differently.
    /// Samplers share an image.
    images: HashMap<(usize, Kind), Texture>,
    /// The images that were used.
    used: HashSet<usize>,
    /// The pictures of the material that is being made, by the index of their image.
    pictures: HashMap<usize, Result<Image, String>>,
}

/// The texels of the pictures that are decoded before they are used, at most: 256 MB, and as much of their files.
const ADVANCE: u64 = 1 << 26;

/// What is made of an image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Kind {
    /// A texture as it is.
    Plain(Content),
    /// The roughness of a glossiness, which is its alpha times a factor, given by its bits.
    Glossiness { factor: u32 },
}

impl<'a> Materials<'a> {
    pub fn new(root: &'a Root, buffers: &'a Buffers<'a>) -> Self {
        Self {
            root,
            buffers,
            made: HashMap::new(),
            images: HashMap::new(),
            used: HashSet::new(),
            pictures: HashMap::new(),
        }
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
        let name = index.map_or("default".into(), |index| {
            source.name.clone().unwrap_or_else(|| format!("material {}", index.value()))
        });
        let mut coordinates = Coordinates::default();
        self.decode(builder.join, source);
        let material = self.surface(builder, source, &mut coordinates)?;
        let material = self.usual_maps(builder, source, &mut coordinates, material)?;
        let material = self.extended(builder, source, &mut coordinates, material)?;
        let slot = |map: Option<Texture>| map.map(|map| map.set);
        coordinates.bump = slot(material.normal_map)
            .or(slot(material.clearcoat.and_then(|coat| coat.normal_map)))
            .or(material.anisotropy.map(|anisotropy| slot(anisotropy.map).unwrap_or(0)));
        if source.extensions.as_ref().is_some_and(|e| e.others.contains_key(LOD)) {
            builder.not_drawn.insert("levels of detail of materials");
        }
        let made = (builder.add_material(material)?, coordinates);
        builder.name_material(name);
        self.made.insert(key, made.clone());
        Ok(made)
    }

    /// Base color, metalness, roughness and alpha of a material, with their maps.
    fn surface<J: Join>(
        &mut self,
        builder: &mut Builder<'_, J>,
        source: &material::Material,
        coordinates: &mut Coordinates,
    ) -> Result<Material, ImportError> {
        let pbr = &source.pbr_metallic_roughness;
        let glossy = source.extensions.as_ref().and_then(|e| e.pbr_specular_glossiness.as_ref());
        let Some(glossy) = glossy else {
            let [r, g, b, a] = pbr.base_color_factor.0.map(base_channel);
            let [metallic, roughness] =
                [pbr.metallic_factor.0, pbr.roughness_factor.0].map(|factor| finite(factor).clamp(0.0, 1.0));
            let color =
                self.map(builder, coordinates, pbr.base_color_texture.as_ref(), base_color_content(source))?;
            let roughness_map =
                self.map(builder, coordinates, pbr.metallic_roughness_texture.as_ref(), Content::Numbers)?;
            let material = Material::new([r, g, b])
                .base_color_map(color)
                .metallic(metallic)
                .roughness(roughness)
                .metallic_roughness_map(roughness_map);
            let clear = self.transmission_map(builder, source, coordinates)?;
            return Ok(see_through(source, a.max(0.0), clear, material));
        };
        // It is no metal, mirrors its specular color, and `roughness = 1 − glossiness`.
        let [r, g, b, a] = glossy.diffuse_factor.0.map(base_channel);
        let glossiness = finite(glossy.glossiness_factor.0).clamp(0.0, 1.0);
        let specular = glossy.specular_factor.0.map(|c| finite(c).clamp(0.0, COLOR_LIMIT));
        let color =
            self.map(builder, coordinates, glossy.diffuse_texture.as_ref(), base_color_content(source))?;
        let mut material =
            Material::new([r, g, b]).base_color_map(color).specular(specular).roughness(1.0 - glossiness);
        if let Some(info) = &glossy.specular_glossiness_texture {
            let map = self.map(builder, coordinates, Some(info), Content::Color)?;
            let found = self.texture(
                builder,
                info.index,
                Kind::Glossiness { factor: glossiness.to_bits() },
                &TextureUse::of(info),
            )?;
            let roughness = self.placed(builder, coordinates, found);
            material = material.specular_maps(None, map).roughness(1.0).metallic_roughness_map(roughness);
        }
        let clear = self.transmission_map(builder, source, coordinates)?;
        Ok(see_through(source, a.max(0.0), clear, material))
    }

    /// The map of transmission. Says what of glass is approximated.
    fn transmission_map<J: Join>(
        &mut self,
        builder: &mut Builder<'_, J>,
        source: &material::Material,
        coordinates: &mut Coordinates,
    ) -> Result<Option<Texture>, ImportError> {
        let extensions = source.extensions.as_ref();
        let Some(transmission) = extensions.and_then(|e| e.transmission.as_ref()) else { return Ok(None) };
        if transmission.transmission_factor.0 <= 0.0 {
            return Ok(None);
        }
        if has_thickness(source) {
            builder.not_drawn.insert("refraction of what is behind glass, but for the environment");
        }
        let pbr = &source.pbr_metallic_roughness;
        if pbr.roughness_factor.0 > 0.1 {
            builder.not_drawn.insert("the blur of what is behind rough glass, but for the environment");
        }
        self.map(builder, coordinates, transmission.transmission_texture.as_ref(), Content::Numbers)
    }

    /// The material with the maps of normals, occlusion and emission.
    fn usual_maps<J: Join>(
        &mut self,
        builder: &mut Builder<'_, J>,
        source: &material::Material,
        coordinates: &mut Coordinates,
        material: Material,
    ) -> Result<Material, ImportError> {
        let (mut normal, mut occlusion) = (None, None);
        if let Some(info) = &source.normal_texture {
            let others = info.extensions.as_ref().and_then(|e| e.others.get(TEXTURE_TRANSFORM));
            let used = texture_use_of(info.tex_coord, others);
            let found = self.texture(builder, info.index, Kind::Plain(Content::Normals), &used)?;
            normal = self.placed(builder, coordinates, found);
        }
        if let Some(info) = &source.occlusion_texture {
            let others = info.extensions.as_ref().and_then(|e| e.others.get(TEXTURE_TRANSFORM));
            let used = texture_use_of(info.tex_coord, others);
            let found = self.texture(builder, info.index, Kind::Plain(Content::Numbers), &used)?;
            occlusion = self.placed(builder, coordinates, found);
        }
        let emission_map =
            self.map(builder, coordinates, source.emissive_texture.as_ref(), Content::Color)?;
        let extensions = source.extensions.as_ref();
        let strength = extensions.and_then(|e| e.emissive_strength.as_ref());
        let strength = strength.map_or(1.0, |strength| strength.emissive_strength.0);
        let emission =
            source.emissive_factor.0.map(|e| finite(e * strength).clamp(-LIGHT_LIMIT, LIGHT_LIMIT));
        let normal_scale = source
            .normal_texture
            .as_ref()
            .map_or(1.0, |info| finite(info.scale).clamp(-COLOR_LIMIT, COLOR_LIMIT));
        let occlusion_strength =
            source.occlusion_texture.as_ref().map_or(1.0, |info| finite(info.strength.0).clamp(0.0, 1.0));
        Ok(material
            .normal_map(normal, normal_scale)
            .occlusion_map(occlusion, occlusion_strength)
            .emission(emission)
            .emission_map(emission_map)
            .double_sided(source.double_sided || material.refraction > 1.0)
            .unlit(extensions.is_some_and(|e| e.unlit.is_some())))
    }

    /// The material with what its extensions add.
    fn extended<J: Join>(
        &mut self,
        builder: &mut Builder<'_, J>,
        source: &material::Material,
        coordinates: &mut Coordinates,
        mut material: Material,
    ) -> Result<Material, ImportError> {
        let of = |name| Properties::of(source.extensions.as_ref(), name);
        let mut map = |builder: &mut Builder<'_, J>, used: Option<Used>, content| match used {
            Some(used) => {
                let found = self.texture(builder, used.index, Kind::Plain(content), &used.texture_use)?;
                Ok::<_, ImportError>(self.placed(builder, coordinates, found))
            }
            None => Ok(None),
        };
        if let Some(p) = of(IOR) {
            let ior = p.number("ior", 1.5, [0.0, 1e6]);
            let ratio = (ior - 1.0) / (ior + 1.0);
            material = material.specular([ratio * ratio; 3]);
            if material.refraction > 1.0 {
                material = material.refraction(ior.clamp(1.0, 8.0));
            }
        }
        if let Some(p) = of(SPECULAR) {
            let color = p.color("specularColorFactor", 1.0, COLOR_LIMIT);
            let strength_map = map(builder, p.texture("specularTexture"), Content::Color)?;
            let color_map = map(builder, p.texture("specularColorTexture"), Content::Color)?;
            material = material
                .specular(material.specular * Vec3::from(color))
                .specular_strength(p.share("specularFactor", 1.0))
                .specular_maps(strength_map, color_map);
        }
        if let Some(p) = of(CLEARCOAT) {
            let normal = p.texture("clearcoatNormalTexture");
            let coat = Clearcoat {
                share: p.share("clearcoatFactor", 0.0),
                map: map(builder, p.texture("clearcoatTexture"), Content::Numbers)?,
                roughness: p.share("clearcoatRoughnessFactor", 0.0),
                roughness_map: map(builder, p.texture("clearcoatRoughnessTexture"), Content::Numbers)?,
                normal_scale: normal.as_ref().map_or(1.0, |normal| normal.scale),
                normal_map: map(builder, normal, Content::Normals)?,
            };
            material = material.clearcoat(Some(coat).filter(|coat| coat.share > 0.0));
        }
        if let Some(p) = of(SHEEN) {
            let sheen = Sheen {
                color: p.color("sheenColorFactor", 0.0, 1.0).into(),
                color_map: map(builder, p.texture("sheenColorTexture"), Content::Color)?,
                roughness: p.share("sheenRoughnessFactor", 0.0),
                roughness_map: map(builder, p.texture("sheenRoughnessTexture"), Content::Color)?,
            };
            material = material.sheen(Some(sheen).filter(|sheen| sheen.color != Vec3::ZERO));
        }
        if let Some(p) = of(ANISOTROPY) {
            let anisotropy = Anisotropy {
                strength: p.share("anisotropyStrength", 0.0),
                rotation: p.number("anisotropyRotation", 0.0, [-1e6, 1e6]),
                map: map(builder, p.texture("anisotropyTexture"), Content::Numbers)?,
            };
            material = material.anisotropy(Some(anisotropy).filter(|a| a.strength > 0.0));
        }
        if let Some(p) = of(IRIDESCENCE) {
            let nanometers = [0.0, 65_536.0];
            let film = Iridescence {
                share: p.share("iridescenceFactor", 0.0),
                map: map(builder, p.texture("iridescenceTexture"), Content::Numbers)?,
                ior: p.number("iridescenceIor", 1.3, [1.0, 8.0]),
                thickness: [
                    p.number("iridescenceThicknessMinimum", 100.0, nanometers),
                    p.number("iridescenceThicknessMaximum", 400.0, nanometers),
                ],
                thickness_map: map(builder, p.texture("iridescenceThicknessTexture"), Content::Numbers)?,
            };
            material = material.iridescence(Some(film).filter(|film| film.share > 0.0));
        }
        Ok(material)
    }

    /// A map of a material.
    fn map<J: Join>(
        &mut self,
        builder: &mut Builder<'_, J>,
        coordinates: &mut Coordinates,
        info: Option<&Info>,
        content: Content,
    ) -> Result<Option<Texture>, ImportError> {
        let Some(info) = info else { return Ok(None) };
        let found = self.texture(builder, info.index, Kind::Plain(content), &TextureUse::of(info))?;
        Ok(self.placed(builder, coordinates, found))
    }

    /// The texture with the slot of its set of texture coordinates.
    fn placed<J: Join>(
        &self,
        builder: &mut Builder<'_, J>,
        coordinates: &mut Coordinates,
        (texture, set): (Texture, u32),
    ) -> Option<Texture> {
        let slot = coordinates.slot(set);
        if slot.is_none() {
            builder.not_drawn.insert("a third set of texture coordinates in one material");
        }
        Some(Texture { set: slot.unwrap_or(0), ..texture })
    }

    /// A texture of the scene with its sampler's wrapping, and its set of texture coordinates.
    fn texture<J: Join>(
        &mut self,
        builder: &mut Builder<'_, J>,
        index: Index<texture::Texture>,
        kind: Kind,
        texture_use: &TextureUse,
    ) -> Result<(Texture, u32), ImportError> {
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
        let image = match self.images.get(&(key, kind)) {
            Some(&image) => image,
            None => {
                let (name, image) = match source {
                    Some(source) => (image_name(key, source), self.picture(key, source)),
                    None => (number.to_string(), Err("it has no image that is read".into())),
                };
                let image = match kind {
                    Kind::Plain(content) => builder.add_map(&name, image, content)?,
                    Kind::Glossiness { factor } => {
                        let image = image.map(|image| roughness(image, f32::from_bits(factor)));
                        builder.add_map(&name, image, Content::Numbers)?
                    }
                };
                self.images.insert((key, kind), image);
                image
            }
        };
        let texture =
            Texture { wrap_u: wrap_u as u32, wrap_v: wrap_v as u32, filter: filter as u32, ..image };
        Ok((texture_use.apply(texture), texture_use.set))
    }

    /// Decodes the images that a material names and no other has used, in parallel if there are threads. What would need
    /// much memory, or cannot be read, is left for its first use.
    fn decode<J: Join>(&mut self, join: &J, source: &material::Material) {
        self.pictures.clear();
        let mut textures = BTreeSet::new();
        if let Ok(source) = to_value(source) {
            textures_in(&source, &mut textures);
        }
        let image = |texture: usize| self.root.textures.get(texture).map(|texture| texture.source.value());
        let mut images: BTreeSet<usize> = textures.into_iter().filter_map(image).collect();
        images.retain(|index| !self.used.contains(index));
        let mut room = ADVANCE;
        let read = |index: usize| {
            let bytes = self.bytes(self.root.images.get(index)?).ok()?;
            room = room.checked_sub(picture::texels(&bytes)?.max(bytes.len() as u64 / 4))?;
            Some((index, bytes))
        };
        let bytes: Vec<_> = images.into_iter().filter_map(read).collect();
        let decoded = each(join, &bytes, &|(index, bytes)| (*index, picture::decode(bytes)));
        self.pictures = decoded.into_iter().collect();
    }

    /// The picture of an image with this index.
    ///
    /// # Errors
    /// The reason, in one line.
    fn picture(&mut self, index: usize, source: &image::Image) -> Result<Image, String> {
        // One that is used a second time, as another kind, is decoded again.
        self.used.insert(index);
        self.pictures.remove(&index).unwrap_or_else(|| picture::decode(&self.bytes(source)?))
    }

    /// The bytes of an image.
    ///
    /// # Errors
    /// The reason, in one line.
    fn bytes(&self, source: &image::Image) -> Result<Cow<'_, [u8]>, String> {
        match (&source.uri, source.buffer_view) {
            (Some(uri), _) => self.buffers.fetch(uri).map(Cow::Owned),
            (None, Some(view)) => {
                let (bytes, _) = self.buffers.view(self.root, view).map_err(|error| error.to_string())?;
                Ok(Cow::Borrowed(bytes))
            }
            (None, None) => Err("it has neither a URI nor a buffer view".into()),
        }
    }
}

/// The textures that a part of a material names, that of an extension too.
fn textures_in(part: &Value, textures: &mut BTreeSet<usize>) {
    let Value::Object(members) = part else { return };
    for (name, member) in members {
        if name.to_ascii_lowercase().ends_with("texture") {
            let index = member.get("index").and_then(Value::as_u64);
            textures.extend(index.and_then(|index| usize::try_from(index).ok()));
        }
        textures_in(member, textures);
    }
}

/// The name of an image in a message.
fn image_name(number: usize, image: &image::Image) -> String {
    let uri = image.uri.as_ref().filter(|uri| of_data(uri).is_none());
    match uri.or(image.name.as_ref()) {
        Some(name) => quoted(name),
        None => number.to_string(),
    }
}

/// The image of roughness (green) whose surfaces are no metal (blue), of one of glossiness (alpha).
fn roughness(image: Image, factor: f32) -> Image {
    let of = |glossiness: u8| 255 - (f32::from(glossiness) * factor + 0.5) as u8;
    let rgba = image.rgba.chunks_exact(4).flat_map(|texel| [255, of(texel[3]), 0, 255]).collect();
    Image { rgba, ..image }
}

/// How a material uses a texture.
pub(super) struct TextureUse {
    /// The set of texture coordinates.
    set: u32,
    /// KHR_texture_transform.
    transform: Option<TextureTransform>,
}

/// The use of a texture whose extensions the JSON types do not know.
fn texture_use_of(set: u32, transform: Option<&Value>) -> TextureUse {
    let transform: Option<TextureTransform> =
        transform.and_then(|transform| from_value(transform.clone()).ok());
    let set = transform.as_ref().and_then(|t| t.tex_coord).unwrap_or(set);
    TextureUse { set, transform }
}

impl TextureUse {
    pub(super) fn of(info: &Info) -> Self {
        let transform = info.extensions.as_ref().and_then(|e| e.texture_transform.clone());
        let set = transform.as_ref().and_then(|t| t.tex_coord).unwrap_or(info.tex_coord);
        Self { set, transform }
    }

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

/// A channel of a base color, or its alpha.
fn base_channel(channel: f32) -> f32 {
    finite(channel).clamp(-COLOR_LIMIT, COLOR_LIMIT)
}

/// What a texture of the base color holds: alpha hides what a mask cuts out, or what blends.
fn base_color_content(source: &material::Material) -> Content {
    match source.alpha_mode {
        Checked::Valid(material::AlphaMode::Blend | material::AlphaMode::Mask) => Content::SeeThrough,
        _ => Content::Color,
    }
}

/// The material with the source's alpha and transmission (KHR_materials_transmission): a thin pane, tinted by the
/// base color. The absorption of a volume (KHR_materials_volume) tints it, too. Light enters and leaves a volume, so
/// each of the two surfaces has half of it:
///
/// ```text
/// base · attenuation color ^ (thickness / (2 · attenuation distance))
/// ```
///
/// The surfaces of a volume bound a body: rays meet both of its sides, whatever the material says of them (the
/// extension asks that of ray tracers), and light turns by the index of refraction, 1.5 without KHR_materials_ior.
/// The texture of thickness and the scale of nodes have no effect.
fn see_through(
    source: &material::Material,
    alpha: f32,
    map: Option<Texture>,
    material: Material,
) -> Material {
    use material::AlphaMode as Mode;
    if matches!(source.alpha_mode, Checked::Valid(Mode::Mask)) {
        let cutoff =
            source.alpha_cutoff.map_or(0.5, |cutoff| finite(cutoff.0).clamp(-COLOR_LIMIT, COLOR_LIMIT));
        return material.alpha(alpha).mask(cutoff);
    }
    let is_blend = matches!(source.alpha_mode, Checked::Valid(Mode::Blend));
    let material = if is_blend { material.blend(alpha) } else { material };
    let transmission = source.extensions.as_ref().and_then(|e| e.transmission.as_ref());
    let transmission = transmission.map_or(0.0, |t| finite(t.transmission_factor.0).clamp(0.0, 1.0));
    if transmission == 0.0 {
        return material;
    }
    let volume = source.extensions.as_ref().and_then(|e| e.volume.as_ref());
    let base = material.base_color.to_array();
    let base = volume.map_or(base, |volume| {
        let Volume { attenuation_color, attenuation_distance, thickness_factor, .. } = volume;
        tinted(base, attenuation_color.0, thickness_factor.0, attenuation_distance.0)
    });
    let material = material.base_color(base).transmission(transmission, map);
    if has_thickness(source) { material.refraction(1.5) } else { material }
}

/// Whether the surfaces of a material bound a body.
fn has_thickness(source: &material::Material) -> bool {
    let volume = source.extensions.as_ref().and_then(|e| e.volume.as_ref());
    volume.is_some_and(|volume| volume.thickness_factor.0 > 0.0)
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
    use super::{roughness, textures_in, tinted};
    use gltf_json::deserialize::from_str;
    use gltf_json::material::Material;
    use gltf_json::serialize::to_value;
    use rtrt_core::scene::Image;
    use std::collections::BTreeSet;

    #[test]
    fn textures_of_extensions_are_found() {
        let material: Material = from_str(
            r#"{
                "normalTexture": { "index": 3 },
                "pbrMetallicRoughness": { "baseColorTexture": { "index": 0, "texCoord": 9 } },
                "extensions": {
                    "KHR_materials_clearcoat": { "clearcoatNormalTexture": { "index": 7 }, "clearcoatFactor": 8 },
                    "KHR_materials_unlit": {}
                },
                "extras": { "index": 5 }
            }"#,
        )
        .unwrap();
        let mut textures = BTreeSet::new();
        textures_in(&to_value(material).unwrap(), &mut textures);
        assert_eq!(textures.into_iter().collect::<Vec<_>>(), [0, 3, 7]);
    }

    #[test]
    fn roughness_is_what_glossiness_leaves() {
        let glossy = Image { width: 2, height: 1, rgba: vec![9, 9, 9, 255, 9, 9, 9, 100] };
        assert_eq!(roughness(glossy.clone(), 1.0).rgba, [255, 0, 0, 255, 255, 155, 0, 255]);
        assert_eq!(roughness(glossy, 0.5).rgba, [255, 127, 0, 255, 255, 205, 0, 255]);
    }

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

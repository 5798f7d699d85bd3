//! Materials and their textures.

use super::buffer::{Buffers, fetch};
use super::primitive::Coordinates;
use crate::import::builder::Builder;
use crate::import::{ImportError, error::quoted, file, picture};
use gltf_json::material::AlphaMode;
use gltf_json::texture::{Info, WrappingMode};
use gltf_json::validation::Checked;
use gltf_json::{Index, Root, image, material};
use rtrt_core::layout::{Texture, Wrap};
use rtrt_core::scene::{Image, Join, MaterialIndex, phong};
use std::collections::HashMap;

/// The roughness of a material that has a texture for it: textures are not looked up for
/// roughness and metalness, and this with no metal at all suits most surfaces.
const USUAL_ROUGHNESS: f32 = 0.6;

/// The materials and textures of a file, made when they are first used.
pub(super) struct Materials<'a> {
    root: &'a Root,
    buffers: &'a Buffers<'a>,
    /// By index; none is the default material.
    made: HashMap<Option<usize>, (MaterialIndex, Coordinates)>,
    /// By index. One image is stored once, whatever its samplers.
    images: HashMap<usize, Texture>,
}

impl<'a> Materials<'a> {
    pub fn new(root: &'a Root, buffers: &'a Buffers<'a>) -> Self {
        Self { root, buffers, made: HashMap::new(), images: HashMap::new() }
    }

    /// A material of the scene, and how its base color is looked up.
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
        let (texture, coordinates) = match &pbr.base_color_texture {
            Some(info) => (self.texture(builder, info)?, coordinates(info)),
            None => (Texture::NONE, Coordinates::default()),
        };
        let (metallic, roughness) = match pbr.metallic_roughness_texture {
            Some(_) => (0.0, USUAL_ROUGHNESS),
            None => (pbr.metallic_factor.0, pbr.roughness_factor.0),
        };
        let strength = source.extensions.as_ref().and_then(|e| e.emissive_strength.as_ref());
        let strength = strength.map_or(1.0, |strength| strength.emissive_strength.0);
        let emission = match source.emissive_texture {
            Some(_) => [0.0; 3],
            None => source.emissive_factor.0.map(|e| finite(e * strength)),
        };
        let [r, g, b, _] = pbr.base_color_factor.0.map(finite);
        let material = phong([r, g, b], metallic, roughness, texture, emission);
        note_what_is_not_drawn(builder, source);
        let made = (builder.scene.add_material(material), coordinates);
        self.made.insert(key, made.clone());
        Ok(made)
    }

    /// A texture of the scene with its sampler's wrapping.
    fn texture<J: Join>(
        &mut self,
        builder: &mut Builder<'_, J>,
        info: &Info,
    ) -> Result<Texture, ImportError> {
        let root = self.root;
        let number = info.index.value();
        let missing = |what: &str| builder.invalid(format!("texture {number} has no {what} that is there"));
        let texture =
            root.get(info.index).ok_or_else(|| builder.invalid(format!("there is no texture {number}")))?;
        let [wrap_u, wrap_v] = match texture.sampler {
            Some(index) => {
                let sampler = root.get(index).ok_or_else(|| missing("sampler"))?;
                [sampler.wrap_s, sampler.wrap_t].map(wrap)
            }
            None => [Wrap::Repeat; 2],
        };
        let key = texture.source.value();
        // The format lets a texture be without an image, for extensions to fill in.
        let source = match root.get(texture.source) {
            Some(source) => Some(source),
            None if key == u32::MAX as usize => None,
            None => return Err(missing("image")),
        };
        let image = match self.images.get(&key) {
            Some(&image) => image,
            None => {
                let (name, image) = match source {
                    Some(source) => (image_name(key, source), self.image(source)),
                    None => (number.to_string(), Err("it has no PNG or JPEG image".into())),
                };
                let image = builder.add_texture(&name, image)?;
                self.images.insert(key, image);
                image
            }
        };
        Ok(Texture { wrap_u: wrap_u as u32, wrap_v: wrap_v as u32, ..image })
    }

    /// # Errors
    /// What is wrong with it, in one line.
    fn image(&self, source: &image::Image) -> Result<Image, String> {
        match (&source.uri, source.buffer_view) {
            (Some(uri), _) => picture::decode(&fetch(self.buffers.path, uri, file::LONGEST)?),
            (None, Some(view)) => {
                let (bytes, _) = self.buffers.view(self.root, view).map_err(|error| error.to_string())?;
                picture::decode(bytes)
            }
            (None, None) => Err("it has neither a URI nor a buffer view".into()),
        }
    }
}

/// What to call an image in a message.
fn image_name(number: usize, image: &image::Image) -> String {
    let uri = image.uri.as_ref().filter(|uri| !uri.starts_with("data:"));
    match uri.or(image.name.as_ref()) {
        Some(name) => quoted(name),
        None => number.to_string(),
    }
}

fn coordinates(info: &Info) -> Coordinates {
    let transform = info.extensions.as_ref().and_then(|e| e.texture_transform.clone());
    let set = transform.as_ref().and_then(|t| t.tex_coord).unwrap_or(info.tex_coord);
    Coordinates { set: Some(set), transform }
}

fn wrap(mode: Checked<WrappingMode>) -> Wrap {
    match mode {
        Checked::Valid(WrappingMode::ClampToEdge) => Wrap::Clamp,
        Checked::Valid(WrappingMode::MirroredRepeat) => Wrap::Mirror,
        Checked::Valid(WrappingMode::Repeat) | Checked::Invalid => Wrap::Repeat,
    }
}

/// Numbers too large for 32 bits are infinite; they would make NaN of black.
fn finite(number: f32) -> f32 {
    if number.is_finite() { number } else { 0.0 }
}

fn note_what_is_not_drawn<J: Join>(builder: &mut Builder<'_, J>, source: &material::Material) {
    let mut note = |is: bool, what| {
        if is {
            builder.not_drawn.insert(what);
        }
    };
    note(source.alpha_mode == Checked::Valid(AlphaMode::Mask), "alpha masks");
    note(source.alpha_mode == Checked::Valid(AlphaMode::Blend), "transparency");
    note(source.emissive_texture.is_some(), "emission textures");
    note(source.normal_texture.is_some(), "normal maps");
    note(source.pbr_metallic_roughness.metallic_roughness_texture.is_some(), "roughness textures");
    let Some(extensions) = &source.extensions else { return };
    note(extensions.unlit.is_some(), "materials without lighting");
    let has = |name: &str| extensions.others.contains_key(name);
    note(has("KHR_materials_transmission"), "transmission");
    note(has("KHR_materials_pbrSpecularGlossiness"), "specular-glossiness materials");
}

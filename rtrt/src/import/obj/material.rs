//! The materials of an OBJ file in the scene.

use super::mtl::{self, MapReference, Maps, MtlMaterial};
use super::text;
use super::texture::{self, Channel};
use crate::import::builder::Builder;
use crate::import::error::quoted;
use crate::import::placement::Placement;
use crate::import::{ImportError, file, picture};
use glam::Vec3;
use rtrt_core::layout::{Texture, Wrap};
use rtrt_core::scene::{AlphaMode, Clearcoat, Content, Image, Join, Material, MaterialIndex, Sheen};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// The most words of an `mtllib` line that may belong to names with blanks.
const MOST_WORDS: usize = 32;
/// The limit of libraries.
const MOST_LIBRARIES: usize = 1024;

/// The materials of all libraries, and the textures that were added.
pub(super) struct Materials {
    /// By name, with the library.
    by_name: HashMap<String, Source>,
    /// By the files that they are made from, and their use.
    textures: HashMap<(Vec<PathBuf>, Use), (Texture, AlphaMode)>,
}

/// A material, and the file that it stands in.
#[derive(Clone)]
pub(super) struct Source {
    material: MtlMaterial,
    library: PathBuf,
}

/// What a texture is used for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Use {
    Color,
    Emission,
    Normal,
    Roughness,
}

impl Materials {
    /// Reads the libraries that `mtllib` lines name. Of two materials with the same name, the first counts.
    pub fn new<J: Join>(builder: &mut Builder<'_, J>, lines: &[String]) -> Self {
        let mut by_name = HashMap::new();
        let names: Vec<String> = lines.iter().flat_map(|line| library_names(&builder.path, line)).collect();
        if names.len() > MOST_LIBRARIES {
            builder.warn(format!("only the first {MOST_LIBRARIES} material libraries are read"));
        }
        for name in names.into_iter().take(MOST_LIBRARIES) {
            let library = builder.files.beside(&[&builder.path], &name);
            match builder.files.read(&library, file::LONGEST) {
                Ok(bytes) => {
                    for material in mtl::parse(&text::utf8(&bytes)) {
                        let source = Source { material, library: library.clone() };
                        by_name.entry(source.material.name.clone()).or_insert(source);
                    }
                }
                Err(error) => builder.warn(format!("material library {}: {error}", quoted(&name))),
            }
        }
        Self { by_name, textures: HashMap::new() }
    }

    /// The material with this name.
    pub fn find(&self, name: &str) -> Option<Source> {
        self.by_name.get(name).cloned()
    }

    /// Adds a material to the scene. Without a source it is dull, and gray unless vertices have colors. Also says whether
    /// it has a normal map.
    pub fn add<J: Join>(
        &mut self,
        builder: &mut Builder<'_, J>,
        source: Option<&Source>,
        has_vertex_colors: bool,
    ) -> Result<(MaterialIndex, bool), ImportError> {
        let Some(Source { material: source, library }) = source else {
            let base = if has_vertex_colors { 1.0 } else { 0.7 };
            let dull = builder.add_material(Material::new([base; 3]).roughness(0.8))?;
            return Ok((dull, false));
        };
        builder.not_drawn.extend(&source.not_drawn);
        let (color, alpha_mode) = self.color(builder, library, &source.maps)?;
        let emission = self.plain(builder, library, source.maps.emission.as_ref(), Use::Emission)?;
        let roughness = self.roughness(builder, library, &source.maps)?;
        let bump = source.maps.normal.as_ref().or(source.maps.bump.as_ref());
        let normal = self.plain(builder, library, bump, Use::Normal)?;
        let material = answer(source, emission.is_some())
            .base_color_map(color)
            .metallic_roughness_map(roughness)
            .emission_map(emission)
            .normal_map(normal, bump.map_or(1.0, |map| map.strength));
        let material = match alpha_mode {
            _ if source.alpha < 1.0 => material.blend(source.alpha),
            AlphaMode::Blend => material.blend(1.0),
            AlphaMode::Mask { cutoff } => material.mask(cutoff),
            AlphaMode::Opaque | AlphaMode::Shadows => material,
        };
        Ok((builder.add_material(material)?, normal.is_some()))
    }

    /// The texture of the base color and of alpha, and what its alpha does.
    fn color<J: Join>(
        &mut self,
        builder: &mut Builder<'_, J>,
        library: &Path,
        maps: &Maps,
    ) -> Result<(Option<Texture>, AlphaMode), ImportError> {
        let Maps { diffuse, alpha, .. } = maps;
        let Some(place) = diffuse.as_ref().or(alpha.as_ref()) else {
            return Ok((None, AlphaMode::Opaque));
        };
        if let (Some(diffuse), Some(alpha)) = (diffuse, alpha)
            && (diffuse.offset, diffuse.scale) != (alpha.offset, alpha.scale)
        {
            builder.not_drawn.insert("a map_d of MTL that lies elsewhere than its map_Kd");
        }
        let paths: Vec<_> =
            [diffuse, alpha].map(|map| map.as_ref().map(|map| path(builder, library, map))).into();
        let key = (paths.iter().flatten().cloned().collect::<Vec<_>>(), Use::Color);
        let (texture, mode) = match self.textures.get(&key) {
            Some(&known) => known,
            None => {
                let mask = match (alpha, &paths[1]) {
                    (Some(map), Some(path)) => read(builder, map, path),
                    _ => None,
                };
                let color = match (diffuse, &paths[0]) {
                    (Some(map), Some(path)) => decode(builder, path).map_err(|why| (map.file.clone(), why)),
                    _ => Ok(Image { width: 1, height: 1, rgba: vec![255; 4] }),
                };
                let image = match (color, &mask, alpha) {
                    (Ok(color), Some(mask), Some(map)) => {
                        Ok(texture::with_alpha(&color, mask, Channel::of(map.channel, mask, true)))
                    }
                    (color, ..) => color,
                };
                let mode = match &image {
                    Ok(image) if !texture::has_alpha(image) => AlphaMode::Opaque,
                    Ok(image) if texture::is_cutout(image) => AlphaMode::Mask { cutoff: 0.5 },
                    Ok(_) => AlphaMode::Blend,
                    Err(_) => AlphaMode::Opaque,
                };
                let name = quoted(&place.file);
                let content = if mode == AlphaMode::Opaque { Content::Color } else { Content::SeeThrough };
                let added = builder.add_map(&name, image.map_err(|(_, why)| why), content)?;
                self.textures.insert(key, (added, mode));
                (added, mode)
            }
        };
        Ok((Some(placed(texture, place)), mode))
    }

    /// The texture of roughness and metalness.
    fn roughness<J: Join>(
        &mut self,
        builder: &mut Builder<'_, J>,
        library: &Path,
        maps: &Maps,
    ) -> Result<Option<Texture>, ImportError> {
        let sources = [&maps.roughness, &maps.metallic];
        let Some(place) = sources[0].as_ref().or(sources[1].as_ref()) else { return Ok(None) };
        let paths = sources.map(|map| map.as_ref().map(|map| path(builder, library, map)));
        // The place in the key says which of the two a single file is.
        let key = (paths.iter().map(|path| path.clone().unwrap_or_default()).collect(), Use::Roughness);
        let texture = match self.textures.get(&key) {
            Some(&(known, _)) => known,
            None => {
                let mut images = [None, None];
                for ((image, map), path) in images.iter_mut().zip(sources).zip(&paths) {
                    if let (Some(map), Some(path)) = (map, path) {
                        *image = read(builder, map, path)
                            .map(|image| (Channel::of(map.channel, &image, false), image));
                    }
                }
                let [roughness, metalness] =
                    images.each_ref().map(|image| image.as_ref().map(|(channel, image)| (image, *channel)));
                if roughness.is_none() && metalness.is_none() {
                    return Ok(None);
                }
                let image = texture::roughness_and_metalness(roughness, metalness);
                let added = builder.add_map(&quoted(&place.file), Ok(image), Content::Numbers)?;
                self.textures.insert(key, (added, AlphaMode::Opaque));
                added
            }
        };
        Ok(Some(placed(texture, place)))
    }

    /// A texture that is used as it is. A normal map that cannot be read or is none is left out with a warning.
    fn plain<J: Join>(
        &mut self,
        builder: &mut Builder<'_, J>,
        library: &Path,
        map: Option<&MapReference>,
        used: Use,
    ) -> Result<Option<Texture>, ImportError> {
        let Some(map) = map else { return Ok(None) };
        let path = path(builder, library, map);
        let key = (vec![path], used);
        let texture = match self.textures.get(&key) {
            Some(&(known, _)) => known,
            None => {
                let Some(image) = read(builder, map, &key.0[0]) else { return Ok(None) };
                if used == Use::Normal && !texture::is_normal_map(&image) {
                    builder.not_drawn.insert("heights in map_Bump of MTL");
                    return Ok(None);
                }
                let content = if used == Use::Normal { Content::Normals } else { Content::Color };
                let added = builder.add_map(&quoted(&map.file), Ok(image), content)?;
                self.textures.insert(key, (added, AlphaMode::Opaque));
                added
            }
        };
        Ok(Some(placed(texture, map)))
    }
}

/// The files that an `mtllib` line names: one whose name has blanks, or several. Blanks belong to a name if a file of
/// that name exists.
fn library_names(obj: &Path, line: &str) -> Vec<String> {
    let words: Vec<&str> = line.split_whitespace().collect();
    if words.len() > MOST_WORDS {
        return words.into_iter().map(str::to_owned).collect();
    }
    let starts: Vec<usize> =
        words.iter().map(|word| word.as_ptr() as usize - line.as_ptr() as usize).collect();
    let name = |from: usize, to: usize| {
        let end = starts.get(to).copied().unwrap_or(line.len());
        line[starts[from]..end].trim_end()
    };
    let (mut names, mut at, mut found_any) = (Vec::new(), 0, false);
    while at < words.len() {
        let exists = |end: &usize| file::relative(obj, name(at, *end)).is_file();
        let end = (at + 1..=words.len()).rev().find(exists);
        found_any |= end.is_some();
        let end = end.unwrap_or(at + 1);
        names.push(name(at, end).to_owned());
        at = end;
    }
    if found_any { names } else { vec![line.to_owned()] }
}

/// The file of a texture: beside the library, else beside the scene.
fn path<J: Join>(builder: &Builder<'_, J>, library: &Path, map: &MapReference) -> PathBuf {
    builder.files.beside(&[library, &builder.path], &map.file)
}

fn decode<J: Join>(builder: &Builder<'_, J>, path: &Path) -> Result<Image, String> {
    let bytes = builder.files.read(path, file::LONGEST).map_err(|error| error.to_string())?;
    picture::decode(&bytes)
}

/// The image of a texture; none, with a warning, if it cannot be read.
fn read<J: Join>(builder: &mut Builder<'_, J>, map: &MapReference, path: &Path) -> Option<Image> {
    let image = decode(builder, path);
    let why = image.as_ref().err().cloned();
    if let Some(why) = why {
        builder.warn(format!("texture {} is left out: {why}", quoted(&map.file)));
    }
    image.ok()
}

/// The texture with the options of a reference.
///
/// ```text
/// (u, v) of OBJ  →  s · (u, v) + o
/// ```
///
/// The `v` of OBJ points up and that of textures down: `1 − v  →  1 − (s · v + o)`.
fn placed(texture: Texture, map: &MapReference) -> Texture {
    let wrap = if map.clamp { Wrap::Clamp } else { Wrap::Repeat } as u32;
    let texture = Texture { wrap_u: wrap, wrap_v: wrap, ..texture };
    if (map.offset, map.scale) == ([0.0; 2], [1.0; 2]) {
        return texture;
    }
    let ([u, v], [scale_u, scale_v]) = (map.offset, map.scale);
    Placement { offset: [u, 1.0 - scale_v - v], rotation: 0.0, scale: [scale_u, scale_v] }.apply(texture)
}

/// The roughness of a sheen, for which MTL has no key.
const CLOTH: f32 = 0.5;
/// What a surface of the index of refraction 1.5 mirrors head-on.
const USUAL: f32 = 0.04;

/// A material of the scene without its textures.
///
/// With `Pr`, `Pm` or their textures, the material is metallic-roughness, and `Ks` and `Ns` have no effect. Otherwise
/// `Ns`, the exponent of MTL's highlight, gives the width of the lobe (Walter et al. 2007, whose Phong lobes it is), and
/// `Ks`, the brightness of its peak, the color that is mirrored head-on:
///
/// ```text
/// roughness² = α = √(2 / (Ns + 2))
/// F₀ = min(4 α², 1) · Ks
/// ```
///
/// The peak of our lobe is `F₀ / (4 π α²)` head-on, that of MTL `Ks / π` beside its diffuse `Kd / π`: they are equal. A
/// color below 0.04 mirrors less at grazing angles, too, and none of `Ks 0` is mirrored at all.
///
/// `Pc` and `Pcr` are a clear coat and its roughness, `Ps` is a white sheen as rough as cloth.
///
/// A texture multiplies `Kd`, 1 if it is absent. Exporters write `Ke 0 0 0` beside a texture of the emission, so that
/// one multiplies 1, too.
fn answer(source: &MtlMaterial, has_emission_texture: bool) -> Material {
    let maps = &source.maps;
    let base = source.diffuse.unwrap_or(if maps.diffuse.is_some() { [1.0; 3] } else { [0.8; 3] });
    let is_dark = source.emission == [0.0; 3];
    let emission = if is_dark && has_emission_texture { [1.0; 3] } else { source.emission };
    let is_physical = source.roughness.is_some()
        || source.metallic.is_some()
        || maps.roughness.is_some()
        || maps.metallic.is_some();
    let coat = Clearcoat { share: source.coat, roughness: source.coat_roughness, ..Clearcoat::default() };
    let sheen = Sheen { color: Vec3::splat(source.sheen), roughness: CLOTH, ..Sheen::default() };
    let material = Material::new(base)
        .emission(emission)
        .clearcoat(Some(coat).filter(|coat| coat.share > 0.0))
        .sheen(Some(sheen).filter(|_| source.sheen > 0.0));
    if is_physical {
        let metallic = source.metallic.unwrap_or(if maps.metallic.is_some() { 1.0 } else { 0.0 });
        return material.metallic(metallic).roughness(source.roughness.unwrap_or(1.0));
    }
    let alpha_squared = 2.0 / (source.shininess + 2.0);
    let roughness = libm::sqrtf(libm::sqrtf(alpha_squared));
    let mirrored = source.specular.map(|s| (s * (4.0 * alpha_squared).min(1.0)).min(1.0));
    let most = mirrored.into_iter().fold(0.0, f32::max);
    let strength = (most / USUAL).min(1.0);
    let specular = if strength > 0.0 { mirrored.map(|s| s / strength) } else { mirrored };
    material.roughness(roughness).specular(specular).specular_strength(strength)
}

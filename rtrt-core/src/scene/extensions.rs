//! What a material may have beyond metallic-roughness, as people write it.

use crate::layout::{MaterialRecord, Texture};
use glam::Vec3;

/// A clear coat, like varnish (KHR_materials_clearcoat): it mirrors light with a lobe of its own, and dims what is
/// below it. Its index of refraction is 1.5.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Clearcoat {
    /// The share of the surface that it covers, 0 ..= 1. 1 unless set.
    pub share: f32,
    /// The map that multiplies it (red).
    pub map: Option<Texture>,
    /// 0 ..= 1. 0 unless set.
    pub roughness: f32,
    /// The map that multiplies it (green).
    pub roughness_map: Option<Texture>,
    /// The map of the coat's normals; that of the material does not turn them.
    pub normal_map: Option<Texture>,
    /// How strongly that map turns normals. 1 unless set.
    pub normal_scale: f32,
}

impl Default for Clearcoat {
    /// Smooth, over all of the surface.
    fn default() -> Self {
        Self {
            share: 1.0,
            map: None,
            roughness: 0.0,
            roughness_map: None,
            normal_map: None,
            normal_scale: 1.0,
        }
    }
}

/// Fibers that scatter light at grazing angles, like those of velvet (KHR_materials_sheen).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sheen {
    /// Linear RGB, 0 ..= 1. Black unless set.
    pub color: Vec3,
    /// The map that multiplies it, sRGB.
    pub color_map: Option<Texture>,
    /// 0 ..= 1. 0 unless set.
    pub roughness: f32,
    /// The map that multiplies it (alpha).
    pub roughness_map: Option<Texture>,
}

/// Scratches along one direction, like those of brushed metal (KHR_materials_anisotropy): the highlight is longer
/// along a tangent. Meshes need tangents for it (see [`Mesh::with_made_tangents`](crate::scene::Mesh)).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Anisotropy {
    /// 0 ..= 1. 0 unless set.
    pub strength: f32,
    /// The angle from the mesh's tangent to the one of the highlight, toward the bitangent, radians. 0 unless set.
    pub rotation: f32,
    /// The map of the direction (red and green, −1 ..= 1 as 0 ..= 255), and of what multiplies the strength (blue).
    pub map: Option<Texture>,
}

/// A thin film whose colors depend on the angle, like that of a soap bubble (KHR_materials_iridescence).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Iridescence {
    /// The share of the surface that it covers, 0 ..= 1. 1 unless set.
    pub share: f32,
    /// The map that multiplies it (red).
    pub map: Option<Texture>,
    /// The index of refraction, 1 ..= 8. 1.3 unless set.
    pub ior: f32,
    /// Nanometers, 0 ..= 65 536, where the map is 0 and where it is 1. 100 and 400 unless set.
    pub thickness: [f32; 2],
    /// The map between these (green); without one the film is as thick as where it is 1.
    pub thickness_map: Option<Texture>,
}

impl Default for Iridescence {
    /// Of one thickness, over all of the surface.
    fn default() -> Self {
        Self { share: 1.0, map: None, ior: 1.3, thickness: [100.0, 400.0], thickness_map: None }
    }
}

impl Clearcoat {
    pub(super) fn record(&self, record: &mut MaterialRecord) {
        record.extensions |= MaterialRecord::HAS_COAT;
        record.coat = self.share;
        record.coat_roughness = self.roughness;
        record.coat_bump = self.normal_scale;
        set(record, MaterialRecord::COAT, self.map);
        set(record, MaterialRecord::COAT_ROUGHNESS, self.roughness_map);
        set(record, MaterialRecord::COAT_NORMAL, self.normal_map);
    }
}

impl Sheen {
    pub(super) fn record(&self, record: &mut MaterialRecord) {
        record.extensions |= MaterialRecord::HAS_SHEEN;
        record.sheen = self.color.to_array();
        record.sheen_roughness = self.roughness;
        set(record, MaterialRecord::SHEEN, self.color_map);
        set(record, MaterialRecord::SHEEN_ROUGHNESS, self.roughness_map);
    }
}

impl Anisotropy {
    pub(super) fn record(&self, record: &mut MaterialRecord) {
        record.extensions |= MaterialRecord::IS_BRUSHED;
        record.brushed = self.strength;
        let (sine, cosine) = libm::sincos(f64::from(self.rotation));
        record.brushed_turn = [cosine as f32, sine as f32];
        set(record, MaterialRecord::BRUSHED, self.map);
    }
}

impl Iridescence {
    pub(super) fn record(&self, record: &mut MaterialRecord) {
        record.extensions |= MaterialRecord::HAS_FILM;
        record.film = self.share;
        record.film_ior = self.ior;
        record.film_thickness = self.thickness;
        set(record, MaterialRecord::FILM, self.map);
        set(record, MaterialRecord::FILM_THICKNESS, self.thickness_map);
    }
}

fn set(record: &mut MaterialRecord, place: usize, map: Option<Texture>) {
    record.textures[place] = map.unwrap_or(Texture::NONE);
}

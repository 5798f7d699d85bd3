//! The names of extensions.

/// Scratches along one direction.
pub(super) const ANISOTROPY: &str = "KHR_materials_anisotropy";
/// A clear coat.
pub(super) const CLEARCOAT: &str = "KHR_materials_clearcoat";
/// Instances of a node's mesh.
pub(super) const GPU_INSTANCING: &str = "EXT_mesh_gpu_instancing";
/// The index of refraction of a material.
pub(super) const IOR: &str = "KHR_materials_ior";
/// A thin film.
pub(super) const IRIDESCENCE: &str = "KHR_materials_iridescence";
/// Buffer views with smaller bytes.
pub(super) const MESHOPT: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];
/// Images in KTX 2, compressed by Basis Universal.
pub(super) const BASISU: &str = "KHR_texture_basisu";
/// Primitives with fewer bytes.
pub(super) const DRACO: &str = "KHR_draco_mesh_compression";
/// Images in WebP.
pub(super) const WEBP: &str = "EXT_texture_webp";
/// Levels of detail of nodes.
pub(super) const LOD: &str = "MSFT_lod";
/// A sheen.
pub(super) const SHEEN: &str = "KHR_materials_sheen";
/// Strength and color of what a material mirrors.
pub(super) const SPECULAR: &str = "KHR_materials_specular";
/// Offset, rotation and scale of a texture.
pub(super) const TEXTURE_TRANSFORM: &str = "KHR_texture_transform";

/// The extensions that the import reads.
pub(super) const SUPPORTED: &[&str] = &[
    GPU_INSTANCING,
    MESHOPT[0],
    MESHOPT[1],
    WEBP,
    DRACO,
    "KHR_lights_punctual",
    ANISOTROPY,
    CLEARCOAT,
    "KHR_materials_emissive_strength",
    IOR,
    IRIDESCENCE,
    "KHR_materials_pbrSpecularGlossiness",
    SHEEN,
    SPECULAR,
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    BASISU,
    TEXTURE_TRANSFORM,
    LOD,
];

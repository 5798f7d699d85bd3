//! The names of extensions.

/// Instances of a node's mesh.
pub(super) const GPU_INSTANCING: &str = "EXT_mesh_gpu_instancing";
/// Levels of detail of nodes.
pub(super) const LOD: &str = "MSFT_lod";
/// Offset, rotation and scale of a texture.
pub(super) const TEXTURE_TRANSFORM: &str = "KHR_texture_transform";

/// The extensions that the import reads.
pub(super) const SUPPORTED: &[&str] = &[
    GPU_INSTANCING,
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    TEXTURE_TRANSFORM,
    LOD,
];

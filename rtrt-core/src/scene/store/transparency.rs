//! Records of instances that are not opaque, for searches.

use super::{Scene, SceneError};
use crate::kernel::transparency;
use crate::layout::{AlphaMode, Material};

impl Scene {
    /// Where the pane of an instance of this mesh and material is in the words (see
    /// [`crate::kernel::transparency`]), which it is added to; 0 for a material that is opaque.
    pub(in crate::scene) fn transparency(&mut self, mesh: u32, material: u32) -> Result<u32, SceneError> {
        let material = self.materials[material as usize];
        if material.alpha_mode == AlphaMode::Opaque as u32 {
            return Ok(0);
        }
        if self.see_through != AlphaMode::Blend {
            let blends = material.alpha_mode == AlphaMode::Blend as u32;
            self.see_through = if blends { AlphaMode::Blend } else { AlphaMode::Mask };
        }
        let map = material.textures[Material::COLOR];
        let stored = *self.mesh(mesh)?;
        let set = usize::from(map.set == 1 && stored.first_second_uv > 0);
        let more = (transparency::VERTEX * stored.vertices + transparency::RECORD) as usize;
        if self.mesh_data.len() + more > u32::MAX as usize / 4 {
            return Err(SceneError::TooLarge { what: "triangles" });
        }
        self.versions.geometry += 1;
        if stored.transparencies[set] == 0 && stored.vertices > 0 {
            self.meshes[mesh as usize].transparencies[set] = self.mesh_data.len() as u32;
            for vertex in 0..stored.vertices {
                let attribute = self.attributes[(stored.first_vertex + vertex) as usize];
                let second = (stored.first_second_uv + 2 * vertex) as usize;
                let uv = match set {
                    0 => attribute.uv.map(f32::to_bits),
                    _ => [self.mesh_data[second], self.mesh_data[second + 1]],
                };
                self.mesh_data.extend([uv[0], uv[1], attribute.color]);
            }
        }
        let at = self.mesh_data.len() as u32;
        let [r, g, b] = material.base.map(f32::to_bits);
        self.mesh_data.extend([
            material.alpha_mode,
            material.cutoff.to_bits(),
            r,
            g,
            b,
            material.alpha.to_bits(),
        ]);
        let size = if map.levels > 0 { [map.width, map.height] } else { [0; 2] };
        self.mesh_data.extend([self.meshes[mesh as usize].transparencies[set], map.first, size[0], size[1]]);
        self.mesh_data.extend([map.wrap_u, map.wrap_v]);
        self.mesh_data.extend(map.turn.as_flattened().iter().chain(&map.shift).map(|n| n.to_bits()));
        Ok(at)
    }
}

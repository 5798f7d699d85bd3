//! Transparency records of instances, which hit filters read.

use super::{Scene, SceneError};
use crate::layout::{AlphaKind, FinestLevel, MaterialRecord, Transparency, TransparencyVertex};
use bytemuck::cast_slice;
use core::slice;

impl Scene {
    /// Where the record of instances of this mesh and material is in `mesh_data` (see
    /// [`Transparency`]); 0 for a material that is opaque. A record that is missing is
    /// added, one of a material that has changed is written anew.
    pub(in crate::scene) fn transparency(&mut self, mesh: u32, index: u32) -> Result<u32, SceneError> {
        let material = self.material_records[index as usize];
        if material.alpha_mode == AlphaKind::Opaque as u32 {
            return Ok(0);
        }
        if self.see_through != AlphaKind::Blend {
            let blends = material.alpha_mode == AlphaKind::Blend as u32;
            self.see_through = if blends { AlphaKind::Blend } else { AlphaKind::Mask };
        }
        let map = material.textures[MaterialRecord::COLOR];
        let stored = *self.mesh(mesh)?;
        let set = usize::from(map.set == 1 && stored.first_second_uv > 0);
        let more = (TransparencyVertex::WORDS * stored.vertices + Transparency::WORDS) as usize;
        if self.mesh_data.len() + more > u32::MAX as usize / 4 {
            return Err(SceneError::TooLarge { what: "triangles" });
        }
        if stored.transparencies[set] == 0 && stored.vertices > 0 {
            self.versions.geometry += 1;
            self.meshes[mesh as usize].transparencies[set] = self.mesh_data.len() as u32;
            for vertex in 0..stored.vertices {
                let attribute = self.attributes[(stored.first_vertex + vertex) as usize];
                let second = (stored.first_second_uv + 2 * vertex) as usize;
                let uv = match set {
                    0 => attribute.uv,
                    _ => [self.mesh_data[second], self.mesh_data[second + 1]].map(f32::from_bits),
                };
                let vertex = TransparencyVertex { uv, color: attribute.color };
                self.mesh_data.extend_from_slice(cast_slice(&[vertex]));
            }
        }
        let [r, g, b] = material.base;
        // Of a shadow, glass takes what it does not let through.
        let opaque = material.extensions & MaterialRecord::IGNORES_ALPHA != 0;
        let alpha = if opaque { 1.0 } else { material.alpha };
        let mean = ((r + g + b) / 3.0).clamp(0.0, 1.0);
        let alpha = alpha * (1.0 - material.transmission * (1.0 - material.metallic) * mean);
        let record = Transparency {
            alpha_mode: material.alpha_mode,
            cutoff: material.cutoff,
            base: [r, g, b, alpha],
            first_vertex: self.meshes[mesh as usize].transparencies[set],
            texture: FinestLevel::new(&map),
        };
        let at = match self.transparencies.get(&(mesh, index)) {
            Some(&at) => at,
            None => {
                let at = self.mesh_data.len() as u32;
                self.mesh_data.extend([u32::MAX; Transparency::WORDS as usize]);
                self.transparencies.insert((mesh, index), at);
                at
            }
        };
        let record: &[u32] = cast_slice(slice::from_ref(&record));
        let place = &mut self.mesh_data[at as usize..][..record.len()];
        if place != record {
            place.copy_from_slice(record);
            self.versions.geometry += 1;
        }
        Ok(at)
    }
}

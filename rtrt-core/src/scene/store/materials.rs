//! Materials: what a scene makes of them, and what instances take from them.

use super::{MaterialIndex, Scene, SceneError};
use crate::layout::{AlphaKind, MaterialRecord};
use crate::scene::place::InstanceMaterial;
use crate::scene::{InstanceIndex, Material};
use core::mem::take;

impl Scene {
    /// Adds a material. Numbers too small to count are 0.
    ///
    /// # Errors
    /// A number is not finite, or out of its range: see [`Material`].
    pub fn add_material(&mut self, material: Material) -> Result<MaterialIndex, SceneError> {
        self.material_records.push(material.record()?);
        self.materials.push(material);
        self.versions.materials += 1;
        Ok(MaterialIndex { number: self.materials.len() as u32 - 1, scene: self.family() })
    }

    /// A material as it was added or last set; `None` for an index of another scene.
    pub fn material(&self, index: MaterialIndex) -> Option<&Material> {
        self.materials.get(index.number as usize).filter(|_| index.scene == self.family())
    }

    /// The material of an instance; `None` for an index of another scene.
    pub fn material_of(&self, instance: InstanceIndex) -> Option<MaterialIndex> {
        let index = self.instance(instance).ok()?;
        Some(MaterialIndex { number: self.instances[index].material, scene: self.family() })
    }

    /// Changes a material, and so the look of all instances that have it.
    ///
    /// ```
    /// # use glam::Mat4;
    /// # use rtrt_core::scene::{Material, Scene};
    /// # let mut scene = Scene::new();
    /// # let red = scene.add_material(Material::new([0.8, 0.1, 0.1]))?;
    /// # let ball = scene.add_sphere(red, Mat4::IDENTITY)?;
    /// let material = scene.material_of(ball).ok_or("no such instance")?;
    /// let red = *scene.material(material).ok_or("no such material")?;
    /// scene.set_material(material, red.roughness(0.2).blend(0.5))?;
    /// # Ok::<(), Box<dyn core::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// There is no such material, a number is out of its range (see [`Material`]), or the scene is full;
    /// the material then stays as it was.
    pub fn set_material(&mut self, index: MaterialIndex, material: Material) -> Result<(), SceneError> {
        let (number, record) = (index.number as usize, material.record()?);
        self.material(index).ok_or(SceneError::Index { what: "material", index: index.number })?;
        let old = self.material_records[number];
        self.material_records[number] = record;
        if let Err(error) = self.repaint(index) {
            self.material_records[number] = old;
            self.repaint(index)?;
            return Err(error);
        }
        self.materials[number] = material;
        self.versions.materials += 1;
        self.versions.instances += 1;
        let placed = self.levels.values().flatten().map(|level| &level.placed);
        let kinds = self
            .instances
            .iter()
            .chain(placed)
            .map(|instance| self.material_records[instance.material as usize].alpha_mode);
        self.see_through = match kinds.max() {
            Some(kind) if kind == AlphaKind::Blend as u32 => AlphaKind::Blend,
            Some(kind) if kind == AlphaKind::Mask as u32 => AlphaKind::Mask,
            _ => AlphaKind::Opaque,
        };
        Ok(())
    }

    /// Gives the instances with a material what they take from it.
    fn repaint(&mut self, MaterialIndex { number: material, .. }: MaterialIndex) -> Result<(), SceneError> {
        let double_sided = self.material_records[material as usize].double_sided;
        for number in 0..self.instances.len() {
            if self.instances[number].material == material && self.tags[number].is_live() {
                let transparency = self.transparency(self.object_meshes[number], material)?;
                let instance = &mut self.instances[number];
                (instance.double_sided, instance.transparency) = (double_sided, transparency);
            }
        }
        let mut levels = take(&mut self.levels);
        let mut painted = levels.values_mut().flatten().filter(|level| level.placed.material == material);
        let result = painted.try_for_each(|level| {
            level.placed.double_sided = double_sided;
            level.placed.transparency = self.transparency(level.mesh.number, material)?;
            Ok(())
        });
        self.levels = levels;
        result
    }

    pub(in crate::scene) fn instance_material(
        &self,
        MaterialIndex { number, scene }: MaterialIndex,
    ) -> Result<InstanceMaterial, SceneError> {
        let found = self.material_records.get(number as usize).filter(|_| scene == self.family());
        let found = found.map(|material| InstanceMaterial::new(number, material));
        found.ok_or(SceneError::Index { what: "material", index: number })
    }

    /// The materials as backends read them.
    pub fn materials(&self) -> &[MaterialRecord] {
        &self.material_records
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Mat4;

    #[test]
    fn a_material_that_is_set_is_that_of_a_scene_made_with_it() {
        let with = |material: Material| {
            let mut scene = Scene::new();
            let index = scene.add_material(material).unwrap();
            let balls = [0.0, 3.0]
                .map(|x| scene.add_sphere(index, Mat4::from_translation([x, 0.0, 0.0].into())).unwrap());
            (scene, index, balls)
        };
        let opaque = Material::new([0.5; 3]);
        let looks = [opaque, opaque.blend(0.5), opaque.mask(0.3).double_sided(false), opaque.blend(0.2)];
        for from in looks {
            for to in looks {
                let (mut changed, index, balls) = with(from);
                changed.set_material(index, to).unwrap();
                let (made, ..) = with(to);
                assert_eq!(changed.materials(), made.materials());
                assert_eq!(changed.see_through(), made.see_through());
                assert_eq!(
                    changed.material_of(balls[1]).and_then(|index| changed.material(index)),
                    Some(&to)
                );
                for (a, b) in changed.instances().iter().zip(made.instances()) {
                    assert_eq!(a.double_sided, b.double_sided);
                    let words = |scene: &Scene, at: u32| match at {
                        0 => None,
                        _ => Some(scene.mesh_data()[at as usize..][..6].to_vec()),
                    };
                    assert_eq!(words(&changed, a.transparency), words(&made, b.transparency));
                }
            }
        }
        let (mut scene, index, _) = with(opaque);
        let refused = scene.set_material(index, opaque.roughness(2.0));
        assert!(matches!(refused, Err(SceneError::Material { what: "roughness", .. })), "{refused:?}");
        assert_eq!(scene.material(index), Some(&opaque));
    }
}

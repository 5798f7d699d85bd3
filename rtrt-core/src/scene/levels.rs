//! Levels of detail: instances that have another mesh when they are farther away.

use crate::layout::Instance;
use crate::scene::bvh::Bounds;
use crate::scene::place::{InstanceMaterial, Stored, matrix, place};
use crate::scene::{InstanceIndex, MaterialIndex, MeshIndex, Scene, SceneError, Versions};
use alloc::vec::Vec;
use glam::{DVec3, Mat4, Vec3};

/// Another mesh of an instance.
#[derive(Debug, Clone, Copy)]
pub(super) struct LodLevel {
    /// From this distance on.
    from: f32,
    /// Which mesh.
    pub mesh: MeshIndex,
    /// The instance that it then is.
    pub placed: Instance,
}

impl Scene {
    /// Gives an instance other meshes from some distances on; those of before are forgotten. Its
    /// own mesh is for what is nearer than all of them.
    ///
    /// Distances are from the camera to the nearest point of the bounds that the instance has with
    /// its own mesh, so that what is chosen does not depend on what was chosen before. It is
    /// chosen once a frame, for everything in it: a shadow is that of the mesh that is seen.
    ///
    /// # Errors
    /// An index is of another scene, a distance is not a number above 0, or the instance would be
    /// out of range; nothing has changed then.
    pub fn set_levels(
        &mut self,
        instance: InstanceIndex,
        levels: &[(f32, MeshIndex)],
    ) -> Result<(), SceneError> {
        let (_, own) = self.instance(instance)?;
        let levels: Vec<_> =
            levels.iter().map(|&(from, mesh)| (from, mesh, MaterialIndex(own.material))).collect();
        self.set_levels_with(instance, &levels)
    }

    /// [`Scene::set_levels`], each with a material of its own.
    ///
    /// # Errors
    /// As for [`Scene::set_levels`].
    pub fn set_levels_with(
        &mut self,
        instance: InstanceIndex,
        levels: &[(f32, MeshIndex, MaterialIndex)],
    ) -> Result<(), SceneError> {
        let (index, own) = self.instance(instance)?;
        let mut found = Vec::with_capacity(levels.len());
        for &(from, mesh, material) in levels {
            if !(from > 0.0 && from.is_finite()) {
                return Err(SceneError::Distance { value: from });
            }
            let mut placed = place(self.mesh(mesh.0)?, self.instance_material(material)?, matrix(&own))?;
            placed.transparency = self.transparency(mesh.0, material.0)?;
            found.push(LodLevel { from, mesh, placed });
        }
        found.sort_by(|a, b| a.from.total_cmp(&b.from));
        if found.is_empty() {
            self.levels.remove(&(index as u32));
        } else {
            self.levels.insert(index as u32, found);
        }
        self.objects_changed();
        Ok(())
    }

    /// An instance's levels, placed elsewhere.
    pub(super) fn moved_levels(&self, instance: usize, to_world: Mat4) -> Result<Vec<LodLevel>, SceneError> {
        let levels = self.levels.get(&(instance as u32)).map_or(&[][..], |levels| levels);
        let moved = levels.iter().map(|level| {
            let placed = place(self.mesh(level.mesh.0)?, InstanceMaterial::of(&level.placed), to_world)?;
            Ok(LodLevel { placed, ..*level })
        });
        moved.collect()
    }

    /// The levels of all instances that have this mesh as one of theirs, where it now is as `stored`
    /// says.
    pub(super) fn reshaped_levels(
        &self,
        mesh: MeshIndex,
        stored: &Stored,
    ) -> Result<Vec<(u32, usize, Instance)>, SceneError> {
        let mut placed = Vec::new();
        for (&instance, levels) in &self.levels {
            for (number, level) in levels.iter().enumerate().filter(|(_, level)| level.mesh == mesh) {
                let own = &level.placed;
                placed.push((instance, number, place(stored, InstanceMaterial::of(own), matrix(own))?));
            }
        }
        Ok(placed)
    }

    /// Keeps what [`Scene::reshaped_levels`] has found.
    pub(super) fn replace_levels(&mut self, placed: Vec<(u32, usize, Instance)>) {
        for (instance, number, placed) in placed {
            if let Some(levels) = self.levels.get_mut(&instance) {
                levels[number].placed = placed;
            }
        }
    }

    /// The level that a camera at `eye` sees of each instance that has any; none for its own mesh.
    fn seen_levels(&self, eye: Vec3) -> impl Iterator<Item = (usize, Option<&LodLevel>)> {
        self.levels.iter().map(move |(&index, levels)| {
            let index = index as usize;
            let distance = distance(eye, &self.instances()[index]);
            let far = levels.iter().rev().find(|level| distance >= f64::from(level.from));
            (index, far.filter(|_| self.is_seen(index)))
        })
    }
}

/// The instances of a frame of a scene where some have levels.
#[derive(Debug, Clone)]
pub(super) struct LodSelection {
    /// Whether some have.
    pub is_needed: bool,
    scene: u32,
    versions: Versions,
    /// The distances from which on the levels are seen that were chosen; 0 for an instance's own mesh.
    from: Vec<f32>,
    instances: Vec<Instance>,
    pub bounds: Bounds,
    /// Another number whenever other instances were chosen.
    pub changes: u32,
}

impl Default for LodSelection {
    fn default() -> Self {
        Self {
            is_needed: false,
            scene: 0,
            versions: Versions::default(),
            from: Vec::new(),
            instances: Vec::new(),
            bounds: Bounds::EMPTY,
            changes: 0,
        }
    }
}

impl LodSelection {
    /// The instances of the frame: the scene's, or those with the levels that were chosen.
    pub fn instances<'a>(&'a self, scene: &'a Scene) -> &'a [Instance] {
        if self.is_needed { &self.instances } else { scene.instances() }
    }

    /// Chooses what a camera at `eye` sees. Nothing is done where that is what was chosen last.
    pub fn choose(&mut self, scene: &Scene, eye: Vec3) {
        self.is_needed = !scene.levels.is_empty();
        if !self.is_needed {
            return;
        }
        let from = |level: Option<&LodLevel>| level.map_or(0.0, |level| level.from);
        let source = (scene.id(), scene.versions());
        let is_same = self.changes > 0
            && source == (self.scene, self.versions)
            && scene.seen_levels(eye).map(|(_, level)| from(level)).eq(self.from.iter().copied());
        if is_same {
            return;
        }
        (self.scene, self.versions) = source;
        self.changes += 1;
        self.from.clear();
        self.instances.clear();
        self.instances.extend_from_slice(scene.instances());
        for (index, level) in scene.seen_levels(eye) {
            self.from.push(from(level));
            if let Some(level) = level {
                self.instances[index] = level.placed;
            }
        }
        let seen = self.instances.iter().enumerate().filter(|(index, _)| scene.is_seen(*index));
        self.bounds = seen.fold(Bounds::EMPTY, |all, (_, o)| all.union(&Bounds { low: o.low, high: o.high }));
    }
}

/// From a place to the nearest point of an instance's bounds; 0 inside.
fn distance(from: Vec3, instance: &Instance) -> f64 {
    let [low, high] = [instance.low, instance.high].map(|corner| Vec3::from(corner).as_dvec3());
    let from = from.as_dvec3();
    let away = (low - from).max(from - high).max(DVec3::ZERO);
    libm::sqrt(away.length_squared())
}

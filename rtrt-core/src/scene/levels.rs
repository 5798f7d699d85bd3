//! Levels of detail: an instance shows a coarser mesh from a distance on.

use crate::layout::Instance;
use crate::scene::bvh::Bounds;
use crate::scene::place::{InstanceMaterial, Stored, matrix, place};
use crate::scene::{InstanceIndex, MaterialIndex, MeshIndex, Scene, SceneError, Versions};
use alloc::vec::Vec;
use glam::{DVec3, Mat4, Vec3};

/// A coarser mesh of an instance.
#[derive(Debug, Clone, Copy)]
pub(super) struct LodLevel {
    /// The least distance at which it is shown, world units.
    from: f32,
    /// The mesh.
    pub mesh: MeshIndex,
    /// The instance with this mesh.
    pub placed: Instance,
}

impl Scene {
    /// Replaces the levels of detail of an instance: pairs of a distance and the mesh that is shown from it
    /// on. Nearer than all distances the instance shows its own mesh.
    ///
    /// Distances are from the camera to the nearest point of the bounds that the instance has with
    /// its own mesh, so the choice does not depend on earlier choices. It is
    /// made once a frame for camera and lights: a shadow is that of the mesh in the picture.
    ///
    /// # Errors
    /// An index is of another scene, a distance is not a number above 0, or the instance would be
    /// out of range. The scene then stays as it was.
    pub fn set_levels(
        &mut self,
        instance: InstanceIndex,
        levels: &[(f32, MeshIndex)],
    ) -> Result<(), SceneError> {
        let own = &self.instances()[self.instance(instance)?];
        let material = MaterialIndex { number: own.material, scene: self.family() };
        let levels: Vec<_> = levels.iter().map(|&(from, mesh)| (from, mesh, material)).collect();
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
        let index = self.instance(instance)?;
        let mut found = Vec::with_capacity(levels.len());
        for &(from, mesh, material) in levels {
            if !(from > 0.0 && from.is_finite()) {
                return Err(SceneError::Distance { value: from });
            }
            let mut placed = place(
                self.indexed_mesh(mesh)?,
                self.instance_material(material)?,
                matrix(&self.instances()[index]),
            )?;
            placed.transparency = self.transparency(mesh.number, material.number)?;
            found.push(LodLevel { from, mesh, placed });
        }
        found.sort_by(|a, b| a.from.total_cmp(&b.from));
        if found.is_empty() {
            self.levels.remove(&(index as u32));
        } else {
            self.levels.insert(index as u32, found);
        }
        self.moved([]);
        Ok(())
    }

    /// The levels of an instance with another transform; `None` if it has no levels.
    pub(super) fn moved_levels(
        &self,
        instance: usize,
        to_world: Mat4,
    ) -> Result<Option<Vec<LodLevel>>, SceneError> {
        let Some(levels) = self.levels.get(&(instance as u32)) else { return Ok(None) };
        let moved = levels.iter().map(|level| {
            let placed = place(self.mesh(level.mesh.number)?, InstanceMaterial::of(&level.placed), to_world)?;
            Ok(LodLevel { placed, ..*level })
        });
        moved.collect::<Result<_, _>>().map(Some)
    }

    /// The levels of all instances that use this mesh as a level, after its shape changed to `stored`.
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

    /// Stores the result of [`Scene::reshaped_levels`].
    pub(super) fn replace_levels(&mut self, placed: Vec<(u32, usize, Instance)>) {
        for (instance, number, placed) in placed {
            if let Some(levels) = self.levels.get_mut(&instance) {
                levels[number].placed = placed;
            }
        }
    }

    /// For each instance with levels, the one that a camera at `eye` sees; `None` for the instance's own mesh.
    fn seen_levels(&self, eye: Vec3) -> impl Iterator<Item = (usize, Option<&LodLevel>)> {
        self.levels.iter().map(move |(&index, levels)| {
            let index = index as usize;
            let distance = distance(eye, &self.instances()[index]);
            let far = levels.iter().rev().find(|level| distance >= f64::from(level.from));
            (index, far.filter(|_| self.is_seen(index)))
        })
    }
}

/// The instances of a frame with their chosen levels of detail.
#[derive(Debug, Clone)]
pub(super) struct LodSelection {
    /// Whether any instance has levels.
    pub is_needed: bool,
    scene: u32,
    versions: Versions,
    /// The distances of the chosen levels; 0 for an instance's own mesh.
    from: Vec<f32>,
    instances: Vec<Instance>,
    pub bounds: Bounds,
    /// Counts changes of the choice.
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
    /// The instances of the frame: the scene's, or copies with the chosen levels.
    pub fn instances<'a>(&'a self, scene: &'a Scene) -> &'a [Instance] {
        if self.is_needed { &self.instances } else { scene.instances() }
    }

    /// Chooses the levels for a camera at `eye`, and copies instances only if the choice changed.
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

/// The distance from a point to the bounds of an instance, world units; 0 inside.
fn distance(from: Vec3, instance: &Instance) -> f64 {
    let [low, high] = [instance.low, instance.high].map(|corner| Vec3::from(corner).as_dvec3());
    let from = from.as_dvec3();
    let away = (low - from).max(from - high).max(DVec3::ZERO);
    libm::sqrt(away.length_squared())
}

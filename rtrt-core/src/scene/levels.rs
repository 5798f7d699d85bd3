//! Levels of detail: objects that have another mesh when they are farther away.

use crate::layout::Object;
use crate::scene::place::{Coat, Stored, matrix, place};
use crate::scene::tree::Bounds;
use crate::scene::{MaterialIndex, MeshIndex, ObjectIndex, Scene, SceneError, Versions};
use alloc::vec::Vec;
use glam::{DVec3, Mat4, Vec3};

/// Another mesh of an object.
#[derive(Debug, Clone, Copy)]
pub(super) struct Level {
    /// From this distance on.
    from: f32,
    /// Which mesh.
    mesh: MeshIndex,
    /// The object that it then is.
    placed: Object,
}

impl Scene {
    /// Gives an object other meshes from some distances on; those of before are forgotten. Its
    /// own mesh is for what is nearer than all of them.
    ///
    /// Distances are from the camera to the nearest point of the bounds that the object has with
    /// its own mesh, so that what is chosen does not depend on what was chosen before. It is
    /// chosen once a frame, for everything in it: a shadow is that of the mesh that is seen.
    ///
    /// # Errors
    /// An index is of another scene, a distance is not a number above 0, or the object would be
    /// out of range; nothing has changed then.
    pub fn set_levels(&mut self, object: ObjectIndex, levels: &[(f32, MeshIndex)]) -> Result<(), SceneError> {
        let (_, own) = self.object(object)?;
        let levels: Vec<_> =
            levels.iter().map(|&(from, mesh)| (from, mesh, MaterialIndex(own.material))).collect();
        self.set_levels_with(object, &levels)
    }

    /// [`Scene::set_levels`], each with a material of its own.
    ///
    /// # Errors
    /// As for [`Scene::set_levels`].
    pub fn set_levels_with(
        &mut self,
        object: ObjectIndex,
        levels: &[(f32, MeshIndex, MaterialIndex)],
    ) -> Result<(), SceneError> {
        let (index, own) = self.object(object)?;
        let mut found = Vec::with_capacity(levels.len());
        for &(from, mesh, material) in levels {
            if !(from > 0.0 && from.is_finite()) {
                return Err(SceneError::Distance { value: from });
            }
            let mut placed = place(self.mesh(mesh.0)?, self.coat(material)?, matrix(&own))?;
            placed.pane = self.pane(mesh.0, material.0)?;
            found.push(Level { from, mesh, placed });
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

    /// An object's levels, placed elsewhere.
    pub(super) fn moved_levels(&self, object: usize, to_world: Mat4) -> Result<Vec<Level>, SceneError> {
        let levels = self.levels.get(&(object as u32)).map_or(&[][..], |levels| levels);
        let moved = levels.iter().map(|level| {
            let placed = place(self.mesh(level.mesh.0)?, Coat::of(&level.placed), to_world)?;
            Ok(Level { placed, ..*level })
        });
        moved.collect()
    }

    /// The levels of all objects that have this mesh as one of theirs, where it now is as `stored`
    /// says.
    pub(super) fn reshaped_levels(
        &self,
        mesh: MeshIndex,
        stored: &Stored,
    ) -> Result<Vec<(u32, usize, Object)>, SceneError> {
        let mut placed = Vec::new();
        for (&object, levels) in &self.levels {
            for (number, level) in levels.iter().enumerate().filter(|(_, level)| level.mesh == mesh) {
                let own = &level.placed;
                placed.push((object, number, place(stored, Coat::of(own), matrix(own))?));
            }
        }
        Ok(placed)
    }

    /// Keeps what [`Scene::reshaped_levels`] has found.
    pub(super) fn replace_levels(&mut self, placed: Vec<(u32, usize, Object)>) {
        for (object, number, placed) in placed {
            if let Some(levels) = self.levels.get_mut(&object) {
                levels[number].placed = placed;
            }
        }
    }

    /// The level that a camera at `eye` sees of each object that has any; none for its own mesh.
    fn seen_levels(&self, eye: Vec3) -> impl Iterator<Item = (usize, Option<&Level>)> {
        self.levels.iter().map(move |(&index, levels)| {
            let index = index as usize;
            let distance = distance(eye, &self.objects()[index]);
            let far = levels.iter().rev().find(|level| distance >= f64::from(level.from));
            (index, far.filter(|_| self.is_seen(index)))
        })
    }
}

/// The objects of a frame of a scene where some have levels.
#[derive(Debug, Clone)]
pub(super) struct Chosen {
    /// Whether some have.
    pub is_needed: bool,
    scene: u32,
    versions: Versions,
    /// The distances from which on the levels are seen that were chosen; 0 for an object's own mesh.
    from: Vec<f32>,
    objects: Vec<Object>,
    pub bounds: Bounds,
    /// Another number whenever other objects were chosen.
    pub changes: u32,
}

impl Default for Chosen {
    fn default() -> Self {
        Self {
            is_needed: false,
            scene: 0,
            versions: Versions::default(),
            from: Vec::new(),
            objects: Vec::new(),
            bounds: Bounds::EMPTY,
            changes: 0,
        }
    }
}

impl Chosen {
    /// The objects of the frame: the scene's, or those with the levels that were chosen.
    pub fn objects<'a>(&'a self, scene: &'a Scene) -> &'a [Object] {
        if self.is_needed { &self.objects } else { scene.objects() }
    }

    /// Chooses what a camera at `eye` sees. Nothing is done where that is what was chosen last.
    pub fn choose(&mut self, scene: &Scene, eye: Vec3) {
        self.is_needed = !scene.levels.is_empty();
        if !self.is_needed {
            return;
        }
        let from = |level: Option<&Level>| level.map_or(0.0, |level| level.from);
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
        self.objects.clear();
        self.objects.extend_from_slice(scene.objects());
        for (index, level) in scene.seen_levels(eye) {
            self.from.push(from(level));
            if let Some(level) = level {
                self.objects[index] = level.placed;
            }
        }
        let seen = self.objects.iter().enumerate().filter(|(index, _)| scene.is_seen(*index));
        self.bounds = seen.fold(Bounds::EMPTY, |all, (_, o)| all.union(&Bounds { low: o.low, high: o.high }));
    }
}

/// From a place to the nearest point of an object's bounds; 0 inside.
fn distance(from: Vec3, object: &Object) -> f64 {
    let [low, high] = [object.low, object.high].map(|corner| Vec3::from(corner).as_dvec3());
    let from = from.as_dvec3();
    let away = (low - from).max(from - high).max(DVec3::ZERO);
    libm::sqrt(away.length_squared())
}

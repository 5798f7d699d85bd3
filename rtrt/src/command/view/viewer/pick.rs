//! What a person has selected, and what is done with it.

use super::Viewer;
use crate::command::Error;
use crate::command::console::Console;
use crate::command::repaint::{self, Repaint};
use crate::command::view::motion;
use glam::{DVec3, Vec3};
use rtrt::import::Label;
use rtrt_core::layout::Texture;
use rtrt_core::query::{Hit, Ray, Sides, Tree};
use rtrt_core::scene::{Material, Scene};
use rtrt_cpu::Parallel;
use std::time::Instant;

/// An object, and where it was clicked.
#[derive(Debug, Clone, PartialEq)]
pub struct Selection {
    /// The number of the object.
    pub object: u32,
    pub label: Label,
    /// The number of its material.
    pub material: u32,
    /// What was clicked; none for an object that was chosen from the list.
    pub point: Option<Point>,
}

/// A point of a surface.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// In the coordinates of the file.
    pub position: DVec3,
    /// From the camera.
    pub distance: f64,
    pub normal: Vec3,
    pub uv: Option<[f32; 2]>,
    /// The number of the triangle in the file.
    pub triangle: u32,
}

/// The part of the way to a point on which a surface hides it. Without the rest, surfaces hid what lies on them.
const HIDES: f32 = 0.998;

/// Makes the trees of a scene.
pub fn grow(tree: &mut Tree, scene: &Scene, console: &Console) {
    let start = Instant::now();
    tree.update(scene, &Parallel);
    let ms = start.elapsed().as_secs_f64() * 1e3;
    console.detail(format_args!("trees for rays took {ms:.1} ms"));
}

/// The nearest surface that the camera draws, on a ray.
pub fn nearest(tree: &mut Tree, scene: &Scene, origin: DVec3, direction: DVec3) -> Option<Hit> {
    let ray = Ray::new(origin.as_vec3(), direction.as_vec3()).sides(Sides::Drawn).through_holes();
    // A ray without a direction hits nothing.
    tree.world(scene).closest(&ray).ok().flatten()
}

/// The textures of a material: what they are for, and their size.
pub fn textures(material: &Material) -> Vec<(&'static str, [u32; 2])> {
    let all: [(&'static str, &Option<Texture>); 8] = [
        ("base color", &material.base_color_map),
        ("metalness and roughness", &material.metallic_roughness_map),
        ("normals", &material.normal_map),
        ("occlusion", &material.occlusion_map),
        ("emission", &material.emission_map),
        ("transmission", &material.transmission_map),
        ("specular", &material.specular_map),
        ("specular color", &material.specular_color_map),
    ];
    all.into_iter().filter_map(|(what, map)| map.map(|map| (what, [map.width, map.height]))).collect()
}

impl Viewer {
    /// Selects what is seen at a place in the picture, pixels; nothing where nothing is.
    pub(super) fn select_at(&mut self, place: [f32; 2]) {
        self.selection = self.picked(place.map(f64::from));
        self.selected_for = 0.0;
    }

    fn picked(&mut self, place: [f64; 2]) -> Option<Selection> {
        let (origin, direction) = motion::ray(&self.job.camera, self.size, place)?;
        let hit = nearest(&mut self.tree, &self.job.scene, origin, direction)?;
        let world = self.tree.world(&*self.job.scene);
        let surface = world.surface(&hit)?;
        let position = DVec3::from(surface.position.map(f64::from));
        let point = Point {
            position: position + self.job.origin,
            distance: position.distance(self.job.camera.eye.as_dvec3()),
            normal: surface.smooth_normal.into(),
            uv: surface.uv,
            triangle: surface.source_triangle,
        };
        Some(Selection { point: Some(point), ..self.object(hit.instance.number())? })
    }

    /// Whether the camera sees a point, or a surface is in front of it. None while the trees are not ready.
    pub fn sight(&mut self) -> Option<impl Fn(DVec3) -> bool + '_> {
        if !self.is_exact && !self.has_trees() {
            return None;
        }
        let (camera, near) = (self.job.camera, self.job.clip[0]);
        let world = self.tree.world(&*self.job.scene);
        Some(move |point: DVec3| {
            let Some((origin, way)) = motion::way_to(&camera, point) else { return true };
            let depth = crate::command::view::camera::depth(&camera, point).max(1e-9);
            let ray = Ray::new(origin.as_vec3(), way.as_vec3()).sides(Sides::Drawn).through_holes();
            let ray = ray.starting(near / depth as f32).until(HIDES);
            // A ray without a direction hits nothing.
            !world.occluded(&ray).unwrap_or(false)
        })
    }

    /// Selects an object.
    pub fn select(&mut self, object: u32) {
        self.selection = self.object(object);
    }

    fn object(&self, object: u32) -> Option<Selection> {
        let material = self.job.scene.instances().get(object as usize)?.material;
        let label = self.job.labels.get(object as usize).cloned().unwrap_or_default();
        Some(Selection { object, label, material, point: None })
    }

    /// The corners of what is selected, or of the scene.
    pub fn framed_box(&self) -> (DVec3, DVec3) {
        let scene = &self.job.scene;
        let selected = self.selection.as_ref().and_then(|it| scene.instances().get(it.object as usize));
        let (low, high) = match selected {
            Some(instance) => instance.padded_aabb(0.0),
            None => scene.extent().map_or(([0.0; 3], [0.0; 3]), |(low, high)| (low.into(), high.into())),
        };
        (Vec3::from(low).as_dvec3(), Vec3::from(high).as_dvec3())
    }

    /// Shows all of what is selected, or of the scene, from the same direction, and turns around it.
    pub(super) fn frame(&mut self) {
        let (low, high) = self.framed_box();
        let (center, radius) = ((low + high) * 0.5, ((high - low) * 0.5).length());
        if radius > 0.0 {
            let aspect = f64::from(self.size[0]) / f64::from(self.size[1]);
            self.look(motion::framed(&self.job.camera, (center, radius), aspect));
            self.controls.pivot = Some(center);
        }
    }

    /// Whether an object is drawn.
    pub fn is_visible(&self, object: u32) -> bool {
        !self.job.hidden.contains_key(&object)
    }

    /// Shows or hides objects. A failure is noted.
    pub fn show_objects(&mut self, objects: impl IntoIterator<Item = u32>, is_visible: bool) {
        let shown = self.set_visible(objects, is_visible);
        self.note(shown);
    }

    /// Shows or hides objects.
    fn set_visible(&mut self, objects: impl IntoIterator<Item = u32>, is_visible: bool) -> Result<(), Error> {
        for object in objects {
            if is_visible {
                self.job.unhide(object)?;
            } else {
                self.job.hide(object)?;
            }
        }
        if let Some(time) = self.time.filter(|_| is_visible) {
            // What was hidden may have moved.
            self.play(time)?;
        }
        self.touch();
        Ok(())
    }

    /// Hides what is selected.
    pub(super) fn hide_selection(&mut self) -> Result<(), Error> {
        match self.selection.take() {
            Some(selection) => self.set_visible([selection.object], false),
            None => {
                self.say("nothing is selected".into());
                Ok(())
            }
        }
    }

    /// Draws all objects.
    pub(super) fn show_all(&mut self) -> Result<(), Error> {
        let hidden: Vec<u32> = self.job.hidden.keys().copied().collect();
        self.set_visible(hidden, true)
    }

    /// A material by its number.
    pub fn material(&self, number: u32) -> Option<Material> {
        self.job.scene.material(repaint::material(&self.job.scene, number)?).copied()
    }

    /// Changes a material.
    pub fn repaint(&mut self, number: u32, next: &Material) {
        let Some(before) = self.material(number) else { return };
        let first = *self.unpainted.entry(number).or_insert(before);
        let repaint = Repaint::between(number, &before, next);
        let repainted = self.job.repaint(&repaint);
        if first == *next {
            self.unpainted.remove(&number);
        }
        self.note(repainted);
        self.touch();
    }

    /// The changes of materials, for the printed command.
    pub(super) fn repaints(&self) -> Vec<Repaint> {
        let changed = self.unpainted.iter().filter_map(|(number, before)| {
            self.material(*number).map(|after| Repaint::between(*number, before, &after))
        });
        self.options.materials.iter().copied().chain(changed).collect()
    }
}

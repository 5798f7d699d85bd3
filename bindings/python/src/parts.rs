//! What a scene is made of.

use crate::arrays::there_are;
use crate::camera::{Camera, View};
use crate::forked::PerProcess;
use glam::DVec3;
use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;
use rtrt::import::{Animation, Label, Loaded, NamedCamera, framing};
use rtrt_core::query::Tree;
use rtrt_core::scene::{InstanceIndex, MaterialIndex, MeshIndex, Scene, Texture};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Mutex;

/// What a scene is made of.
pub struct Parts {
    pub scene: Scene,
    pub tree: PerProcess<Mutex<Tree>>,
    pub meshes: Vec<MeshIndex>,
    pub materials: BTreeMap<u32, MaterialIndex>,
    pub textures: Vec<Texture>,
    pub mesh_names: Vec<String>,
    pub material_names: BTreeMap<u32, String>,
    /// What coordinates are relative to, in those of the file.
    pub origin: DVec3,
    pub labels: Vec<Label>,
    pub cameras: Vec<NamedCamera>,
    pub animation: Option<Animation>,
    /// Whether the lights are those of the file, which its animation moves.
    pub own_lights: bool,
    pub warnings: Vec<String>,
    pub files: Vec<PathBuf>,
}

impl Parts {
    /// Those of a scene that was loaded.
    pub fn of(loaded: Loaded) -> Self {
        let Loaded { scene, origin, cameras, labels, animation, mut warnings, files, .. } = loaded;
        if origin.to_array() != [0.0; 3] {
            let [x, y, z] = origin.to_array();
            warnings.push(format!(
                "the scene is far away, so coordinates are relative to {x}, {y}, {z} of the file"
            ));
        }
        let mut found = Self { own_lights: !scene.lights().is_empty(), ..Self::around(scene) };
        for (number, instance) in found.scene.instances().iter().enumerate() {
            let index = found.scene.instance_index(number as u32);
            if let Some(material) = index.and_then(|index| found.scene.material_of(index)) {
                found.materials.insert(instance.material, material);
            }
        }
        (found.labels, found.cameras, found.animation) = (labels, cameras, animation);
        found.origin = origin;
        (found.warnings, found.files) = (warnings, files);
        found
    }

    /// Those of a scene of which nothing else is known.
    pub fn around(scene: Scene) -> Self {
        Self {
            scene,
            tree: PerProcess::new(),
            meshes: vec![],
            materials: BTreeMap::new(),
            textures: vec![],
            mesh_names: vec![],
            material_names: BTreeMap::new(),
            origin: DVec3::ZERO,
            labels: vec![],
            cameras: vec![],
            animation: None,
            own_lights: false,
            warnings: vec![],
            files: vec![],
        }
    }

    /// The camera for pictures without one: the first of the file, or one that sees everything.
    pub fn usual_camera(&self, size: [u32; 2]) -> View {
        let aspect = size[0] as f32 / size[1] as f32;
        match self.cameras.first() {
            Some(named) => Camera::of(named.clone()).at(size),
            None => Camera::around(framing(&self.scene, aspect), String::new()).at(size),
        }
    }

    /// The first camera of the file.
    pub fn first_camera(&self) -> Option<Camera> {
        self.cameras.first().cloned().map(Camera::of)
    }

    /// The object with a number.
    pub fn object(&self, number: i64) -> PyResult<InstanceIndex> {
        u32::try_from(number).ok().and_then(|number| self.scene.instance_index(number)).ok_or_else(|| {
            let known = there_are(self.scene.instances().len(), "object");
            PyIndexError::new_err(format!("there is no object {number}: {known}"))
        })
    }

    /// The material with a number.
    pub fn material_index(&self, number: i64) -> PyResult<MaterialIndex> {
        u32::try_from(number).ok().and_then(|number| self.materials.get(&number)).copied().ok_or_else(|| {
            PyIndexError::new_err(format!(
                "no material {number} was added, or is that of an object of the file"
            ))
        })
    }

    /// The mesh with a number.
    pub fn mesh_index(&self, number: i64) -> PyResult<MeshIndex> {
        usize::try_from(number).ok().and_then(|number| self.meshes.get(number)).copied().ok_or_else(|| {
            let known = there_are(self.meshes.len(), "mesh");
            PyIndexError::new_err(format!("there is no mesh {number}: {known}, as added by add_mesh"))
        })
    }

    /// Remembers what an object that was just added is called. What has no name has its number.
    pub fn label(
        &mut self,
        object: InstanceIndex,
        node: Option<String>,
        mesh: String,
        material: MaterialIndex,
    ) -> u32 {
        let number = object.number();
        let material = match self.material_names.get(&material.number()) {
            Some(name) => name.clone(),
            None => format!("material {}", material.number()),
        };
        self.labels.resize_with(number as usize + 1, Label::default);
        let node = node.unwrap_or_else(|| format!("object {number}"));
        self.labels[number as usize] = Label { node, mesh, material, path: String::new() };
        number
    }
}

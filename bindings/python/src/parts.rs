//! What a scene is made of.

use crate::arrays::refused;
use crate::camera::{Camera, View};
use crate::forked::PerProcess;
use crate::numbers::Numbers;
use crate::objects::Objects;
use glam::DVec3;
use pyo3::exceptions::{PyIndexError, PyValueError};
use pyo3::prelude::*;
use rtrt::import::{Animation, Label, Loaded, NamedCamera, framing};
use rtrt_core::query::Tree;
use rtrt_core::scene::{Bvh, InstanceIndex, MaterialIndex, Mesh, MeshIndex, Scene, SceneError, Texture};
use rtrt_cpu::Parallel;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Mutex;

/// A mesh that was added: where the scene has it, and what it is called.
#[derive(Clone)]
pub struct NamedMesh {
    pub index: MeshIndex,
    pub name: String,
}

/// What a scene is made of.
pub struct Parts {
    pub scene: Scene,
    pub tree: PerProcess<Mutex<Tree>>,
    pub objects: Objects,
    pub meshes: Numbers<NamedMesh>,
    pub materials: BTreeMap<u32, MaterialIndex>,
    pub textures: Vec<Texture>,
    pub material_names: BTreeMap<u32, String>,
    /// What coordinates are relative to, in those of the file.
    pub origin: DVec3,
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
        let own_lights = !scene.lights().is_empty();
        let mut found = Self { own_lights, ..Self::around(scene, labels) };
        for (number, instance) in found.scene.instances().iter().enumerate() {
            let index = found.scene.instance_index(number as u32);
            if let Some(material) = index.and_then(|index| found.scene.material_of(index)) {
                found.materials.insert(instance.material, material);
            }
        }
        (found.cameras, found.animation) = (cameras, animation);
        found.origin = origin;
        (found.warnings, found.files) = (warnings, files);
        found
    }

    /// Those of a scene of which nothing else is known than the labels of its instances.
    pub fn around(scene: Scene, labels: Vec<Label>) -> Self {
        Self {
            objects: Objects::new(&scene, labels),
            scene,
            tree: PerProcess::new(),
            meshes: Numbers::new("mesh", ", as added by add_mesh"),
            materials: BTreeMap::new(),
            textures: vec![],
            material_names: BTreeMap::new(),
            origin: DVec3::ZERO,
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

    /// The material with a number.
    pub fn material_index(&self, number: i64) -> PyResult<MaterialIndex> {
        u32::try_from(number).ok().and_then(|number| self.materials.get(&number)).copied().ok_or_else(|| {
            PyIndexError::new_err(format!(
                "no material {number} was added, or is that of an object of the file"
            ))
        })
    }

    /// Adds an object as `add` adds it to the scene, and returns its number. Without a name it is called by that.
    pub fn add_object(
        &mut self,
        name: Option<String>,
        mesh: String,
        material: MaterialIndex,
        add: impl FnOnce(&mut Scene) -> Result<InstanceIndex, SceneError>,
    ) -> PyResult<i32> {
        let number = self.objects.next()?;
        let index = add(&mut self.scene).map_err(refused)?;
        let material = match self.material_names.get(&material.number()) {
            Some(name) => name.clone(),
            None => format!("material {}", material.number()),
        };
        let node = name.unwrap_or_else(|| format!("object {number}"));
        Ok(self.objects.add(index, Label { node, mesh, material, path: String::new() }))
    }

    /// Removes the object with a number.
    pub fn remove_object(&mut self, number: i64) -> PyResult<()> {
        let index = self.objects.index(&self.scene, number)?;
        self.scene.remove_instance(index).map_err(refused)?;
        self.objects.remove(number);
        Ok(())
    }

    /// Adds a mesh, and returns its number. Without a name it is called by that.
    pub fn add_mesh(&mut self, mesh: &Mesh, name: Option<String>) -> PyResult<i32> {
        let number = self.meshes.next()?;
        let index = self.scene.add_mesh(mesh, &Bvh::build(mesh, &Parallel)).map_err(refused)?;
        let name = name.unwrap_or_else(|| format!("mesh {number}"));
        Ok(self.meshes.add(NamedMesh { index, name }))
    }

    /// Removes the mesh with a number.
    pub fn remove_mesh(&mut self, number: i64) -> PyResult<()> {
        let index = self.meshes.get(number)?.index;
        self.scene.remove_mesh(index).map_err(|error| match error {
            SceneError::InUse { instances, .. } => PyValueError::new_err(format!(
                "mesh {number} is in use, number of its objects: {instances}; remove those first"
            )),
            error => refused(error),
        })?;
        self.meshes.remove(number);
        Ok(())
    }
}

//! A builder for the scenes in code.

use super::shape::Shape;
use crate::import::builder::Builder;
use crate::import::{ImportError, Label, Loaded, NamedCamera, Options};
use glam::{DVec3, Mat4};
use rtrt_core::layout::Texture;
use rtrt_core::scene::{Camera, Image, InstanceIndex, Join, Material, MaterialIndex, MeshIndex, Scene};
use std::path::Path;

/// A finished scene with one camera.
pub(super) fn loaded(
    scene: Scene,
    labels: Vec<Label>,
    name: &str,
    camera: Camera,
    bvh_build_ms: f64,
) -> Loaded {
    Loaded {
        scene,
        origin: DVec3::ZERO,
        cameras: vec![NamedCamera { name: name.into(), camera, aspect: None, clip: [0.0, f32::INFINITY] }],
        camera,
        labels,
        animation: None,
        warnings: Vec::new(),
        files: Vec::new(),
        bvh_build_ms,
    }
}

/// A scene that is being built.
pub(super) struct DemoBuilder<'a, J> {
    pub builder: Builder<'a, J>,
    name: &'static str,
}

impl<'a, J: Join> DemoBuilder<'a, J> {
    /// An empty scene. `name` is for messages.
    pub fn new(name: &'static str, join: &'a J) -> Self {
        Self { builder: Builder::new(Path::new(name), join, &Options::default()), name }
    }

    /// A texture of what is painted.
    pub fn texture(&mut self, paint: impl FnOnce(&J) -> Image) -> Result<Texture, ImportError> {
        self.builder.add_texture("painted", Ok(paint(self.builder.join)))
    }

    /// A material with this name, color, roughness and texture.
    pub fn material(
        &mut self,
        name: &str,
        color: [f32; 3],
        roughness: f32,
        texture: Texture,
    ) -> Result<MaterialIndex, ImportError> {
        self.named(name, Material::new(color).roughness(roughness).base_color_map(texture))
    }

    /// A material without a texture.
    pub fn painted(
        &mut self,
        name: &str,
        color: [f32; 3],
        roughness: f32,
    ) -> Result<MaterialIndex, ImportError> {
        self.named(name, Material::new(color).roughness(roughness))
    }

    /// A material with this name.
    pub fn named(&mut self, name: &str, material: Material) -> Result<MaterialIndex, ImportError> {
        let material = self.builder.add_material(material)?;
        self.builder.name_material(name.into());
        Ok(material)
    }

    /// Stores a mesh.
    pub fn mesh(&mut self, shape: Shape) -> Result<MeshIndex, ImportError> {
        self.builder.add_mesh(self.name, shape.0)
    }

    /// Places a mesh; both have names.
    pub fn place(
        &mut self,
        [node, name]: [&str; 2],
        mesh: MeshIndex,
        material: MaterialIndex,
        at: Mat4,
    ) -> Result<Option<InstanceIndex>, ImportError> {
        let object = self.builder.add_instance(self.name, mesh, material, at)?;
        if let Some(object) = object {
            self.builder.label(object, node.into(), name.into());
        }
        Ok(object)
    }

    /// Places a sphere.
    pub fn sphere(
        &mut self,
        name: &str,
        material: MaterialIndex,
        at: Mat4,
    ) -> Result<InstanceIndex, ImportError> {
        let added = self.builder.scene.add_sphere(material, at);
        let object = added.map_err(|source| ImportError::Scene { path: self.name.into(), source })?;
        self.builder.label(object, name.into(), "sphere".into());
        Ok(object)
    }

    /// Stores a mesh and places it once, in world coordinates, by the same name.
    pub fn add(&mut self, name: &str, shape: Shape, material: MaterialIndex) -> Result<(), ImportError> {
        let mesh = self.mesh(shape)?;
        self.place([name; 2], mesh, material, Mat4::IDENTITY)?;
        Ok(())
    }
}

//! A builder for the scenes in code.

use super::shape::Shape;
use crate::import::builder::Builder;
use crate::import::{ImportError, Loaded, NamedCamera, Options};
use glam::{DVec3, Mat4};
use rtrt_core::layout::Texture;
use rtrt_core::scene::{Camera, Image, Join, Material, MaterialIndex, MeshIndex, Scene};
use std::path::Path;

/// A finished scene with one camera.
pub(super) fn loaded(scene: Scene, name: &str, camera: Camera, bvh_build_ms: f64) -> Loaded {
    Loaded {
        scene,
        origin: DVec3::ZERO,
        cameras: vec![NamedCamera { name: name.into(), camera, aspect: None, clip: [0.0, f32::INFINITY] }],
        camera,
        labels: Vec::new(),
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

    /// A texture from an image that was computed.
    pub fn texture(&mut self, image: Image) -> Result<Texture, ImportError> {
        self.builder.add_texture("painted", Ok(image))
    }

    /// A material with this color, roughness and texture.
    pub fn material(
        &mut self,
        color: [f32; 3],
        roughness: f32,
        texture: Texture,
    ) -> Result<MaterialIndex, ImportError> {
        self.builder.add_material(Material::new(color).roughness(roughness).base_color_map(texture))
    }

    /// A material without a texture.
    pub fn painted(&mut self, color: [f32; 3], roughness: f32) -> Result<MaterialIndex, ImportError> {
        self.builder.add_material(Material::new(color).roughness(roughness))
    }

    /// Stores a mesh.
    pub fn mesh(&mut self, shape: Shape) -> Result<MeshIndex, ImportError> {
        self.builder.add_mesh(self.name, shape.0)
    }

    /// Places a mesh.
    pub fn place(&mut self, mesh: MeshIndex, material: MaterialIndex, at: Mat4) -> Result<(), ImportError> {
        self.builder.add_instance(self.name, mesh, material, at)?;
        Ok(())
    }

    /// Stores a mesh and places it once, in world coordinates.
    pub fn add(&mut self, shape: Shape, material: MaterialIndex) -> Result<(), ImportError> {
        let mesh = self.mesh(shape)?;
        self.place(mesh, material, Mat4::IDENTITY)
    }
}

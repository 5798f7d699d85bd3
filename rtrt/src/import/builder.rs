//! What both formats fill: a scene, within limits, with warnings.

use super::file::Files;
use super::geometry::{Geometry, Tangents};
use super::{ImportError, picture};
use crate::cache::Cache;
use rtrt_core::layout::{Texture, Wrap};
use rtrt_core::scene::{
    Bvh, Content, Image, InstanceIndex, Join, Material, MaterialIndex, Mesh, MeshError, MeshIndex, Scene,
    SceneError,
};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// The most triangles that a scene may store: 67 million.
const TRIANGLES: u64 = 1 << 26;
/// The most objects that a scene may place: 4 million.
const OBJECTS: u64 = 1 << 22;
/// The most texels that all textures may have at full size: 4 GiB of them.
const TEXELS: u64 = 1 << 30;
/// Trees of fewer triangles are built faster than files are opened.
const WORTH_KEEPING: usize = 1000;
/// The most warnings.
const WARNINGS: usize = 40;
/// The most vertices that meshes which change their shape may have, once for each target: at
/// some 30 bytes each, 2 GB.
const DEFORMED: u64 = 1 << 26;

/// A scene in the making.
pub(crate) struct Builder<'a, J> {
    pub scene: Scene,
    pub warnings: Vec<String>,
    /// Kinds of things that the file has and the renderer does not draw.
    pub not_drawn: BTreeSet<&'static str>,
    pub bvh_build_ms: f64,
    /// The file, for messages.
    pub path: PathBuf,
    /// What was read.
    pub files: Files,
    join: &'a J,
    cache: Option<&'a Cache>,
    texels: u64,
    deformed: u64,
}

impl<'a, J: Join> Builder<'a, J> {
    pub fn new(path: &Path, join: &'a J, cache: Option<&'a Cache>) -> Self {
        Self {
            scene: Scene::new(),
            warnings: Vec::new(),
            not_drawn: BTreeSet::new(),
            bvh_build_ms: 0.0,
            path: path.to_owned(),
            files: Files::default(),
            join,
            cache,
            texels: 0,
            deformed: 0,
        }
    }

    /// Says something that the user should know, once; a file with very much wrong does
    /// not drown the rest.
    pub fn warn(&mut self, warning: String) {
        if self.warnings.len() < WARNINGS && !self.warnings.contains(&warning) {
            self.warnings.push(warning);
            if self.warnings.len() == WARNINGS {
                self.warnings.push("further warnings are not shown".into());
            }
        }
    }

    /// The file breaks a rule.
    pub fn invalid(&self, why: String) -> ImportError {
        ImportError::Invalid { path: self.path.clone(), why }
    }

    fn limit(&self, what: &'static str, limit: u64) -> ImportError {
        ImportError::Limit { path: self.path.clone(), what, limit }
    }

    /// Checks a mesh, builds its tree and adds it. `name` is for messages.
    pub fn add_mesh(&mut self, name: &str, geometry: Geometry) -> Result<MeshIndex, ImportError> {
        let refused =
            |source: MeshError| ImportError::Mesh { path: self.path.clone(), mesh: name.into(), source };
        let Geometry { positions, attributes, indices, second_uv, tangents, deform: _ } = geometry;
        let mut mesh = Mesh::new(positions, attributes, indices).map_err(refused)?;
        if let Some(uv) = second_uv {
            mesh = mesh.with_second_uv(uv).map_err(refused)?;
        }
        mesh = match tangents {
            Tangents::None => mesh,
            Tangents::Given(tangents) => mesh.with_tangents(&tangents).map_err(refused)?,
            Tangents::Made { second } => mesh.with_made_tangents(second),
        };
        if self.scene.triangles() + mesh.triangles() as u64 > TRIANGLES {
            return Err(self.limit("triangles", TRIANGLES));
        }
        let start = Instant::now();
        let tree = match self.cache.filter(|_| mesh.triangles() >= WORTH_KEEPING) {
            Some(cache) => cache.tree(&mesh, self.join).unwrap_or_else(|(tree, error)| {
                self.warn(format!("a mesh's tree is not kept for the next time: {error}"));
                tree
            }),
            None => Bvh::build(&mesh, self.join),
        };
        self.bvh_build_ms += start.elapsed().as_secs_f64() * 1e3;
        let path = &self.path;
        self.scene.add_mesh(&mesh, &tree).map_err(|source| ImportError::Scene { path: path.clone(), source })
    }

    /// Adds a material.
    pub fn add_material(&mut self, material: Material) -> Result<MaterialIndex, ImportError> {
        let path = &self.path;
        self.scene.add_material(material).map_err(|source| ImportError::Scene { path: path.clone(), source })
    }

    /// Whether there is room for so many more vertices that change their places.
    pub fn deform(&mut self, vertices: u64) -> Result<(), ImportError> {
        self.deformed = self.deformed.saturating_add(vertices);
        if self.deformed > DEFORMED { Err(self.limit("vertices that change", DEFORMED)) } else { Ok(()) }
    }

    /// Places a mesh. One whose transform cannot be inverted has no volume to be seen: it
    /// is left out with a warning.
    pub fn add_instance(
        &mut self,
        name: &str,
        mesh: MeshIndex,
        material: MaterialIndex,
        to_world: glam::Mat4,
    ) -> Result<Option<InstanceIndex>, ImportError> {
        if self.scene.instances().len() as u64 >= OBJECTS {
            return Err(self.limit("objects", OBJECTS));
        }
        match self.scene.add_instance(mesh, material, to_world) {
            Ok(object) => Ok(Some(object)),
            Err(SceneError::Transform) => {
                self.warn(format!("{name} is left out: its transform cannot be inverted"));
                Ok(None)
            }
            Err(source) => Err(ImportError::Scene { path: self.path.clone(), source }),
        }
    }

    /// Places a mesh that will move. One whose transform cannot be inverted is there, and hidden
    /// until it has another.
    pub fn add_moving(
        &mut self,
        name: &str,
        mesh: MeshIndex,
        material: MaterialIndex,
        to_world: glam::Mat4,
    ) -> Result<InstanceIndex, ImportError> {
        let refused = |path: &Path, source| ImportError::Scene { path: path.to_owned(), source };
        if to_world.as_dmat4().determinant() != 0.0
            && let Some(object) = self.add_instance(name, mesh, material, to_world)?
        {
            return Ok(object);
        }
        let object = self.scene.add_instance(mesh, material, glam::Mat4::IDENTITY);
        let object = object.map_err(|source| refused(&self.path, source))?;
        self.scene.hide(object).map_err(|source| refused(&self.path, source))?;
        Ok(object)
    }

    /// Adds a texture. One that could not be read becomes a checker of magenta and black,
    /// with a warning. `name` is for messages.
    pub fn add_texture(&mut self, name: &str, image: Result<Image, String>) -> Result<Texture, ImportError> {
        self.add_map(name, image, Content::Color)
    }

    /// The same for a texture of colors or of numbers.
    pub fn add_map(
        &mut self,
        name: &str,
        image: Result<Image, String>,
        content: Content,
    ) -> Result<Texture, ImportError> {
        let image = image.unwrap_or_else(|why| {
            self.warn(format!("texture {name} is drawn as a magenta checker: {why}"));
            picture::placeholder()
        });
        self.texels += u64::from(image.width) * u64::from(image.height);
        if self.texels > TEXELS {
            return Err(self.limit("texels", TEXELS));
        }
        let path = &self.path;
        self.scene
            .add_map(&image, [Wrap::Repeat; 2], content)
            .map_err(|source| ImportError::Scene { path: path.clone(), source })
    }
}

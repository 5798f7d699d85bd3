//! The scene that an import fills, with limits and warnings.

use super::file::Files;
use super::geometry::{Geometry, Tangents};
use super::origin::Bounds;
use super::{ImportError, Label, Options, picture};
use crate::cache::Cache;
use glam::DVec3;
use rtrt_core::layout::{Texture, Wrap};
use rtrt_core::scene::{
    Bvh, Content, Image, InstanceIndex, Join, Material, MaterialIndex, Mesh, MeshError, MeshIndex, Scene,
    SceneError,
};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use web_time::Instant;

/// The limit of stored triangles: 67 million.
const TRIANGLES: u64 = 1 << 26;
/// The limit of instances: 4 million.
const OBJECTS: u64 = 1 << 22;
/// The limit of texels of all textures at full size: 4 GiB.
const TEXELS: u64 = 1 << 30;
/// The triangles from which on a BVH is cached. A smaller one is built faster than a file is opened.
const LEAST_CACHED: usize = 1000;
/// The limit of warnings.
const WARNINGS: usize = 40;
/// The limit of vertices of deformed meshes, counted once for each morph target: 2 GB at about
/// 30 bytes each.
const DEFORMED: u64 = 1 << 26;

/// A scene that is being imported.
pub(crate) struct Builder<'a, J> {
    pub scene: Scene,
    pub warnings: Vec<String>,
    /// Features of the file that the renderer does not have.
    pub not_drawn: BTreeSet<&'static str>,
    pub bvh_build_ms: f64,
    /// What is subtracted from the file's coordinates.
    pub origin: DVec3,
    /// The meshes whose vertices are coarse: how many; and of the coarsest its name, the distance between numbers, and how
    /// many of them lie along its diagonal.
    coarse: (usize, Option<(String, f64, f64)>),
    /// The diameter of points and lines, in units of the scene, if the caller sets it.
    pub point_size: Option<f32>,
    /// The names of materials, by number.
    materials: Vec<String>,
    labels: Vec<Label>,
    /// The scene's file.
    pub path: PathBuf,
    /// The files that were read.
    pub files: Files,
    /// Runs the halves of work, in parallel if there are threads.
    pub join: &'a J,
    cache: Option<&'a Cache>,
    texels: u64,
    deformed: u64,
}

impl<'a, J: Join> Builder<'a, J> {
    pub fn new(path: &Path, join: &'a J, options: &Options<'a>) -> Self {
        Self {
            scene: Scene::new(),
            warnings: Vec::new(),
            not_drawn: BTreeSet::new(),
            bvh_build_ms: 0.0,
            origin: DVec3::ZERO,
            coarse: (0, None),
            point_size: options.point_size,
            materials: Vec::new(),
            labels: Vec::new(),
            path: path.to_owned(),
            files: Files::default(),
            join,
            cache: options.cache,
            texels: 0,
            deformed: 0,
        }
    }

    /// Adds a warning, unless the same one or too many are there.
    pub fn warn(&mut self, warning: String) {
        if self.warnings.len() < WARNINGS && !self.warnings.contains(&warning) {
            self.warnings.push(warning);
            if self.warnings.len() == WARNINGS {
                self.warnings.push("further warnings are not shown".into());
            }
        }
    }

    /// Warns of meshes whose vertices are far from the origin of their coordinates, for their size.
    pub fn warn_of_coarse_meshes(&mut self) {
        if let (count, Some((name, step, steps))) = std::mem::take(&mut self.coarse) {
            let others =
                if count > 1 { format!(", and those of {} other meshes", count - 1) } else { String::new() };
            self.warn(format!(
                "the vertices of {name} are coarse{others}: so far from the origin of their coordinates, numbers are {step} \
                 apart, 1/{steps:.0} of its size"
            ));
        }
    }

    /// The error of a file that breaks a rule of its format.
    pub fn invalid(&self, why: String) -> ImportError {
        ImportError::Invalid { path: self.path.clone(), why }
    }

    fn limit(&self, what: &'static str, limit: u64) -> ImportError {
        ImportError::Limit { path: self.path.clone(), what, limit }
    }

    /// Checks a mesh, builds its BVH and adds both. `name` is for messages.
    pub fn add_mesh(&mut self, name: &str, geometry: Geometry) -> Result<MeshIndex, ImportError> {
        let refused =
            |source: MeshError| ImportError::Mesh { path: self.path.clone(), mesh: name.into(), source };
        let Geometry { positions, attributes, indices, second_uv, tangents, deform: _ } = geometry;
        let coarseness = Bounds::of(&positions).coarseness();
        let mut mesh = Mesh::new(positions, attributes, indices).map_err(refused)?;
        if let Some((step, steps)) = coarseness {
            self.coarse.0 += 1;
            if self.coarse.1.as_ref().is_none_or(|(_, _, fewest)| steps < *fewest) {
                self.coarse.1 = Some((name.into(), step, steps));
            }
        }
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
        let tree = match self.cache.filter(|_| mesh.triangles() >= LEAST_CACHED) {
            Some(cache) => cache.tree(&mesh, self.join).unwrap_or_else(|(tree, error)| {
                self.warn(format!("a mesh's BVH is not cached: {error}"));
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

    /// Adds a copy of a material that shows its base color as it is, without light.
    pub fn add_unlit(&mut self, material: MaterialIndex) -> Result<MaterialIndex, ImportError> {
        let unlit = self.scene.material(material).cloned().unwrap_or_default().unlit(true);
        let name = self.materials.get(material.number() as usize).cloned().unwrap_or_default();
        let unlit = self.add_material(unlit)?;
        self.name_material(name);
        Ok(unlit)
    }

    /// Names the material that was added last.
    pub fn name_material(&mut self, name: String) {
        self.materials.resize(self.scene.materials().len(), String::new());
        self.materials.last_mut().into_iter().for_each(|last| last.clone_from(&name));
    }

    /// Labels an instance with the names of its node and mesh, and of its material.
    pub fn label(&mut self, object: InstanceIndex, node: String, mesh: String) {
        let number = object.number() as usize;
        let material = self.scene.instances().get(number).map_or(0, |instance| instance.material as usize);
        let material = self.materials.get(material).cloned().unwrap_or_default();
        self.labels.resize(self.scene.instances().len(), Label::default());
        self.labels[number] = Label { node, mesh, material, path: String::new() };
    }

    /// Says which nodes are above that of a labeled instance.
    pub fn set_path(&mut self, object: InstanceIndex, path: &str) {
        if let Some(label) = self.labels.get_mut(object.number() as usize) {
            label.path = path.into();
        }
    }

    /// Labels an instance that is all there is of a kind in a file whose objects have no names.
    pub fn label_file(&mut self, object: Option<InstanceIndex>, mesh: &str) {
        if let Some(object) = object {
            self.label(object, self.stem(), mesh.into());
        }
    }

    /// What a scene without a name of its own is called: its file without folder and ending.
    fn stem(&self) -> String {
        let stem = self.path.file_stem().unwrap_or_default().to_string_lossy();
        if stem == "-" { "stdin".into() } else { stem.into_owned() }
    }

    /// The labels of all instances.
    pub fn labels(&mut self) -> Vec<Label> {
        self.labels.resize(self.scene.instances().len(), Label::default());
        std::mem::take(&mut self.labels)
    }

    /// Counts vertices of deformed meshes against their limit.
    pub fn count_deformed(&mut self, vertices: u64) -> Result<(), ImportError> {
        self.deformed = self.deformed.saturating_add(vertices);
        if self.deformed > DEFORMED {
            Err(self.limit("vertices of deformed meshes", DEFORMED))
        } else {
            Ok(())
        }
    }

    /// Places a mesh; none, with a warning, if its transform has no inverse and so nothing of it is visible.
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
                self.warn(format!("{name} is left out: its transform has no inverse"));
                Ok(None)
            }
            Err(source) => Err(ImportError::Scene { path: self.path.clone(), source }),
        }
    }

    /// Places a mesh that moves. Without an inverse of its transform it is hidden until it has another one.
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

    /// Adds a texture of colors. In place of one that cannot be read there is a checker of magenta and
    /// black, with a warning. `name` is for messages.
    pub fn add_texture(&mut self, name: &str, image: Result<Image, String>) -> Result<Texture, ImportError> {
        self.add_map(name, image, Content::Color)
    }

    /// [`Self::add_texture`] for colors or numbers.
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
            .add_map_with(&image, [Wrap::Repeat; 2], content, self.join)
            .map_err(|source| ImportError::Scene { path: path.clone(), source })
    }
}

//! Textures and environments in the scene's texels.

use super::{Scene, SceneError};
use crate::layout::{Sky, Texture, Wrap};
use crate::scene::{Content, Cube, Image, Join, Panorama, Sequential};
use alloc::vec::Vec;

impl Scene {
    /// Adds a texture of colors: its mip chain is built here.
    ///
    /// # Errors
    /// The image is not usable, or the scene is full.
    pub fn add_texture(&mut self, image: &Image, wrap: [Wrap; 2]) -> Result<Texture, SceneError> {
        self.add_map(image, wrap, Content::Color)
    }

    /// Adds a texture of colors or of numbers.
    ///
    /// # Errors
    /// As for [`Scene::add_texture`].
    pub fn add_map(
        &mut self,
        image: &Image,
        wrap: [Wrap; 2],
        content: Content,
    ) -> Result<Texture, SceneError> {
        self.add_map_with(image, wrap, content, &Sequential)
    }

    /// [`Scene::add_map`] whose mip chain workers of `join` build. It does not depend on them.
    ///
    /// # Errors
    /// As for [`Scene::add_texture`].
    pub fn add_map_with(
        &mut self,
        image: &Image,
        wrap: [Wrap; 2],
        content: Content,
        join: &impl Join,
    ) -> Result<Texture, SceneError> {
        if self.texels.len() + image.rgba.len() / 2 > u32::MAX as usize {
            return Err(SceneError::TooLarge { what: "texels" });
        }
        self.versions.texels += 1;
        Ok(image.append(wrap, content, &mut self.texels, join)?)
    }

    /// Surrounds the scene with an environment. It is behind all surfaces (but see [`Scene::backdrop`]), is
    /// reflected by them, and replaces the ambient light. An earlier environment stays in memory, unused.
    ///
    /// # Errors
    /// The panorama is not usable, or the scene is full.
    pub fn set_environment(&mut self, panorama: &Panorama) -> Result<(), SceneError> {
        self.surround(|texels| Ok(panorama.append(texels)?))
    }

    /// [`Scene::set_environment`] with a cube.
    ///
    /// # Errors
    /// The cube is not usable, or the scene is full.
    pub fn set_cube(&mut self, cube: &Cube) -> Result<(), SceneError> {
        self.surround(|texels| Ok(cube.append(texels)?))
    }

    /// Takes the environment away: ambient light replaces it, and the background's color is behind all surfaces. It stays
    /// in memory, unused.
    pub fn remove_environment(&mut self) {
        self.sky = Sky::default();
    }

    fn surround(
        &mut self,
        append: impl FnOnce(&mut Vec<u32>) -> Result<Sky, SceneError>,
    ) -> Result<(), SceneError> {
        // A square of at most 1024 texels a side, and less than as many again for the others.
        if self.texels.len() + (1 << 21) > u32::MAX as usize {
            return Err(SceneError::TooLarge { what: "texels" });
        }
        self.sky = append(&mut self.texels)?;
        self.versions.texels += 1;
        Ok(())
    }
}

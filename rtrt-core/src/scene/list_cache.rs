//! Which lists of the last frame a frame can reuse.
//!
//! Lists depend on the scene, the instances and lights in it, and the magnitude that rounding errors
//! are relative to; those of the camera also on the camera. Reused lists equal the lists that would be
//! built. A GPU leaves them in place: blocks of lights come before those of the camera, whose lists may
//! change their length. The CPU builds the camera's for each frame.

use crate::layout::{Frame, View};
use crate::scene::{Occluders, Scene, Setup, Versions};
use alloc::vec::Vec;

/// The lists of the last frame that a frame reuses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ReusableLists {
    /// None.
    Nothing,
    /// Those of all lights.
    Lights,
    /// All.
    All,
}

/// The key of the lists of the last frame. A backend that reuses lists has one.
#[derive(Debug, Default)]
pub struct ListCacheKey {
    /// The scene, its versions, the revision of its levels of detail, and the bits of the frame's magnitude.
    scene: Option<(u32, Versions, u32, u32)>,
    /// See [`Setup::cut_triangles`].
    parts: Option<u32>,
    views: Vec<View>,
}

impl ListCacheKey {
    /// The lists that this frame shares with the frame of the last call, if all of that frame's were built.
    /// Lists of lights depend on the camera if [`Occluders`] does.
    pub fn reusable(&mut self, setup: &Setup, scene: &Scene) -> ReusableLists {
        let source =
            Some((scene.id(), scene.versions(), setup.lod_revision(), setup.frame.magnitude.to_bits()));
        let is_same_scene = self.scene == source;
        let first_light = Frame::CAMERA as usize + 1;
        let is_same_camera =
            is_same(&self.views, &setup.views, 0..first_light) && self.parts == setup.cut_triangles();
        let are_same_lights = self.views.len() == setup.views.len()
            && is_same(&self.views, &setup.views, first_light..setup.views.len());
        self.scene = source;
        self.parts = setup.cut_triangles();
        if are_same_lights {
            self.views[..first_light].copy_from_slice(&setup.views[..first_light]);
        } else {
            self.views.clone_from(&setup.views);
        }
        match (is_same_scene && are_same_lights, is_same_camera) {
            (true, true) => ReusableLists::All,
            (true, false) if scene.occluders == Occluders::All => ReusableLists::Lights,
            _ => ReusableLists::Nothing,
        }
    }
}

/// Whether a range of views is equal, bit for bit.
fn is_same(a: &[View], b: &[View], range: core::ops::Range<usize>) -> bool {
    let [a, b] = [a, b].map(|views| views.get(range.clone()).map(bytemuck::cast_slice::<View, u8>));
    a == b
}

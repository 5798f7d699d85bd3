//! What every stage that traces rays reads.

use crate::kernel::geometry::Geometry;
use crate::kernel::lists::BlockLists;
use crate::layout::{Attribute, Frame, View};
use crate::stage::surface::Vertices;

/// The data that stages read: a frame's numbers, its views, the lists of their blocks, and the geometry.
#[derive(Clone, Copy)]
pub struct Context<'a> {
    /// The frame, or a band or a layer of it.
    pub frame: &'a Frame,
    /// The camera's view, then those of lights.
    pub views: &'a [View],
    /// The instances in each block of each view.
    pub lists: BlockLists<'a>,
    /// The instances.
    pub geometry: Geometry<'a>,
}

impl<'a> Context<'a> {
    /// The camera's view.
    #[inline(always)]
    pub fn camera(&self) -> &'a View {
        &self.views[Frame::CAMERA as usize]
    }

    /// The first view of a light.
    #[inline(always)]
    pub fn light(&self, light: u32) -> &'a View {
        &self.views[self.frame.light_view(light) as usize]
    }

    /// All that is known of vertices but their positions.
    #[inline(always)]
    pub fn vertices(&self, attributes: &'a [Attribute]) -> Vertices<'a> {
        Vertices { instances: self.geometry.instances, mesh_data: self.geometry.mesh_data, attributes }
    }
}

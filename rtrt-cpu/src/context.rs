//! What every block of a frame shares.

use rtrt_core::kernel::texture::Maps;
use rtrt_core::layout::Attribute;
use rtrt_core::stage::context::Context;

/// What every block of a frame shares.
pub struct FrameContext<'a> {
    /// What stages read that trace rays.
    pub trace: Context<'a>,
    pub attributes: &'a [Attribute],
    pub maps: Maps<'a>,
}

//! What backends share in memory, declared once: sizes and offsets are checked here by
//! the compiler and, on a device, by the conformance suite.

mod geometry;
mod hit;
mod material;
mod probe;
mod query;
mod shadow_buffer;
mod transparency;
mod view;

pub use geometry::{Attribute, Instance, Kind, Node};
pub use hit::{Hit, Lit, NONE, Surface};
pub use material::{AlphaKind, COLOR_LIMIT, Filter, LIGHT_LIMIT, MaterialRecord, Texture, Wrap};
#[doc(hidden)]
pub use probe::{PROBES, probe};
pub use query::{QueryFrame, RayRecord};
pub use shadow_buffer::ShadowBuffer;
pub use transparency::{FinestLevel, Transparency, TransparencyVertex};
pub use view::{Backdrop, Frame, ShadowKind, Sky, ToneMap, View, ViewKind};

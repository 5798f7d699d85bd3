//! Rays of programs, as devices read them, and the numbers of their scene.

use bytemuck::{Pod, Zeroable};
use core::mem::offset_of;

/// A ray of a batch.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct RayRecord {
    /// The start, within ±2³⁰.
    pub origin: [f32; 3],
    /// The least `t`.
    pub from: f32,
    /// The largest component within 2⁻³² ..= 2³², in magnitude; a ray with another direction hits nothing.
    pub direction: [f32; 3],
    /// The largest `t`; a finite number.
    pub to: f32,
    /// The groups of instances that count.
    pub mask: u32,
    /// The number of an instance that does not count, or [`NONE`](crate::layout::NONE).
    pub skip: u32,
    /// The sides that count ([`RayRecord::BOTH`] and so on), plus [`RayRecord::THROUGH_HOLES`].
    pub options: u32,
    /// 0.
    pub unused: u32,
}
const _: () = assert!(size_of::<RayRecord>() == 48 && offset_of!(RayRecord, mask) == 32);

impl RayRecord {
    /// Fronts and backs.
    pub const BOTH: u32 = 0;
    /// Fronts.
    pub const FRONTS: u32 = 1;
    /// Backs.
    pub const BACKS: u32 = 2;
    /// Fronts, and backs of what is double-sided.
    pub const DRAWN: u32 = 3;
    /// The ray passes the holes that masks cut.
    pub const THROUGH_HOLES: u32 = 4;
}

/// What all rays of a batch share.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct QueryFrame {
    /// The rays.
    pub rays: u32,
    /// The root of the tree over the instances, among the nodes.
    pub root: u32,
    /// The largest coordinate of the instances.
    pub magnitude: f32,
    /// The largest [`slack`](crate::layout::Instance::slack) of the instances.
    pub slack: f32,
}
const _: () = assert!(size_of::<QueryFrame>() == 16);

//! The SPIR-V entry points of rtrt, and the module compiled from them.
//!
//! An entry point unpacks its bindings, checks bounds and makes one call into `rtrt-core`. rust-gpu compiles
//! them; the result is committed beside the sources and embedded as [`SPIRV`], so that nobody needs the shader
//! compiler to build or run rtrt. After a change here or in `rtrt-core`, from the root of the repository:
//!
//! ```text
//! cargo run --release --manifest-path rtrt-shaders/builder/Cargo.toml
//! ```
//!
//! Appending `-- --check` compares instead of writing.

#![cfg_attr(target_arch = "spirv", no_std)]

pub mod ambient;
pub mod bin;
pub mod canary;
pub mod detail;
pub mod light;
pub mod occlusion;
pub mod peel;
pub mod penumbra;
pub mod prepare;
pub mod query;
pub mod raster;
pub mod resolve;
pub mod shade;
pub mod share;
pub mod surface;
pub mod transmittance;
pub mod visibility;

#[cfg(feature = "reflect")]
pub mod lint;
#[cfg(feature = "reflect")]
pub mod manifest;
#[cfg(feature = "reflect")]
pub mod reflect;

use spirv_std::glam::UVec3;

/// The compiled module: SPIR-V 1.3, little endian, every float operation decorated `NoContraction`.
#[cfg(not(target_arch = "spirv"))]
pub const SPIRV: &[u8] = include_bytes!("../rtrt.spv");

/// Invocations of a workgroup, in every entry point but `probe_layout`, which runs one.
pub const GROUP: u32 = 64;

/// Invocations in a row of workgroups. A row has as many workgroups as WebGPU allows (65 535); more work takes
/// more rows.
pub const ROW: u32 = 65_535 * GROUP;

/// Invocations that share the work of one cover in `count` and `scatter`.
pub const SHARES: u32 = 8;

/// Invocations that share the blocks in `scan_totals` and `scan`.
pub const SCANNERS: u32 = 256;

/// The number of an invocation.
fn index(id: UVec3) -> u32 {
    id.y * ROW + id.x
}

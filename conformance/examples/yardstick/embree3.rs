//! What examples use of Embree 3: its C interface, and a scene as Embree has it.

use rtrt_core::layout::Instance;
use rtrt_core::scene::Scene;
use std::collections::HashMap;
use std::ffi::{CString, c_char, c_void};

// From rtcore_common.h, rtcore_buffer.h and rtcore_geometry.h of Embree 3.
const TRIANGLES: i32 = 0;
const INSTANCE: i32 = 121;
const INDICES: i32 = 0;
const VERTICES: i32 = 1;
const UINT3: i32 = 0x5003;
const FLOAT3: i32 = 0x9003;
const ROWS_3X4: i32 = 0x9134;
/// `RTC_BUILD_QUALITY_HIGH`.
pub const HIGH: i32 = 2;
/// What a ray has that hits nothing.
pub const NONE: u32 = u32::MAX;

type Handle = *mut c_void;

#[link(name = "embree3")]
unsafe extern "C" {
    fn rtcNewDevice(config: *const c_char) -> Handle;
    fn rtcNewScene(device: Handle) -> Handle;
    fn rtcNewGeometry(device: Handle, kind: i32) -> Handle;
    fn rtcSetNewGeometryBuffer(
        geometry: Handle,
        kind: i32,
        slot: u32,
        format: i32,
        stride: usize,
        count: usize,
    ) -> Handle;
    fn rtcCommitGeometry(geometry: Handle);
    fn rtcAttachGeometry(scene: Handle, geometry: Handle) -> u32;
    fn rtcSetSceneBuildQuality(scene: Handle, quality: i32);
    fn rtcCommitScene(scene: Handle);
    fn rtcSetGeometryInstancedScene(geometry: Handle, scene: Handle);
    fn rtcSetGeometryTransform(geometry: Handle, step: u32, format: i32, matrix: *const c_void);
    pub fn rtcIntersect8(valid: *const i32, scene: Handle, context: *mut Context, rays: *mut Hits8);
    pub fn rtcOccluded8(valid: *const i32, scene: Handle, context: *mut Context, rays: *mut Rays8);
}

/// `RTCIntersectContext`, with room for the optional fields.
#[repr(C, align(16))]
pub struct Context {
    pub flags: i32,
    pub filter: Handle,
    pub instance: u32,
    pub optional: [u32; 12],
}

/// `RTCRay8`.
#[repr(C, align(32))]
#[derive(Clone, Copy)]
pub struct Rays8 {
    pub origin: [[f32; 8]; 3],
    pub near: [f32; 8],
    pub direction: [[f32; 8]; 3],
    pub time: [f32; 8],
    pub far: [f32; 8],
    pub mask: [u32; 8],
    pub id: [u32; 8],
    pub flags: [u32; 8],
}

/// `RTCRayHit8`.
#[repr(C, align(32))]
pub struct Hits8 {
    pub rays: Rays8,
    pub normal: [[f32; 8]; 3],
    pub u: [f32; 8],
    pub v: [f32; 8],
    pub primitive: [u32; 8],
    pub geometry: [u32; 8],
    pub instance: [u32; 8],
}

/// A committed scene, which any thread may trace.
pub struct Committed(pub Handle);
// SAFETY: Embree's scenes are read only after `rtcCommitScene`, from any thread.
unsafe impl Sync for Committed {}

/// The scene as Embree has it: meshes in world space together, the others instanced.
pub fn build(scene: &Scene, config: &CString, quality: i32) -> Committed {
    // SAFETY: handles come from the calls above them; buffers are written within the size
    // that they were made with.
    unsafe {
        let device = rtcNewDevice(config.as_ptr());
        let top = rtcNewScene(device);
        rtcSetSceneBuildQuality(top, quality);
        let mut meshes = HashMap::new();
        for instance in scene.instances() {
            if instance.is_identity == 1 {
                rtcAttachGeometry(top, mesh(device, scene, instance));
                continue;
            }
            let shared = *meshes.entry(instance.root).or_insert_with(|| {
                let shared = rtcNewScene(device);
                rtcSetSceneBuildQuality(shared, quality);
                rtcAttachGeometry(shared, mesh(device, scene, instance));
                rtcCommitScene(shared);
                shared
            });
            let placed = rtcNewGeometry(device, INSTANCE);
            rtcSetGeometryInstancedScene(placed, shared);
            rtcSetGeometryTransform(placed, 0, ROWS_3X4, instance.to_world.as_ptr().cast());
            rtcCommitGeometry(placed);
            rtcAttachGeometry(top, placed);
        }
        rtcCommitScene(top);
        Committed(top)
    }
}

/// The instance's mesh.
///
/// # Safety
/// `device` is a device of Embree's.
unsafe fn mesh(device: Handle, scene: &Scene, instance: &Instance) -> Handle {
    let count = 3 * instance.triangles as usize;
    let indices = &scene.mesh_data()[instance.first_index as usize..][..count];
    let vertices = indices.iter().max().map_or(0, |&most| most as usize + 1);
    // SAFETY: Embree gives buffers of the size asked for.
    unsafe {
        let geometry = rtcNewGeometry(device, TRIANGLES);
        let positions = rtcSetNewGeometryBuffer(geometry, VERTICES, 0, FLOAT3, 12, vertices);
        let from = scene.positions()[instance.first_vertex as usize..].as_ptr();
        std::ptr::copy_nonoverlapping(from, positions.cast(), vertices);
        let words = rtcSetNewGeometryBuffer(geometry, INDICES, 0, UINT3, 12, count / 3);
        std::ptr::copy_nonoverlapping(indices.as_ptr(), words.cast(), count);
        rtcCommitGeometry(geometry);
        geometry
    }
}

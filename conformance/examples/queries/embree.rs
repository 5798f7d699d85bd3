//! Embree 3, ray by ray and in packets of eight.

use crate::embree3::{Committed, Context, HIGH, Hits8, NONE, Rays8, build, rtcIntersect8, rtcOccluded8};
use crate::{Answer, Library, MISS, OneByOne, Single};
use rtrt_core::query::Ray;
use rtrt_core::scene::Scene;
use std::ffi::{CString, c_void};
use std::rc::Rc;
use std::time::Instant;

/// `RTC_BUILD_QUALITY_MEDIUM`.
const MEDIUM: i32 = 1;

unsafe extern "C" {
    fn rtcIntersect1(scene: *mut c_void, context: *mut Context, hit: *mut Hit1);
    fn rtcOccluded1(scene: *mut c_void, context: *mut Context, ray: *mut Ray1);
}

/// `RTCRay`.
#[repr(C, align(16))]
struct Ray1 {
    origin: [f32; 3],
    near: f32,
    direction: [f32; 3],
    time: f32,
    far: f32,
    mask: u32,
    id: u32,
    flags: u32,
}

/// `RTCRayHit`.
#[repr(C, align(16))]
struct Hit1 {
    ray: Ray1,
    normal: [f32; 3],
    u: f32,
    v: f32,
    primitive: u32,
    geometry: u32,
    instance: u32,
}

/// Milliseconds of builds on one thread: of medium and of high quality.
pub struct Builds {
    pub medium: f64,
    pub high: f64,
}

/// Both ways, on a tree of high quality, and what builds cost.
pub fn libraries(scene: &Scene, isa: &str) -> Result<(Vec<Box<dyn Library>>, Builds), std::ffi::NulError> {
    let config = CString::new(format!("threads=1,isa={isa}"))?;
    let timed = |quality| {
        let start = Instant::now();
        let committed = build(scene, &config, quality);
        (committed, start.elapsed().as_secs_f64() * 1e3)
    };
    let (_, medium) = timed(MEDIUM);
    let (committed, high) = timed(HIGH);
    let committed = Rc::new(committed);
    Ok((
        vec![Box::new(OneByOne(Alone(committed.clone()))), Box::new(Packets(committed))],
        Builds { medium, high },
    ))
}

struct Alone(Rc<Committed>);
struct Packets(Rc<Committed>);

fn context() -> Context {
    Context { flags: 0, filter: std::ptr::null_mut(), instance: NONE, optional: [0; 12] }
}

fn record(ray: &Ray) -> Ray1 {
    Ray1 {
        origin: ray.origin,
        near: 0.0,
        direction: ray.direction,
        time: 0.0,
        far: ray.to,
        mask: u32::MAX,
        id: 0,
        flags: 0,
    }
}

impl Single for Alone {
    const NAME: &'static str = "embree";
    fn closest(&self, ray: &Ray) -> Answer {
        let mut hit = Hit1 {
            ray: record(ray),
            normal: [0.0; 3],
            u: 0.0,
            v: 0.0,
            primitive: NONE,
            geometry: NONE,
            instance: NONE,
        };
        // SAFETY: the structures are laid out as Embree's headers say, and aligned.
        unsafe { rtcIntersect1((self.0).0, &mut context(), &mut hit) };
        if hit.geometry == NONE { MISS } else { (hit.ray.far, 0, 0) }
    }
    fn occluded(&self, ray: &Ray) -> Answer {
        let mut ray = record(ray);
        // SAFETY: as above.
        unsafe { rtcOccluded1((self.0).0, &mut context(), &mut ray) };
        if ray.far < 0.0 { (0.0, 0, 0) } else { MISS }
    }
}

/// Eight rays; where there are fewer, the others are not valid.
fn packet(rays: &[Ray]) -> ([i32; 8], Rays8) {
    let mut packet = Rays8 {
        origin: [[0.0; 8]; 3],
        near: [0.0; 8],
        direction: [[1.0; 8]; 3],
        time: [0.0; 8],
        far: [0.0; 8],
        mask: [u32::MAX; 8],
        id: [0; 8],
        flags: [0; 8],
    };
    let mut valid = [0; 8];
    for (lane, ray) in rays.iter().enumerate() {
        valid[lane] = -1;
        packet.far[lane] = ray.to;
        for axis in 0..3 {
            packet.origin[axis][lane] = ray.origin[axis];
            packet.direction[axis][lane] = ray.direction[axis];
        }
    }
    (valid, packet)
}

impl Library for Packets {
    fn name(&self) -> &'static str {
        "embree packets"
    }
    fn closest(&self, rays: &[Ray], answers: &mut [Answer]) {
        for (answers, rays) in answers.chunks_mut(8).zip(rays.chunks(8)) {
            let (valid, rays) = packet(rays);
            let mut hits = Hits8 {
                rays,
                normal: [[0.0; 8]; 3],
                u: [0.0; 8],
                v: [0.0; 8],
                primitive: [NONE; 8],
                geometry: [NONE; 8],
                instance: [NONE; 8],
            };
            // SAFETY: as above.
            unsafe { rtcIntersect8(valid.as_ptr(), (self.0).0, &mut context(), &mut hits) };
            for (lane, answer) in answers.iter_mut().enumerate() {
                *answer = if hits.geometry[lane] == NONE { MISS } else { (hits.rays.far[lane], 0, 0) };
            }
        }
    }
    fn occluded(&self, rays: &[Ray], answers: &mut [Answer]) {
        for (answers, rays) in answers.chunks_mut(8).zip(rays.chunks(8)) {
            let (valid, mut rays) = packet(rays);
            // SAFETY: as above.
            unsafe { rtcOccluded8(valid.as_ptr(), (self.0).0, &mut context(), &mut rays) };
            for (lane, answer) in answers.iter_mut().enumerate() {
                *answer = if rays.far[lane] < 0.0 { (0.0, 0, 0) } else { MISS };
            }
        }
    }
}

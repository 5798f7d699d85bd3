//! Meets a ray with a triangle, without std. A crate that linked std would bring a second
//! panic handler, and this would not compile.
#![no_std]
#![no_main]

use rtrt_core::kernel::ray::Ray;
use rtrt_core::kernel::triangle::{Triangle, intersect};
use rtrt_core::lane::V3;

#[link(name = "c")]
unsafe extern "C" {}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {}
}

// SAFETY: only the prebuilt `core` refers to it, for unwinding, which never happens here.
#[unsafe(no_mangle)]
extern "C" fn rust_eh_personality() {}

// SAFETY: the C runtime calls the one symbol named `main`, and nothing else defines it.
#[unsafe(no_mangle)]
extern "C" fn main() -> i32 {
    let at = |v| V3::<f32>::splat((), v);
    let ray = Ray::new(at([0.25, 0.25, 3.0]), at([0.0, 0.0, -1.0]));
    let triangle = Triangle::new([0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    let found = intersect(&ray, &triangle, &triangle.relative_to(ray.origin), f32::MAX);
    let near = |x: f32, y: f32| (x - y).abs() < 1e-6;
    if found.mask && near(found.t, 3.0) && near(found.u, 0.25) && near(found.v, 0.25) { 0 } else { 1 }
}

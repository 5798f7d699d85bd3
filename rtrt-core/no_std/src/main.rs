//! Asks a ray of a world, without std. A crate that linked std would bring a second panic handler, and this would
//! not compile.
#![no_std]
#![no_main]

use core::alloc::{GlobalAlloc, Layout};
use core::cell::UnsafeCell;
use core::ptr::null_mut;
use core::sync::atomic::{AtomicUsize, Ordering};
use rtrt_core::query::{Ray, Shapes, Tree};
use rtrt_core::scene::Sequential;

#[link(name = "c")]
unsafe extern "C" {}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {}
}

// SAFETY: only the prebuilt `core` refers to it, for unwinding, which never happens here.
#[unsafe(no_mangle)]
extern "C" fn rust_eh_personality() {}

/// Memory that is given away once, from the start to the end.
#[repr(align(64))]
struct Heap(UnsafeCell<[u8; 1 << 20]>);

static HEAP: Heap = Heap(UnsafeCell::new([0; 1 << 20]));
static USED: AtomicUsize = AtomicUsize::new(0);

// SAFETY: no byte is given away twice.
unsafe impl Sync for Heap {}

struct Once;

// SAFETY: what is given away is inside the heap, aligned, and of no one else.
unsafe impl GlobalAlloc for Once {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // The program has one thread, so nobody comes between the load and the store.
        let start = USED.load(Ordering::Relaxed).next_multiple_of(layout.align());
        let end = start + layout.size();
        if end > 1 << 20 || layout.align() > 64 {
            return null_mut();
        }
        USED.store(end, Ordering::Relaxed);
        // SAFETY: the start is inside the heap.
        unsafe { HEAP.0.get().cast::<u8>().add(start) }
    }
    unsafe fn dealloc(&self, _: *mut u8, _: Layout) {}
}

#[global_allocator]
static ALLOCATOR: Once = Once;

/// Whether the ray hits the triangle where it should.
fn hits() -> Option<bool> {
    let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let mut shapes = Shapes::new();
    let mesh = shapes.add_mesh(&positions, &[0, 1, 2], &Sequential).ok()?;
    shapes.add_instance(mesh, glam::Mat4::IDENTITY).ok()?;
    let mut tree = Tree::default();
    let world = tree.world(&shapes);
    let before = USED.load(Ordering::Relaxed);
    let hit = world.closest(&Ray::new([0.25, 0.25, 3.0], [0.0, 0.0, -1.0])).ok()??;
    let near = |x: f32, y: f32| (x - y).abs() < 1e-6;
    let is_right = near(hit.t, 3.0) && near(hit.u, 0.25) && near(hit.v, 0.25);
    Some(is_right && before == USED.load(Ordering::Relaxed))
}

// SAFETY: the C runtime calls the one symbol named `main`, and nothing else defines it.
#[unsafe(no_mangle)]
extern "C" fn main() -> i32 {
    if hits() == Some(true) { 0 } else { 1 }
}

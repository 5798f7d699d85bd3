//! Renders the cases with stored hashes on a processor without an operating system, and compares every buffer with
//! `golden.txt`. Prints a line for each scene; the exit code is 0 if all are equal.
#![no_std]
#![no_main]

extern crate alloc;

use alloc::format;
use alloc::string::String;
use conformance_cases::cases;
use core::fmt::Write;
use core::mem::MaybeUninit;
use core::panic::PanicInfo;
use cortex_m_semihosting::debug::{EXIT_FAILURE, EXIT_SUCCESS, exit};
use cortex_m_semihosting::hprintln;
use embedded_alloc::LlffHeap;
use rtrt_core::backend::{Backend, Picture};
use rtrt_cpu::{Cpu, Options};
use sha2::{Digest, Sha256};

const GOLDEN: &str = include_str!("../../golden.txt");

/// Bytes of the heap.
const SIZE: usize = 14 << 20;

#[global_allocator]
static HEAP: LlffHeap = LlffHeap::empty();

static mut MEMORY: [MaybeUninit<u8>; SIZE] = [MaybeUninit::uninit(); SIZE];

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    hprintln!("{}", info);
    exit(EXIT_FAILURE);
    loop {}
}

#[cortex_m_rt::entry]
fn main() -> ! {
    // SAFETY: this is the only use of the memory, before anything is allocated.
    unsafe { HEAP.init(&raw mut MEMORY as usize, SIZE) }
    let mut scenes = 0;
    let mut different = 0;
    let mut last = "";
    for scene in
        GOLDEN.lines().filter(|line| !line.starts_with('#')).filter_map(|line| line.split(' ').next())
    {
        if core::mem::replace(&mut last, scene) == scene {
            continue;
        }
        // The demo scenes are in a crate that needs an operating system.
        let Some(case) = cases::named(scene) else {
            hprintln!("{}: left out", scene);
            continue;
        };
        let mut cpu = Cpu::new(Options::default()).expect("one lane, no thread");
        let mut picture = Picture::default();
        cpu.render(&(case.scene)(), &case.request(), &mut picture).expect("a case that others render");
        let buffers = picture.deferred.as_ref().map(|deferred| deferred.buffers());
        let pixels = hash(&picture.bytes());
        let hashes = buffers.iter().flatten().map(|(name, bytes)| (*name, hash(bytes)));
        let is_equal = |(name, hash): (&str, String)| {
            let line = format!("{scene} {name} {hash}");
            let is_equal = GOLDEN.lines().any(|golden| golden == line);
            if !is_equal {
                hprintln!("{}: {} has another hash", scene, name);
            }
            is_equal
        };
        let count = hashes
            .chain([("pixels", pixels.clone())])
            .filter_map(|found| is_equal(found).then_some(()))
            .count();
        hprintln!("{}: {} of 11 buffers equal, pixels {}", scene, count, pixels);
        scenes += 1;
        different += usize::from(count != 11);
    }
    hprintln!("{} scenes, {} different", scenes, different);
    exit(if scenes > 0 && different == 0 { EXIT_SUCCESS } else { EXIT_FAILURE });
    loop {}
}

/// SHA-256 in hex.
fn hash(bytes: &[u8]) -> String {
    let mut text = String::new();
    for byte in Sha256::digest(bytes) {
        // Writing to a string does not fail.
        let _ = write!(text, "{byte:02x}");
    }
    text
}

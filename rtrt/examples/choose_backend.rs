//! A program that renders on the best backend of whatever machine it runs on.
//!
//! ```text
//! $ cargo run --release -p rtrt --example choose_backend
//! cpu, AVX-512, 16 lanes: no GPU is better (llvmpipe (LLVM 15.0.6, 256 bits) is software)
//! gpu, llvmpipe (LLVM 15.0.6, 256 bits) (vulkan), 1 lanes: asked for (software adapter, SPIR-V passthrough, canary equal)
//! cpu, AVX-512, 16 lanes: instead of a GPU called "no such thing"
//! the same picture three times
//! ```
//!
//! `auto` falls back to the CPU by itself, also when a GPU fails in the middle of a run. Who asks for a GPU gets a
//! GPU or an error, and decides what then. The picture is the same, so nothing but time depends on the choice.

use rtrt::choose::{Choice, Chosen, Options, choose};
use rtrt_core::backend::{Picture, Request, Shadows};
use rtrt_core::scene::Sequential;
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let best = choose(&Options::default())?;
    let gpu = or_cpu(&Options { choice: Choice::Gpu, ..Options::default() })?;
    let adapter = Some("no such thing".into());
    let none = or_cpu(&Options { choice: Choice::Gpu, adapter, ..Options::default() })?;

    let loaded = rtrt::demo::matchbox(&Sequential)?;
    let mut pictures = vec![];
    for mut chosen in [best, gpu, none] {
        let machine = chosen.backend.describe();
        println!("{}, {}, {} lanes: {}", machine.kind, machine.adapter, machine.lanes, chosen.why);
        let camera = &loaded.camera;
        let request = Request::new(camera, [64, 36]).samples(4).shadows(Shadows::Hard);
        let mut picture = Picture::default();
        chosen.backend.render(&loaded.scene, &request, &mut picture)?;
        pictures.push(picture.pixels);
    }
    assert!(pictures.iter().all(|pixels| *pixels == pictures[0]));
    println!("the same picture three times");
    Ok(())
}

/// What was asked for, or the CPU.
fn or_cpu(options: &Options) -> Result<Chosen, Box<dyn Error>> {
    match choose(options) {
        Ok(chosen) => Ok(chosen),
        Err(_) => {
            let wanted = options.adapter.as_deref().unwrap_or("anything");
            let chosen = choose(&Options { choice: Choice::Cpu, ..Options::default() })?;
            Ok(Chosen { why: format!("instead of a GPU called {wanted:?}"), ..chosen })
        }
    }
}

#[test]
fn runs() {
    main().expect("no error");
}

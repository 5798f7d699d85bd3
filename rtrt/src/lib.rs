//! Backends chosen at run time, and scenes from files and in code.
//!
//! All backends give the same bits. `choose` opens a backend, `import` reads glTF and OBJ, `demo` has
//! scenes without files, `layers` and `debug` show the buffers of a frame, `objects` and `motion` what is
//! seen of each object and how it moves, `pose` has cameras as matrices and lenses, `poses` those of a file, `orbit` a turntable;
//! `moves` moves a camera by hand, `batch` renders many views at once. `hash` compares frames
//! of two machines, `difference` two pictures; `golden` compares pictures with stored ones in tests.
//!
//! | feature | adds |
//! |---|---|
//! | `gpu` | the GPUs of [`choose`](mod@choose), by `rtrt-gpu` |
//! | `threads` | all threads of the machine for the CPU; without it one |
//! | `simd` | many numbers at a time on the CPU; without it one |
//! | `import` | the modules `import`, `demo`, `golden`, `motion`, `moves`, `orbit`, `pose` and `poses` |
//! | `command` | the `rtrt` command; includes the other two |
//! | `viewer` | `rtrt view`, which opens a window; includes `command` |
//!
#![cfg_attr(feature = "import", doc = "```")]
#![cfg_attr(not(feature = "import"), doc = "```ignore")]
//! use rtrt_core::backend::{Picture, Request};
//!
//! let loaded = rtrt::demo::matchbox(&rtrt_core::scene::Sequential)?;
//! let mut chosen = rtrt::choose::choose(&rtrt::choose::Options::default())?;
//! let request = Request::new(&loaded.camera, [32, 18]);
//! let mut picture = Picture::default();
//! chosen.backend.render(&loaded.scene, &request, &mut picture)?;
//! assert_eq!(picture.pixels.len(), 32 * 18);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod batch;
pub mod cache;
pub mod choose;
pub mod debug;
#[cfg(feature = "import")]
pub mod demo;
pub mod difference;
#[cfg(feature = "import")]
pub mod golden;
#[cfg(feature = "import")]
mod halves;
pub mod hash;
#[cfg(feature = "import")]
pub mod import;
pub mod layers;
#[cfg(feature = "import")]
pub mod motion;
#[cfg(feature = "import")]
pub mod moves;
pub mod objects;
#[cfg(feature = "import")]
pub mod orbit;
#[cfg(feature = "import")]
pub mod pose;
#[cfg(feature = "import")]
pub mod poses;
pub mod replace;

//! The front door of rtrt: backends chosen at run time, scenes from files and in code.
//!
//! Whichever backend is chosen, a frame has the same bits. `choose` picks one, `import`
//! reads glTF and OBJ, `demo` builds a scene without any file, `layers` and `debug` show what a
//! frame is made of, `hash` is what two machines compare.
//!
//! | feature | what it adds |
//! |---|---|
//! | `gpu` | `rtrt-gpu`, for [`choose`](mod@choose) to choose from |
//! | `import` | the modules `import` and `demo` |
//! | `command` | the `rtrt` command; takes the other two |
//! | `viewer` | `rtrt view`, the command with a window; takes `command` |
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

pub mod cache;
pub mod choose;
pub mod debug;
#[cfg(feature = "import")]
pub mod demo;
pub mod hash;
#[cfg(feature = "import")]
pub mod import;
pub mod layers;
pub mod replace;

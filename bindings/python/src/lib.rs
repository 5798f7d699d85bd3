//! The Python package `rtrt`: it unpacks and checks what Python gives, and calls the crates of rtrt.
#![forbid(unsafe_code)]

mod aov;
mod arrays;
mod backend;
mod camera;
mod environment;
mod file;
mod forked;
mod forks;
mod given;
mod in_use;
mod light;
mod material;
mod numbers;
mod objects;
mod parts;
mod rays;
mod render;
mod scene;
mod shown;
mod signals;

use pyo3::prelude::*;

/// What the package `rtrt` is made of.
#[pymodule]
mod _native {
    #[pymodule_export]
    use super::backend::Backend;
    #[pymodule_export]
    use super::camera::Camera;
    #[pymodule_export]
    use super::light::Light;
    #[pymodule_export]
    use super::render::{Before, meter, render};
    #[pymodule_export]
    use super::scene::Scene;
    #[pymodule_export]
    use super::shown::shown;

    use super::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        super::forks::register(module.py())?;
        module.add("__version__", env!("CARGO_PKG_VERSION"))?;
        module.add("AOVS", super::aov::names().collect::<Vec<_>>())
    }
}

//! Scenes of files.

use crate::arrays::{named, refused};
use crate::backend::threads;
use crate::parts::Parts;
use pyo3::exceptions::{PyFileNotFoundError, PyOSError, PyValueError};
use pyo3::prelude::*;
use rtrt::demo;
use rtrt::import::{self, ImportError, Loaded, light_by_default};
use rtrt_cpu::Parallel;
use std::io::ErrorKind;
use std::path::Path;

/// The exception for a file: that of the system where there is one.
pub fn import_error(error: &ImportError) -> PyErr {
    let why = error.to_string();
    match error {
        ImportError::Unreadable { source, .. } if source.kind() == ErrorKind::NotFound => {
            PyFileNotFoundError::new_err(why)
        }
        ImportError::Unreadable { .. } => PyOSError::new_err(why),
        _ => PyValueError::new_err(why),
    }
}

/// What a file or a built-in scene is made of.
pub fn load(py: Python<'_>, path: &Path, light: bool, point_size: Option<f32>) -> PyResult<Parts> {
    if let Some(size) = point_size.filter(|size| !(*size > 0.0 && size.is_finite())) {
        return Err(PyValueError::new_err(format!("point_size is {size}, and not a number above 0")));
    }
    let pool = threads(py)?;
    py.detach(|| {
        let options = import::Options { point_size, ..import::Options::default() };
        let loaded = match path.to_str().and_then(|name| name.strip_prefix("demo:")) {
            Some(name) => {
                type Demo = fn(&Parallel) -> Result<Loaded, ImportError>;
                let all: [(&str, Demo); 5] = [
                    ("matchbox", demo::matchbox),
                    ("glass", demo::glass),
                    ("spheres", demo::spheres),
                    ("levels", demo::levels),
                    ("moving", demo::moving),
                ];
                let demo = named("the demo", name, &all)?;
                pool.install(|| demo(&Parallel))
            }
            None => pool.install(|| import::load_with(path, &Parallel, &options)),
        };
        let mut found = Parts::of(loaded.map_err(|error| import_error(&error))?);
        if found.scene.drawn_triangles() == 0 {
            let why = found.warnings.join("; ");
            return Err(PyValueError::new_err(format!("nothing to draw: {}: {why}", path.display())));
        }
        if light {
            pool.install(|| light_by_default(&mut found.scene)).map_err(refused)?;
        }
        Ok(found)
    })
}

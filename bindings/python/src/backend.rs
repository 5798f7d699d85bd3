//! The machine that renders.

use crate::arrays::named;
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use rtrt::batch::Batch;
use rtrt::choose::{Choice, Chosen, Options, choose};
use rtrt_core::backend::Description;
use rtrt_cpu::Cpu;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// A machine that renders: this processor, or a GPU. Pictures do not depend on it.
///
/// Args:
///     kind: "auto" (the first GPU that works, else the processor), "cpu" or "gpu".
///     adapter: Part of the name of a GPU, or its number.
///     threads: Threads of the processor; as many as it runs at once if not given.
///     lanes: 1, 8 or 16 numbers in one instruction; what is fast here if not given.
#[pyclass(frozen, module = "rtrt")]
pub struct Backend {
    machine: Arc<Machine>,
}

/// A backend that opens itself again in a process that was forked, where threads and devices of the parent are missing.
pub struct Machine {
    options: Options,
    why: String,
    description: Description,
    state: Mutex<State>,
}

struct State {
    process: u32,
    batch: Batch,
}

impl State {
    fn new(options: &Options) -> PyResult<(Self, String)> {
        let Chosen { backend, why, .. } =
            choose(options).map_err(|error| PyRuntimeError::new_err(error.to_string()))?;
        let cpu = rtrt_cpu::Options { lanes: options.lanes, threads: options.threads };
        Ok((Self { process: std::process::id(), batch: Batch::new(backend, cpu) }, why))
    }
}

impl Machine {
    fn new(options: Options) -> PyResult<Self> {
        let (mut state, why) = State::new(&options)?;
        let description = state.batch.backend().describe();
        Ok(Self { options, why, description, state: Mutex::new(state) })
    }

    /// Does this with the backend. The caller is not attached to Python.
    pub fn with<T>(&self, work: impl FnOnce(&mut Batch) -> T) -> PyResult<T> {
        let mut state: MutexGuard<'_, State> = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        if state.process != std::process::id() {
            let (new, _) = State::new(&self.options)?;
            // To drop it would wait for threads that are not there.
            std::mem::forget(std::mem::replace(&mut *state, new));
        }
        Ok(work(&mut state.batch))
    }
}

/// The machine of this argument, or the one that all calls without such an argument share.
pub fn machine(py: Python<'_>, backend: Option<&Bound<'_, Backend>>) -> PyResult<Arc<Machine>> {
    static USUAL: Mutex<Option<Arc<Machine>>> = Mutex::new(None);
    if let Some(backend) = backend {
        return Ok(backend.get().machine.clone());
    }
    py.detach(|| {
        let mut usual = USUAL.lock().unwrap_or_else(PoisonError::into_inner);
        match &*usual {
            Some(machine) => Ok(machine.clone()),
            None => Ok(usual.insert(Arc::new(Machine::new(Options::default())?)).clone()),
        }
    })
}

/// The threads that load scenes and ask rays. The caller is not attached to Python.
pub fn threads() -> PyResult<Arc<Cpu>> {
    static THREADS: Mutex<Option<(u32, Arc<Cpu>)>> = Mutex::new(None);
    let mut threads = THREADS.lock().unwrap_or_else(PoisonError::into_inner);
    let process = std::process::id();
    match &*threads {
        Some((owner, cpu)) if *owner == process => Ok(cpu.clone()),
        _ => {
            let cpu = Cpu::new(rtrt_cpu::Options::default());
            let cpu = Arc::new(cpu.map_err(|error| PyRuntimeError::new_err(error.to_string()))?);
            std::mem::forget(threads.replace((process, cpu.clone())));
            Ok(cpu)
        }
    }
}

#[pymethods]
impl Backend {
    #[new]
    #[pyo3(signature = (kind = "auto", *, adapter = None, threads = None, lanes = None))]
    fn new(
        py: Python<'_>,
        kind: &str,
        adapter: Option<String>,
        threads: Option<i64>,
        lanes: Option<i64>,
    ) -> PyResult<Self> {
        let kinds = [("auto", Choice::Auto), ("cpu", Choice::Cpu), ("gpu", Choice::Gpu)];
        let choice = named("kind", kind, &kinds)?;
        if let Some(threads) = threads.filter(|threads| !(1..=1024).contains(threads)) {
            return Err(PyValueError::new_err(format!(
                "threads is {threads}, which is not within 1 .. 1024"
            )));
        }
        if let Some(lanes) = lanes.filter(|lanes| ![1, 8, 16].contains(lanes)) {
            return Err(PyValueError::new_err(format!("lanes is {lanes}, and not 1, 8 or 16")));
        }
        let options = Options {
            choice,
            adapter,
            threads: threads.map(|threads| threads as usize),
            lanes: lanes.map(|lanes| lanes as u32),
            ..Options::default()
        };
        Ok(Self { machine: Arc::new(py.detach(|| Machine::new(options))?) })
    }

    /// "cpu" or "gpu".
    #[getter]
    fn kind(&self) -> &str {
        &self.machine.description.kind
    }

    /// The processor's instructions, or the name of the GPU.
    #[getter]
    fn adapter(&self) -> &str {
        &self.machine.description.adapter
    }

    /// Threads of the processor; 0 for a GPU.
    #[getter]
    fn threads(&self) -> u32 {
        self.machine.description.threads
    }

    /// Why it was chosen.
    #[getter]
    fn why(&self) -> &str {
        &self.machine.why
    }

    fn __repr__(&self) -> String {
        let Description { kind, adapter, .. } = &self.machine.description;
        format!("<rtrt.Backend {kind}: {adapter}>")
    }
}

//! The machine that renders.

use crate::arrays::named;
use crate::forked::PerProcess;
use crate::forks::unforked;
use crate::signals::interruptible;
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use rtrt::batch::Batch;
use rtrt::choose::{Choice, Chosen, Options, choose};
use rtrt_core::backend::Description;
use rtrt_cpu::Cpu;
use std::sync::atomic::AtomicBool;
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
    batch: PerProcess<Mutex<Option<Batch>>>,
}

/// Opens a backend, and says why it is this one.
fn open(options: &Options) -> PyResult<(Batch, String)> {
    let Chosen { backend, why, .. } =
        unforked(|| choose(options)).map_err(|error| PyRuntimeError::new_err(error.to_string()))?;
    let cpu = rtrt_cpu::Options { lanes: options.lanes, threads: options.threads };
    Ok((Batch::new(backend, cpu), why))
}

fn locked<T>(value: &Mutex<T>) -> MutexGuard<'_, T> {
    value.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Machine {
    fn new(options: Options) -> PyResult<Self> {
        let (mut batch, why) = open(&options)?;
        let description = batch.backend().describe();
        Ok(Self { options, why, description, batch: PerProcess::of(Mutex::new(Some(batch))) })
    }

    /// Does this with the backend, detached from Python. With `stop` it takes long: see [`interruptible`].
    pub fn with<T: Send>(
        &self,
        py: Python<'_>,
        stop: Option<&AtomicBool>,
        work: impl FnOnce(&mut Batch) -> T + Send,
    ) -> PyResult<T> {
        let batch = self.batch.get(py);
        let work = || {
            let mut batch = locked(&batch);
            Ok::<T, PyErr>(work(match &mut *batch {
                Some(batch) => batch,
                none => none.insert(open(&self.options)?.0),
            }))
        };
        match stop {
            Some(stop) => interruptible(py, stop, work)?,
            None => py.detach(work),
        }
    }
}

/// The machine of this argument, or the one that all calls without such an argument share.
pub fn machine(py: Python<'_>, backend: Option<&Bound<'_, Backend>>) -> PyResult<Arc<Machine>> {
    static USUAL: PerProcess<Mutex<Option<Arc<Machine>>>> = PerProcess::new();
    if let Some(backend) = backend {
        return Ok(backend.get().machine.clone());
    }
    let usual = USUAL.get(py);
    py.detach(|| {
        Ok(match &mut *locked(&usual) {
            Some(machine) => machine.clone(),
            none => none.insert(Arc::new(Machine::new(Options::default())?)).clone(),
        })
    })
}

/// The threads that load scenes and ask rays.
pub fn threads(py: Python<'_>) -> PyResult<Arc<Cpu>> {
    static THREADS: PerProcess<Mutex<Option<Arc<Cpu>>>> = PerProcess::new();
    let threads = THREADS.get(py);
    py.detach(|| {
        Ok(match &mut *locked(&threads) {
            Some(cpu) => cpu.clone(),
            none => {
                let cpu = Cpu::new(rtrt_cpu::Options::default());
                let cpu = cpu.map_err(|error| PyRuntimeError::new_err(error.to_string()))?;
                none.insert(Arc::new(cpu)).clone()
            }
        })
    })
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

//! Forks wait for calls into libraries that have locks.
//!
//! The loader of Vulkan and the drivers have locks of their own. One that a thread holds when another one forks stays locked
//! in the forked process, which then waits forever when it opens a backend. So no fork happens while a backend is opened.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::cell::RefCell;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError, TryLockError};
use std::thread;
use std::time::Duration;

/// Held by whoever opens a backend, and by whoever forks.
static GATE: Mutex<()> = Mutex::new(());
/// The forks that wait for the gate. They come first.
static FORKS: AtomicU32 = AtomicU32::new(0);
/// How long a thread sleeps that waits.
const TICK: Duration = Duration::from_millis(1);

thread_local! {
    /// What a thread holds while it forks.
    static HELD: RefCell<Option<MutexGuard<'static, ()>>> = const { RefCell::new(None) };
}

/// Does this while no thread forks. It must not be attached to Python, whose threads fork while they are.
pub fn unforked<T>(work: impl FnOnce() -> T) -> T {
    while FORKS.load(Ordering::SeqCst) > 0 {
        thread::sleep(TICK);
    }
    let _gate = GATE.lock().unwrap_or_else(PoisonError::into_inner);
    work()
}

/// Before a fork: waits until no backend is being opened.
#[pyfunction]
fn before_fork(py: Python<'_>) {
    FORKS.fetch_add(1, Ordering::SeqCst);
    loop {
        match GATE.try_lock() {
            Ok(gate) => return HELD.set(Some(gate)),
            Err(TryLockError::Poisoned(gate)) => return HELD.set(Some(gate.into_inner())),
            Err(TryLockError::WouldBlock) => py.detach(|| thread::sleep(TICK)),
        }
    }
}

/// After a fork, in the process that forked.
#[pyfunction]
fn forked_parent() {
    HELD.set(None);
    FORKS.fetch_sub(1, Ordering::SeqCst);
}

/// After a fork, in the new process: it has no thread but this one.
#[pyfunction]
fn forked_child() {
    HELD.set(None);
    FORKS.store(0, Ordering::SeqCst);
}

/// Has Python call these where it forks.
pub fn register(py: Python<'_>) -> PyResult<()> {
    let os = py.import("os")?;
    // There are no forks on Windows.
    if !os.hasattr("register_at_fork")? {
        return Ok(());
    }
    let hooks = PyDict::new(py);
    hooks.set_item("before", wrap_pyfunction!(before_fork, py)?)?;
    hooks.set_item("after_in_parent", wrap_pyfunction!(forked_parent, py)?)?;
    hooks.set_item("after_in_child", wrap_pyfunction!(forked_child, py)?)?;
    os.call_method("register_at_fork", (), Some(&hooks))?;
    Ok(())
}

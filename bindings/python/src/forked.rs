//! What the threads of a process share, and a forked process has anew.

use pyo3::Python;
use std::sync::{Arc, Mutex, PoisonError};

/// A value of each process.
///
/// A forked process has one thread. A lock that another thread held in the parent stays locked in it forever. The lock here
/// is taken by threads that are attached to Python, one at a time, and Python forks in such a thread: so nobody holds it
/// then. The value may have locks of its own; the forked process makes another value, and leaves those alone.
pub struct PerProcess<T>(Mutex<Option<(u32, Arc<T>)>>);

impl<T> PerProcess<T> {
    pub const fn new() -> Self {
        Self(Mutex::new(None))
    }

    /// One that holds this in the process that calls.
    pub fn of(value: T) -> Self {
        Self(Mutex::new(Some((std::process::id(), Arc::new(value)))))
    }
}

impl<T> Drop for PerProcess<T> {
    fn drop(&mut self) {
        let slot = self.0.get_mut().unwrap_or_else(PoisonError::into_inner);
        // That of the parent stays, as below.
        if let Some(value) = slot.take_if(|(owner, _)| *owner != std::process::id()) {
            std::mem::forget(value);
        }
    }
}

impl<T: Default> PerProcess<T> {
    /// The value of this process.
    pub fn get(&self, _py: Python<'_>) -> Arc<T> {
        let mut slot = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let process = std::process::id();
        match &*slot {
            Some((owner, value)) if *owner == process => value.clone(),
            _ => {
                let value = Arc::new(T::default());
                // To drop that of the parent would wait for threads that are not there.
                std::mem::forget(slot.replace((process, value.clone())));
                value
            }
        }
    }
}

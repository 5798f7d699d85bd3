//! What several threads may read at once, and one may change.

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use std::sync::{PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard, TryLockError};

/// A value that nobody waits for: whoever finds it in use gets an exception that says what to do.
pub struct InUse<T>(RwLock<T>);

impl<T> InUse<T> {
    pub const fn new(value: T) -> Self {
        Self(RwLock::new(value))
    }

    /// The value, unless it is being changed.
    pub fn read(&self) -> PyResult<RwLockReadGuard<'_, T>> {
        free(self.0.try_read()).ok_or_else(|| {
            PyRuntimeError::new_err(
                "the scene is being changed by another call, of another thread or one that called this; let that end first",
            )
        })
    }

    /// The value, unless it is being read or changed.
    pub fn change(&self) -> PyResult<RwLockWriteGuard<'_, T>> {
        free(self.0.try_write()).ok_or_else(|| {
            PyRuntimeError::new_err(
                "the scene is in use by another call, of another thread or one that called this; let that end first, or change a copy of it (Scene.copy)",
            )
        })
    }
}

/// The guard of a lock that is free. After a panic the value is as that left it.
fn free<G>(lock: Result<G, TryLockError<G>>) -> Option<G> {
    match lock {
        Ok(guard) => Some(guard),
        Err(TryLockError::Poisoned(poisoned)) => Some(PoisonError::into_inner(poisoned)),
        Err(TryLockError::WouldBlock) => None,
    }
}

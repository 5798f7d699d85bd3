//! Work that takes long, and ends when a signal raises.

use pyo3::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::Duration;

/// How long a signal waits at most.
const TICK: Duration = Duration::from_millis(50);

/// Does this in another thread, detached from Python, whose handlers of signals run meanwhile. If one of them raises, as that
/// of Ctrl-C does, `stop` is set, which `work` has to look at, and that exception is the result.
pub fn interruptible<T: Send>(
    py: Python<'_>,
    stop: &AtomicBool,
    work: impl FnOnce() -> T + Send,
) -> PyResult<T> {
    thread::scope(|scope| {
        let (done, mut ended) = mpsc::channel();
        let worker = scope.spawn(move || done.send(work()));
        let mut raised = Ok(());
        loop {
            let answer;
            (ended, answer) = py.detach(move || {
                let answer = ended.recv_timeout(TICK);
                (ended, answer)
            });
            match answer {
                Ok(value) => return raised.map(|()| value),
                Err(RecvTimeoutError::Timeout) if raised.is_ok() => {
                    raised = py.check_signals();
                    stop.store(raised.is_err(), Ordering::Relaxed);
                }
                Err(RecvTimeoutError::Timeout) => {}
                // It has panicked, and so does the scope.
                Err(RecvTimeoutError::Disconnected) => {
                    std::panic::resume_unwind(worker.join().err().unwrap_or_else(|| Box::new("no result")));
                }
            }
        }
    })
}

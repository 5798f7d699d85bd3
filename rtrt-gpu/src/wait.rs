//! Waits for a device: without blocking, or, for callers that have nothing else to do, on their thread.

use crate::error::Error;
use std::error::Error as StdError;
use std::future::poll_fn;
use std::sync::{Arc, Mutex, PoisonError};
use std::task::{Poll, Waker};

/// Who moves the work of a device along while a future waits for it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Waiting {
    /// The thread that polls the future: it stands still, and the future is ready when it is polled first.
    #[cfg(not(target_arch = "wasm32"))]
    Blocks,
    /// A browser, or a thread of its own.
    Free,
}

type Outcome = Result<(), Box<dyn StdError + Send + Sync>>;

/// Tells a future that what it waits for has happened. The first outcome counts.
#[derive(Clone, Default)]
pub(crate) struct Signal(Arc<Mutex<State>>);

#[derive(Default)]
struct State {
    outcome: Option<Outcome>,
    waker: Option<Waker>,
}

impl Signal {
    /// It has happened.
    pub fn give(&self, outcome: Result<(), impl StdError + Send + Sync + 'static>) {
        let mut state = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        state.outcome.get_or_insert(outcome.map_err(Into::into));
        if let Some(waker) = state.waker.take() {
            waker.wake();
        }
    }

    /// Ready once it has.
    async fn given(self) -> Outcome {
        poll_fn(|context| {
            let mut state = self.0.lock().unwrap_or_else(PoisonError::into_inner);
            match state.outcome.take() {
                Some(outcome) => Poll::Ready(outcome),
                None => {
                    state.waker = Some(context.waker().clone());
                    Poll::Pending
                }
            }
        })
        .await
    }
}

/// Waits until what `begin` has begun gives its signal, which is after the work that the device has now.
pub(crate) async fn until(
    device: &wgpu::Device,
    waiting: Waiting,
    begin: impl FnOnce(Signal),
) -> Result<(), Error> {
    let signal = Signal::default();
    begin(signal.clone());
    #[cfg(not(target_arch = "wasm32"))]
    {
        let (device, signal) = (device.clone(), signal.clone());
        let finish = move || {
            if let Err(error) = device.poll(wgpu::PollType::wait_indefinitely()) {
                signal.give(Err(error));
            }
        };
        if waiting == Waiting::Blocks {
            finish();
        } else {
            std::thread::Builder::new().spawn(finish).map_err(Error::read_back)?;
        }
    }
    #[cfg(target_arch = "wasm32")]
    let _ = (device, waiting);
    signal.given().await.map_err(|source| Error::ReadBack { source })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_signal_wakes_who_waits_and_only_the_first_counts() {
        let signal = Signal::default();
        let given = std::thread::spawn({
            let signal = signal.clone();
            move || pollster::block_on(signal.given())
        });
        std::thread::sleep(std::time::Duration::from_millis(20));
        assert!(!given.is_finished(), "it has not happened yet");
        signal.give(Err(std::io::Error::other("lost")));
        signal.give(Ok::<(), std::io::Error>(()));
        assert_eq!(given.join().unwrap().unwrap_err().to_string(), "lost");
    }
}

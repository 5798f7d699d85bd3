//! The two backends of a viewer: the one that draws, and the other.

use crate::command::Error;
use crate::command::console::Console;
use crate::command::options::BackendOptions;
use crate::command::view::engine::Engine;
use rtrt::choose::Choice;
use rtrt_core::backend::RenderError;
use rtrt_core::layout::Frame;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;

/// What another thread calls to wake the window.
pub type Waker = Arc<dyn Fn() + Send + Sync>;

/// The backends.
pub struct Engines {
    drawing: Engine,
    other: Other,
    /// The window's device.
    window: Option<(wgpu::Device, wgpu::Queue)>,
    options: BackendOptions,
}

/// The backend that does not draw.
enum Other {
    /// Not opened yet.
    Closed,
    Open(Box<Engine>),
    /// It is going to draw once its shaders are compiled.
    Cold(Box<Engine>),
    GettingReady(GettingReady),
}

/// A backend that a thread gets ready, and how to stop that.
struct GettingReady {
    thread: JoinHandle<Result<Box<Engine>, RenderError>>,
    stop: Arc<AtomicBool>,
}

impl Engines {
    /// The backend of these options. With `at_once` the CPU draws while a GPU compiles shaders.
    pub fn open(
        options: &BackendOptions,
        hybrid: bool,
        at_once: bool,
        console: &Console,
    ) -> Result<Self, Error> {
        let engine = Engine::open(options, hybrid, console)?;
        let (drawing, other) = if at_once && engine.is_gpu() {
            (Engine::cpu(options)?, Other::Cold(Box::new(engine)))
        } else {
            (engine, Other::Closed)
        };
        Ok(Self { drawing, other, window: None, options: options.clone() })
    }

    /// The backend that draws.
    pub fn drawing(&self) -> &Engine {
        &self.drawing
    }

    /// The backend that draws.
    pub fn drawing_mut(&mut self) -> &mut Engine {
        &mut self.drawing
    }

    /// Whether another backend is getting ready to draw.
    pub fn is_getting_ready(&self) -> bool {
        matches!(self.other, Other::Cold(_) | Other::GettingReady(_))
    }

    /// Shares the device of the window.
    pub fn share(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, console: &Console) {
        self.drawing.share(device, queue, console);
        if let Other::Open(engine) | Other::Cold(engine) = &mut self.other {
            engine.share(device, queue, console);
        }
        self.window = Some((device.clone(), queue.clone()));
    }

    /// Whether a GPU is to draw that has not begun to compile its shaders.
    pub fn is_cold(&self) -> bool {
        matches!(self.other, Other::Cold(_))
    }

    /// Switches to the other backend at once.
    pub fn switch(&mut self, hybrid: bool, console: &Console) -> Result<(), Error> {
        if let Some(other) = self.other(hybrid, console)? {
            self.swap(other);
        }
        Ok(())
    }

    /// Switches to the other backend as soon as it is ready: a GPU first compiles, on a thread of its own, what frames like
    /// this one need. Returns whether it draws already.
    pub fn switch_when_ready(
        &mut self,
        hybrid: bool,
        frame: &Frame,
        console: &Console,
        waker: Waker,
    ) -> Result<bool, Error> {
        let Some(mut other) = self.other(hybrid, console)? else { return Ok(false) };
        if other.is_warm || !other.is_gpu() {
            self.swap(other);
            return Ok(true);
        }
        let (stop, frame) = (Arc::new(AtomicBool::new(false)), *frame);
        let flag = Arc::clone(&stop);
        let thread = std::thread::spawn(move || {
            let warm = other.warm_up(&frame, &flag).map(|()| other);
            waker();
            warm
        });
        self.other = Other::GettingReady(GettingReady { thread, stop });
        Ok(false)
    }

    /// Switches to a backend that has become ready: whether it has. An error if it could not.
    pub fn take_ready(&mut self) -> Result<bool, RenderError> {
        if !matches!(&self.other, Other::GettingReady(ready) if ready.thread.is_finished()) {
            return Ok(false);
        }
        let Other::GettingReady(ready) = std::mem::replace(&mut self.other, Other::Closed) else {
            return Ok(false);
        };
        let engine = ready.thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))?;
        self.swap(engine);
        Ok(true)
    }

    fn swap(&mut self, mut other: Box<Engine>) {
        std::mem::swap(&mut self.drawing, &mut *other);
        self.other = Other::Open(other);
    }

    /// The other backend, opened the first time; none while it is getting ready.
    fn other(&mut self, hybrid: bool, console: &Console) -> Result<Option<Box<Engine>>, Error> {
        match std::mem::replace(&mut self.other, Other::Closed) {
            Other::Open(engine) | Other::Cold(engine) => return Ok(Some(engine)),
            Other::GettingReady(ready) => {
                self.other = Other::GettingReady(ready);
                return Ok(None);
            }
            Other::Closed => {}
        }
        let mut options = self.options.clone();
        options.backend = if self.drawing.is_gpu() { Choice::Cpu } else { Choice::Gpu };
        let mut engine = Engine::open(&options, hybrid && options.backend == Choice::Gpu, console)?;
        if let Some((device, queue)) = &self.window {
            engine.share(device, queue, console);
        }
        Ok(Some(Box::new(engine)))
    }
}

impl Drop for Engines {
    /// Ends what compiles, after the shader that it is at. Nobody waits for that.
    fn drop(&mut self) {
        if let Other::GettingReady(ready) = &self.other {
            ready.stop.store(true, Ordering::Relaxed);
        }
    }
}

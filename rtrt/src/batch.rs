//! Many pictures of a scene at once.

use rtrt_core::backend::{Backend, Picture, RenderError, Request};
use rtrt_core::scene::Scene;
use rtrt_cpu::{Cpu, Options};
use std::sync::{Mutex, PoisonError};
use std::thread;

/// The most rays of a picture that one thread renders: larger ones have enough blocks for all threads, and more
/// deferred buffers than should be held once a thread.
const SMALL: u64 = 1 << 18;

/// A backend that renders many pictures in one call. Small pictures of the CPU are rendered side by side, one a thread:
/// a picture of few blocks does not keep many threads busy. Bits do not depend on that.
///
/// ```
/// use rtrt::batch::Batch;
/// use rtrt::choose::{Choice, Options, choose};
/// use rtrt_core::backend::Request;
///
/// let loaded = rtrt::demo::glass(&rtrt_core::scene::Sequential)?;
/// let chosen = choose(&Options { choice: Choice::Cpu, ..Options::default() })?;
/// let mut batch = Batch::new(chosen.backend, rtrt_cpu::Options::default());
/// let mut jobs: Vec<_> = (1..9).map(|n| (Request::new(&loaded.camera, [n, 2]), 0)).collect();
/// batch.render(&loaded.scene, &mut jobs, |_, picture, pixels| *pixels = picture.pixels.len())?;
/// assert_eq!(jobs[7].1, 16);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Batch {
    backend: Box<dyn Backend>,
    options: Options,
    picture: Picture,
    workers: Vec<(Cpu, Picture)>,
}

/// Why a batch has not been rendered.
#[derive(Debug, thiserror::Error)]
#[error("picture {number}: {source}")]
pub struct BatchError {
    /// The first picture that failed, counted from 0.
    pub number: usize,
    /// Why.
    pub source: RenderError,
}

impl Batch {
    /// Pictures by this backend. `options` are those of the CPU, if the backend is one.
    pub fn new(backend: Box<dyn Backend>, options: Options) -> Self {
        Self { backend, options, picture: Picture::default(), workers: vec![] }
    }

    /// The backend.
    pub fn backend(&mut self) -> &mut dyn Backend {
        &mut *self.backend
    }

    /// Renders each request. `take` gets the picture, which is used again afterwards, and what goes with the request.
    ///
    /// # Errors
    /// The first request, by its place, that fails. The others may have been rendered.
    pub fn render<T: Send>(
        &mut self,
        scene: &Scene,
        jobs: &mut [(Request<'_>, T)],
        take: impl Fn(&Request<'_>, &Picture, &mut T) + Sync,
    ) -> Result<(), BatchError> {
        let rays = |request: &Request<'_>| {
            request.size.map(u64::from).iter().product::<u64>() * u64::from(request.samples)
        };
        let machine = self.backend.describe();
        let are_small = jobs.iter().all(|(request, _)| rays(request) <= SMALL);
        let threads = (machine.threads as usize).min(jobs.len());
        if machine.kind == "cpu" && are_small && threads > 1 {
            return self.side_by_side(scene, jobs, threads, take);
        }
        let Self { backend, picture, .. } = self;
        for (number, (request, what)) in jobs.iter_mut().enumerate() {
            backend.render(scene, request, picture).map_err(|source| BatchError { number, source })?;
            take(request, picture, what);
        }
        Ok(())
    }

    fn side_by_side<T: Send>(
        &mut self,
        scene: &Scene,
        jobs: &mut [(Request<'_>, T)],
        threads: usize,
        take: impl Fn(&Request<'_>, &Picture, &mut T) + Sync,
    ) -> Result<(), BatchError> {
        while self.workers.len() < threads {
            let cpu = Cpu::new(Options { threads: Some(1), ..self.options });
            let source = |error| RenderError::Backend { backend: "cpu", source: Box::new(error) };
            let cpu = cpu.map_err(|error| BatchError { number: 0, source: source(error) })?;
            self.workers.push((cpu, Picture::default()));
        }
        let next = Mutex::new(jobs.iter_mut().enumerate());
        let failed: Mutex<Option<BatchError>> = Mutex::new(None);
        let work = |(cpu, picture): &mut (Cpu, Picture)| {
            loop {
                let job = next.lock().unwrap_or_else(PoisonError::into_inner).next();
                let Some((number, (request, what))) = job else { return };
                match cpu.render(scene, request, picture) {
                    Ok(()) => take(request, picture, what),
                    Err(source) => {
                        let mut failed = failed.lock().unwrap_or_else(PoisonError::into_inner);
                        if failed.as_ref().is_none_or(|first| number < first.number) {
                            *failed = Some(BatchError { number, source });
                        }
                    }
                }
            }
        };
        thread::scope(|scope| {
            for worker in &mut self.workers[..threads] {
                scope.spawn(|| work(worker));
            }
        });
        failed.into_inner().unwrap_or_else(PoisonError::into_inner).map_or(Ok(()), Err)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Mat4, Vec3};
    use rtrt_core::scene::{Camera, Material, Projection};

    fn scene() -> Scene {
        let mut scene = Scene::new();
        let paint = scene.add_material(Material::new([0.8, 0.3, 0.1])).unwrap();
        scene.add_sphere(paint, Mat4::IDENTITY).unwrap();
        scene
    }

    fn camera(z: f32) -> Camera {
        let projection = Projection::Perspective { fov_y: 1.0 };
        Camera { eye: Vec3::Z * z, look_at: Vec3::ZERO, up: Vec3::Y, projection }
    }

    fn batch(threads: usize) -> Batch {
        let options = Options { threads: Some(threads), ..Options::default() };
        Batch::new(Box::new(Cpu::new(options).unwrap()), options)
    }

    #[test]
    fn pictures_side_by_side_are_those_one_by_one() {
        let (scene, cameras) = (scene(), [2.0, 3.0, 4.0, 5.0, 6.0].map(camera));
        let all = [1, 3].map(|threads| {
            let request = |camera| (Request::new(camera, [40, 30]).samples(4), vec![]);
            let mut jobs: Vec<_> = cameras.iter().map(request).collect();
            let mut batch = batch(threads);
            batch.render(&scene, &mut jobs, |_, picture, pixels| pixels.clone_from(&picture.pixels)).unwrap();
            assert_eq!(batch.workers.len(), if threads == 1 { 0 } else { threads });
            jobs.into_iter().map(|(_, pixels)| pixels).collect::<Vec<_>>()
        });
        assert_eq!(all[0], all[1]);
        assert!(all[0].windows(2).all(|two| two[0] != two[1]));
    }

    #[test]
    fn the_first_that_fails_is_named() {
        let (scene, cameras) = (scene(), [2.0, 0.0, 3.0, 0.0, 4.0].map(camera));
        for threads in [1, 3] {
            let mut jobs: Vec<_> =
                cameras.iter().map(|camera| (Request::new(camera, [8, 8]), false)).collect();
            let error = batch(threads).render(&scene, &mut jobs, |_, _, done| *done = true).unwrap_err();
            assert!(error.number == 1 && matches!(error.source, RenderError::Setup(_)), "{error}");
            assert!(jobs[0].1 && !jobs[1].1);
        }
    }
}

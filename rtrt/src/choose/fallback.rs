//! A backend that the CPU replaces when it fails.

use super::options::Tell;
use rtrt_core::backend::{Backend, Description, Picture, RenderError, Request};
use rtrt_core::layout::Frame;
use rtrt_core::scene::Scene;
use rtrt_cpu::Cpu;
use std::sync::atomic::AtomicBool;

/// Renders on a first backend until it fails, then on the CPU. The CPU renders the failed frame again; its bits
/// are the same.
pub(super) struct Fallback {
    backend: Box<dyn Backend>,
    /// The options of the CPU, until it renders.
    cpu: Option<rtrt_cpu::Options>,
    tell: Option<Tell>,
}

impl Fallback {
    /// `tell` is called with the error of the first backend.
    pub fn new(first: Box<dyn Backend>, cpu: rtrt_cpu::Options, tell: Option<Tell>) -> Self {
        Self { backend: first, cpu: Some(cpu), tell }
    }
}

impl Backend for Fallback {
    fn describe(&self) -> Description {
        self.backend.describe()
    }

    fn render(
        &mut self,
        scene: &Scene,
        request: &Request<'_>,
        picture: &mut Picture,
    ) -> Result<(), RenderError> {
        let failed = match self.backend.render(scene, request, picture) {
            Err(error @ RenderError::Backend { .. }) => error,
            result => return result,
        };
        if self.cpu.is_some() && self.tell.is_some_and(|tell| !tell(&failed)) {
            return Err(failed);
        }
        let Some(Ok(cpu)) = self.cpu.take().map(Cpu::new) else { return Err(failed) };
        self.backend = Box::new(cpu);
        self.backend.render(scene, request, picture)
    }

    fn warm_up(&mut self, frame: &Frame, stop: &AtomicBool) -> Result<(), RenderError> {
        self.backend.warm_up(frame, stop)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use rtrt_core::scene::{Camera, Projection};
    use std::sync::atomic::{AtomicU32, Ordering};

    /// Renders one frame, and fails at the next with half of it done.
    struct Mortal(Cpu, u32);

    impl Backend for Mortal {
        fn describe(&self) -> Description {
            Description { kind: "mortal".into(), ..self.0.describe() }
        }
        fn render(
            &mut self,
            scene: &Scene,
            request: &Request<'_>,
            picture: &mut Picture,
        ) -> Result<(), RenderError> {
            self.0.render(scene, request, picture)?;
            self.1 += 1;
            if self.1 > 1 {
                picture.pixels.truncate(9);
                picture.deferred = None;
                return Err(RenderError::Backend { backend: "mortal", source: "it is no more".into() });
            }
            Ok(())
        }
    }

    #[test]
    fn the_cpu_takes_over_with_the_same_picture_and_says_so_once() {
        static TOLD: AtomicU32 = AtomicU32::new(0);
        let tell = |error: &RenderError| {
            assert_eq!(error.to_string(), "mortal: it is no more");
            TOLD.fetch_add(1, Ordering::Relaxed);
            true
        };
        let options = rtrt_cpu::Options { lanes: Some(1), threads: Some(1) };
        let first = Box::new(Mortal(Cpu::new(options).unwrap(), 0));
        let mut backend = Fallback::new(first, options, Some(tell));
        let camera = Camera {
            eye: Vec3::Z,
            look_at: Vec3::ZERO,
            up: Vec3::Y,
            projection: Projection::Perspective { fov_y: 1.0 },
        };
        let request = Request::new(&camera, [20, 9])
            .samples(4)
            .shadows(rtrt_core::backend::Shadows::Hard)
            .deferred(true);
        let mut pictures = [(); 3].map(|()| Picture::default());
        for (picture, kind) in pictures.iter_mut().zip(["mortal", "cpu", "cpu"]) {
            backend.render(&Scene::new(), &request, picture).unwrap();
            assert_eq!(backend.describe().kind, kind);
            picture.stages_ms = Default::default();
        }
        assert!(
            pictures.iter().all(|p| p.pixels == pictures[0].pixels && p.deferred == pictures[0].deferred)
        );
        assert_eq!(TOLD.load(Ordering::Relaxed), 1);
        // The callback may refuse.
        let first = Box::new(Mortal(Cpu::new(options).unwrap(), 0));
        let mut strict = Fallback::new(first, options, Some(|_| false));
        let results =
            [(); 3].map(|()| strict.render(&Scene::new(), &request, &mut Picture::default()).is_ok());
        assert_eq!((results, strict.describe().kind.as_str()), ([true, false, false], "mortal"));
        // An invalid request is no failure of the backend.
        let wrong = request.samples(3);
        let error = backend.render(&Scene::new(), &wrong, &mut pictures[0]).unwrap_err();
        assert!(matches!(error, RenderError::Setup(_)));
    }
}

//! Frames without blocking: futures that leave their thread free.

use rtrt_core::backend::{Backend, Picture, Request};
use rtrt_core::scene::{Camera, Light, Panorama, Projection, Scene};
use rtrt_gpu::{Gpu, Options};
use std::future::Future;
use std::pin::pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::task::{Context, Poll, Wake, Waker};
use std::time::{Duration, Instant};

/// Counts how often it is woken.
#[derive(Default)]
struct Woken(AtomicUsize);

impl Wake for Woken {
    fn wake(self: Arc<Self>) {
        self.0.fetch_add(1, Ordering::SeqCst);
    }
}

/// Polls until the future is ready, and only when it asks for it; gives how often it was not ready.
fn polled<T>(future: impl Future<Output = T>) -> (T, usize) {
    let (woken, mut future, mut pending) = (Arc::new(Woken::default()), pin!(future), 0);
    let waker = Waker::from(Arc::clone(&woken));
    let start = Instant::now();
    loop {
        let before = woken.0.load(Ordering::SeqCst);
        if let Poll::Ready(value) = future.as_mut().poll(&mut Context::from_waker(&waker)) {
            return (value, pending);
        }
        pending += 1;
        while woken.0.load(Ordering::SeqCst) == before {
            assert!(start.elapsed() < Duration::from_secs(60), "nothing wakes the future");
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}

fn scene() -> Scene {
    let mut scene = Scene::new();
    let rgb = (0..64).map(|i| [i as f32 / 64.0, (i % 8) as f32 / 8.0, 0.5]).collect();
    scene.set_environment(&Panorama { width: 8, height: 8, rgb }).unwrap();
    scene.add_light(Light::sun([1.0, -1.0, 0.5]).radius(0.02));
    scene
}

#[test]
fn a_frame_does_not_block_and_is_the_same_also_after_one_that_was_dropped() {
    let (mut gpu, pending) = match polled(Gpu::new_async(Options::default())) {
        (Ok(gpu), pending) => (gpu, pending),
        (Err(error), _) if std::env::var_os("RTRT_REQUIRE_GPU").is_some() => panic!("{error}"),
        (Err(error), _) => return println!("skipped: {error}"),
    };
    assert!(pending > 0, "the canary's answer was there at once");
    let camera = Camera {
        eye: [0.0, 0.0, 3.0].into(),
        look_at: [0.0; 3].into(),
        up: [0.0, 1.0, 0.0].into(),
        projection: Projection::Perspective { fov_y: 1.0 },
    };
    let (scene, request) = (scene(), Request::new(&camera, [64, 48]).deferred(true));
    let mut expected = Picture::default();
    gpu.render(&scene, &request, &mut expected).unwrap();

    let mut picture = Picture::default();
    {
        let mut dropped = pin!(gpu.render_async(&scene, &request, &mut picture));
        let mut context = Context::from_waker(Waker::noop());
        assert!(dropped.as_mut().poll(&mut context).is_pending());
    }
    let (rendered, pending) = polled(gpu.render_async(&scene, &request, &mut picture));
    rendered.unwrap();
    assert!(pending > 0, "the frame was there at once");
    assert_eq!(picture.pixels, expected.pixels);
    assert_eq!(picture.deferred, expected.deferred);
}

//! Hybrid frames: those whose closest surfaces are drawn differ at edges from those that are traced, and nowhere
//! else.

use conformance::hybrid::Differences;
use conformance::{cases, compare, reference};
use rtrt::import::{ImportError, Loaded};
use rtrt_core::backend::{Backend, Picture, Request, Shadows};
use rtrt_core::scene::{Camera, Projection, Scene};
use rtrt_cpu::Parallel;
use rtrt_gpu::{Error, Gpu, Options, Route, wgpu};
use std::path::Path;

/// A GPU, or none after saying why.
fn open(options: Options) -> Option<Gpu> {
    match Gpu::new(options) {
        Ok(gpu) => return Some(gpu),
        Err(error @ Error::Canary { .. }) => println!("skipped: {error}"),
        Err(error) if conformance::variants::requires_gpu() => panic!("{error}"),
        Err(error) => println!("skipped: {error}"),
    }
    None
}

/// A GPU by each route, and in bands.
fn hybrids() -> Vec<(&'static str, Gpu)> {
    let by = |route| Options { route, ..Options::default() };
    let bands = Options { band_bytes: Some(64 * 1024), ..by(Route::Passthrough) };
    [("passthrough", by(Route::Passthrough)), ("naga", by(Route::Naga)), ("in bands", bands)]
        .into_iter()
        .filter_map(|(name, options)| Some((name, hybrid(open(options)?))))
        .collect()
}

fn hybrid(mut gpu: Gpu) -> Gpu {
    gpu.set_hybrid(true).unwrap();
    gpu
}

/// What is wrong with a frame of which at most one ray in `few` may meet something else, those aside for which two
/// surfaces are as near.
fn wrong(found: &Differences, few: usize) -> Option<&'static str> {
    if found.uneven > 0 {
        return Some("a triangle that is drawn is met otherwise than when it is traced");
    }
    if found.strange > 0 {
        return Some("something else is seen where there is no edge");
    }
    ((found.other - found.near) * few > found.rays).then_some("too many rays meet something else")
}

#[test]
fn cases_differ_at_edges_only() {
    let mut reference = reference();
    let mut hybrids = hybrids();
    let (mut rays, mut other) = (0, 0);
    let (mut traced, mut drawn) = (Picture::default(), Picture::default());
    for case in cases::all() {
        let (scene, request) = ((case.scene)(), case.request());
        reference.render(&scene, &request, &mut traced).unwrap();
        for (name, gpu) in &mut hybrids {
            gpu.render(&scene, &request, &mut drawn).unwrap();
            let found = Differences::of(&request, &traced, &drawn).unwrap();
            // Rays go exactly through edges and corners in some of them.
            if let Some(why) = wrong(&found, 16) {
                panic!("{}, {name}: {why}: {found:?}", case.name);
            }
            rays += found.rays;
            other += found.other;
        }
    }
    println!("{other} of {rays} rays meet something else");
    assert!(hybrids.is_empty() || other > 0, "nothing was drawn");
    assert!(other * 500 <= rays);
}

/// The scenes: files where they are, and those built in.
fn scenes() -> Vec<(&'static str, Loaded)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/scenes");
    let files = ["sponza/sponza_dabrovic_cc0tex.glb", "stanford/dragon_res2.glb", "hero/chess-board.glb"];
    let load = |name: &'static str| -> Option<(&'static str, Result<Loaded, ImportError>)> {
        let path = folder.join(name);
        if !path.exists() {
            println!("SKIPPED: {} is not there", path.display());
            return None;
        }
        Some((name, rtrt::import::load(&path, &Parallel)))
    };
    let built = [
        ("demo:matchbox", rtrt::demo::matchbox(&Parallel)),
        ("demo:glass", rtrt::demo::glass(&Parallel)),
        ("demo:spheres", rtrt::demo::spheres(&Parallel)),
        ("demo:levels", rtrt::demo::levels(&Parallel)),
        ("demo:moving", rtrt::demo::moving(&Parallel)),
    ];
    let all = files.into_iter().filter_map(load).chain(built);
    let lit = |(name, loaded): (&'static str, Result<Loaded, ImportError>)| {
        let mut loaded = loaded.unwrap_or_else(|why| panic!("{name}: {why}"));
        rtrt::import::light_by_default(&mut loaded.scene).unwrap_or_else(|why| panic!("{name}: {why}"));
        (name, loaded)
    };
    all.map(lit).collect()
}

fn request(camera: &Camera, samples: u32) -> Request<'_> {
    Request::new(camera, [320, 180]).samples(samples).shadows(Shadows::Hard).deferred(true)
}

#[test]
fn real_scenes_differ_at_edges_only() {
    let mut cpu = rtrt_cpu::Cpu::new(rtrt_cpu::Options::default()).unwrap();
    let mut hybrids = hybrids();
    let (mut traced, mut drawn) = (Picture::default(), Picture::default());
    for (scene, Loaded { scene: loaded, camera, .. }) in &scenes() {
        for samples in [1, 4] {
            for (name, gpu) in &mut hybrids {
                // The routes compile the same shaders in other ways: small frames show that.
                let size = if *name == "passthrough" { [320, 180] } else { [160, 90] };
                let request = request(camera, samples).size(size);
                cpu.render(loaded, &request, &mut traced).unwrap();
                gpu.render(loaded, &request, &mut drawn).unwrap();
                let found = Differences::of(&request, &traced, &drawn).unwrap();
                println!("{scene}, {samples} samples, {name}: {}", told(&found));
                assert!(found.met * 10 > found.rays, "{scene}, {name}: little is seen");
                assert_eq!(wrong(&found, 1000), None, "{scene}, {name}");
                assert!(found.pixels.len() * 500 < drawn.pixels.len(), "{scene}, {name}: too many pixels");
                // Hard shadows: no ray has a say in another's color.
                assert!(found.pixels.len() <= found.other, "{scene}, {name}: more pixels than rays differ");
            }
        }
    }
}

/// The figures in a line.
fn told(found: &Differences) -> String {
    format!(
        "{} of {} rays ({} as near), {} pixels, by {} at most and {:.5} in the mean",
        found.other,
        found.rays,
        found.near,
        found.pixels.len(),
        found.largest,
        found.mean
    )
}

#[test]
fn a_frame_of_another_camera_is_red() {
    let Some(gpu) = open(Options::default()) else { return };
    let mut gpu = hybrid(gpu);
    let loaded = rtrt::demo::matchbox(&Parallel).unwrap();
    // A tenth of a pixel.
    let Projection::Perspective { fov_y } = loaded.camera.projection else { panic!("another camera") };
    let turned = Camera {
        look_at: loaded.camera.look_at
            + loaded.camera.up * (0.1 / 180.0 * fov_y * loaded.camera.eye.distance(loaded.camera.look_at)),
        ..loaded.camera
    };
    let (mut traced, mut drawn) = (Picture::default(), Picture::default());
    reference().render(&loaded.scene, &request(&loaded.camera, 1), &mut traced).unwrap();
    gpu.render(&loaded.scene, &request(&turned, 1), &mut drawn).unwrap();
    let mut found = Differences::of(&request(&turned, 1), &traced, &drawn).unwrap();
    assert!(wrong(&found, 1000).is_some(), "{}", told(&found));
    // Equal hits are not enough.
    found.uneven = 0;
    assert!(wrong(&found, 1000).is_some(), "{}", told(&found));
}

#[test]
fn without_it_bits_are_as_ever() {
    let Some(gpu) = open(Options::default()) else { return };
    let mut gpu = hybrid(gpu);
    let case = cases::named("visibility/dense").unwrap();
    let scene = (case.scene)();
    let (mut expected, mut actual) = (Picture::default(), Picture::default());
    reference().render(&scene, &case.request(), &mut expected).unwrap();
    gpu.render(&scene, &case.request(), &mut actual).unwrap();
    assert!(
        compare(&case.request(), &expected, &actual).is_err(),
        "the case has no edge that is drawn otherwise"
    );
    gpu.set_hybrid(false).unwrap();
    gpu.render(&scene, &case.request(), &mut actual).unwrap();
    compare(&case.request(), &expected, &actual).unwrap();
}

#[test]
fn a_frame_larger_than_a_texture_is_drawn_in_parts() {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let Ok(adapter) = pollster::block_on(instance.request_adapter(&Default::default())) else {
        assert!(!conformance::variants::requires_gpu(), "a GPU is required");
        return println!("skipped: no adapter");
    };
    let wanted = wgpu::DeviceDescriptor {
        required_features: adapter.features() & wgpu::Features::PASSTHROUGH_SHADERS,
        required_limits: wgpu::Limits { max_texture_dimension_2d: 100, ..adapter.limits() },
        ..Default::default()
    };
    let (device, queue) = pollster::block_on(adapter.request_device(&wanted)).unwrap();
    let mut gpu = hybrid(Gpu::with_device(device, queue, Route::Auto).unwrap());
    let loaded = rtrt::demo::spheres(&Parallel).unwrap();
    let (mut traced, mut drawn) = (Picture::default(), Picture::default());
    // No frame of the limited size comes first: its buffers would be large enough.
    gpu.render(&Scene::new(), &request(&loaded.camera, 1).size([7, 5]), &mut drawn).unwrap();
    for samples in [1, 4] {
        let request = request(&loaded.camera, samples);
        reference().render(&loaded.scene, &request, &mut traced).unwrap();
        gpu.render(&loaded.scene, &request, &mut drawn).unwrap();
        let found = Differences::of(&request, &traced, &drawn).unwrap();
        assert_eq!(wrong(&found, 1000), None, "{}", told(&found));
    }
}

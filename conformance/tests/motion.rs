//! Scenes that change between frames: a frame is the same whether what moved was moved, on a
//! backend that has seen the frames before, or the scene is a new one.

use conformance::shape::{Build, Random, Shape};
use conformance::variants::{Present, all, present, requires_gpu};
use conformance::{compare, reference};
use glam::{Mat4, Vec3};
use rtrt_core::backend::{Backend, Picture, RenderError, Request, Shadows};
use rtrt_core::layout::Attribute;
use rtrt_core::scene::{
    Bvh, Camera, Light, Mesh, MeshIndex, Motion, Occluders, Projection, Scene, Sequential, Structure,
};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

const CAMERA: Camera = Camera {
    eye: Vec3::new(0.0, 4.0, 9.0),
    look_at: Vec3::new(0.0, 0.5, 0.0),
    up: Vec3::Y,
    projection: Projection::Perspective { fov_y: 0.9 },
};

/// Objects that move.
const MOVING: u32 = 24;

/// The reference's picture, which all variants must have too.
fn agreed(variants: &mut Present, scene: &Scene, request: &Request<'_>, step: &str) -> Picture {
    let (mut expected, mut actual) = (Picture::default(), Picture::default());
    reference().render(scene, request, &mut expected).unwrap();
    for (variant, backend) in &mut variants.backends {
        backend.render(scene, request, &mut actual).unwrap();
        let agrees = compare(request, &expected, &actual);
        agrees.unwrap_or_else(|difference| panic!("{variant}, {step}: {difference}"));
    }
    expected
}

/// A cloth that waves.
fn cloth(time: f64) -> Mesh {
    const SIDE: u32 = 12;
    let place = |i: u32| {
        let [x, z] = [i % SIDE, i / SIDE].map(|n| f64::from(n) / f64::from(SIDE - 1) * 4.0 - 2.0);
        let [height, slope] = [libm::sin(2.0 * x + time), libm::cos(2.0 * x + time)];
        let normal = [-slope as f32, 1.0, 0.0];
        (
            [x as f32, (0.5 * height) as f32, z as f32],
            Attribute { normal, uv: [0.0; 2], color: Attribute::WHITE },
        )
    };
    let (positions, attributes) = (0..SIDE * SIDE).map(place).unzip();
    let quads = (0..(SIDE - 1) * (SIDE - 1)).map(|n| n / (SIDE - 1) * SIDE + n % (SIDE - 1));
    let indices = quads.flat_map(|i| [i, i + SIDE, i + 1, i + 1, i + SIDE, i + SIDE + 1]).collect();
    Mesh::new(positions, attributes, indices).unwrap()
}

/// Where the moving instances are.
fn places(time: f64) -> Vec<Mat4> {
    let mut random = Random(11);
    let place = |_| {
        let start = Mat4::from_translation(random.vector(3.0)) * Mat4::from_scale(Vec3::splat(0.4));
        let motion =
            Motion { velocity: random.vector(0.5), axis: random.vector(1.0), rate: random.within(0.0, 3.0) };
        motion.at(start, time)
    };
    (0..MOVING).map(place).collect()
}

/// Whether an instance is hidden.
fn is_hidden(instance: u32, time: f64) -> bool {
    instance % 5 == 2 && time > 1.0
}

/// A scene made at a time: the cloth, its tree built at the start; moving boxes; a floor.
fn scene(time: f64) -> (Scene, MeshIndex) {
    let mut build = Build::default();
    let start = cloth(0.0);
    let tree = Bvh::build(&start, &Sequential);
    let now = cloth(time);
    let tree = Bvh::from_links(&now, &tree.links(), tree.triangles).unwrap();
    let cloth = build.scene.add_mesh(&now, &tree).unwrap();
    let cube = build.mesh(Shape::cube());
    for (instance, place) in places(time).into_iter().enumerate() {
        let instance = build.instance(if instance % 6 == 0 { cloth } else { cube }, place);
        if is_hidden(instance.number(), time) {
            build.scene.hide(instance).unwrap();
        }
    }
    let sun = Light::sun(Vec3::new(0.3, -1.0, -0.4)).color(Vec3::splat(1.9));
    let lamp = Light::point(Vec3::new(2.0, 5.0, 3.0)).color(Vec3::splat(2.2)).reach(20.0);
    (build.shape(Shape::floor(9.0, -3.0)).light(sun).light(lamp).scene, cloth)
}

#[test]
fn a_moved_scene_is_a_new_one_made_there() {
    let request = Request::new(&CAMERA, [97, 55]).samples(4).deferred(true);
    let mut reference = reference();
    let mut variants = present(all(), requires_gpu());
    assert_eq!(variants.failed, 0);
    let (mut moved, cloth_index) = scene(0.0);
    let (mut expected, mut before, mut actual) = (Picture::default(), Picture::default(), Picture::default());
    for time in [0.0, 0.4, 1.7, 1.8, 0.4, 0.0] {
        moved.reshape(cloth_index, &cloth(time)).unwrap();
        let (hidden, seen): (Vec<_>, Vec<_>) = places(time)
            .into_iter()
            .enumerate()
            .map(|(instance, place)| (moved.instance_index(instance as u32).unwrap(), place))
            .partition(|(instance, _)| is_hidden(instance.number(), time));
        moved.set_transforms(seen).unwrap();
        hidden.into_iter().for_each(|(instance, _)| moved.hide(instance).unwrap());
        let (fresh, _) = scene(time);
        assert_eq!((moved.extent(), moved.instances()), (fresh.extent(), fresh.instances()));
        assert_eq!((moved.nodes(), moved.positions()), (fresh.nodes(), fresh.positions()));
        reference.render(&fresh, &request, &mut expected).unwrap();
        assert_ne!(expected.pixels, before.pixels, "nothing has moved until {time}");
        before.clone_from(&expected);
        for (variant, backend) in &mut variants.backends {
            backend.render(&moved, &request, &mut actual).unwrap();
            let agrees = compare(&request, &expected, &actual);
            agrees.unwrap_or_else(|difference| panic!("{variant}, {time} seconds: {difference}"));
        }
    }
}

/// Cameras, lights, sizes and scenes change on backends that reuse data of earlier frames.
#[test]
fn a_frame_does_not_depend_on_the_one_before() {
    let [mut first, second] = [0.0, 1.7].map(|time| scene(time).0);
    let aside = Camera { eye: Vec3::new(3.0, 5.0, 8.0), ..CAMERA };
    let far = Camera { eye: Vec3::new(0.0, 40.0, 90.0), ..CAMERA };
    let mut variants = present(all(), requires_gpu());
    assert_eq!(variants.failed, 0);
    let mut seen = Vec::new();
    let steps: [(&str, &Camera, [u32; 2], bool); 8] = [
        ("at first", &CAMERA, [97, 55], true),
        ("another camera", &aside, [97, 55], true),
        ("the same again", &aside, [97, 55], true),
        ("a camera beyond the scene", &far, [97, 55], true),
        ("another size", &aside, [70, 81], true),
        ("another scene", &aside, [70, 81], false),
        ("the first scene with another light", &aside, [70, 81], true),
        ("and again", &CAMERA, [97, 55], true),
    ];
    for (step, camera, size, is_first) in steps {
        if step.ends_with("another light") {
            first.lights_mut().remove(0);
        }
        let scene = if is_first { &first } else { &second };
        let shadows = Shadows::Hard;
        let request = Request::new(camera, size).shadows(shadows).deferred(true);
        let (mut expected, mut actual) = (Picture::default(), Picture::default());
        reference().render(scene, &request, &mut expected).unwrap();
        for (variant, backend) in &mut variants.backends {
            backend.render(scene, &request, &mut actual).unwrap();
            let agrees = compare(&request, &expected, &actual);
            agrees.unwrap_or_else(|difference| panic!("{variant}, {step}: {difference}"));
        }
        seen.push(expected.pixels);
    }
    // "The same again" is; all others differ.
    let differ = |a: usize, b: usize| seen[a] != seen[b];
    assert!(!differ(1, 2) && differ(0, 1) && differ(0, 7) && (3..7).all(|step| differ(step, step - 1)));
}

/// A frame that was stopped, at once or at any time, and that of a changed scene after it.
#[test]
fn a_stopped_frame_leaves_no_trace() {
    let (mut scene, _) = scene(0.0);
    let mut variants = present(all(), requires_gpu());
    assert_eq!(variants.failed, 0);
    for step in 0..6_u64 {
        let request = Request::new(&CAMERA, [97, 55]).samples(4).deferred(step % 2 == 0);
        for (variant, backend) in &mut variants.backends {
            let (stop, mut picture) = (AtomicBool::new(step == 0), Picture::default());
            let stopped = std::thread::scope(|scope| {
                scope.spawn(|| {
                    std::thread::sleep(Duration::from_millis(3 * step));
                    stop.store(true, Ordering::Relaxed);
                });
                backend.render(&scene, &request.until(&stop), &mut picture)
            });
            match stopped {
                Err(RenderError::Stopped) => {}
                Ok(()) => assert!(step > 0, "{variant}"),
                Err(error) => panic!("{variant}: {error}"),
            }
        }
        scene.set_transform(scene.instance_index(3).unwrap(), places(step as f64)[4]).unwrap();
        agreed(&mut variants, &scene, &request, &step.to_string());
    }
}

/// What lists depend on changes, one thing after another.
#[test]
fn lists_are_kept_only_while_they_would_be_the_same() {
    let (mut scene, cloth) = scene(0.0);
    let mut variants = present(all(), requires_gpu());
    assert_eq!(variants.failed, 0);
    let aside = Camera { eye: Vec3::new(3.0, 5.0, 8.0), ..CAMERA };
    let near = Camera { eye: Vec3::new(0.0, 0.5, 1.5), look_at: Vec3::new(2.0, 0.5, 0.0), ..CAMERA };
    type Change<'a> = &'a dyn Fn(&mut Scene);
    let place = Mat4::from_translation(Vec3::new(1.0, 2.0, -1.0));
    let levels = [(6.0, cloth)];
    let steps: [(&str, Change<'_>, &Camera); 11] = [
        ("at first", &|_| (), &CAMERA),
        ("the same again", &|_| (), &CAMERA),
        ("a camera that has moved", &|_| (), &aside),
        (
            "an instance that has moved",
            &|scene| scene.set_transform(scene.instance_index(3).unwrap(), place).unwrap(),
            &aside,
        ),
        ("a light that is gone", &|scene| _ = scene.lights_mut().pop(), &aside),
        ("one list", &|scene| scene.structure = Structure::None, &aside),
        ("blocks again", &|scene| scene.structure = Structure::Blocks, &near),
        ("shadows that are near", &|scene| scene.occluders = Occluders::Near(1.5), &near),
        ("those that are near from elsewhere", &|_| (), &CAMERA),
        (
            "an instance that is another one far away",
            &|scene| {
                scene.occluders = Occluders::All;
                scene.set_levels(scene.instance_index(1).unwrap(), &levels).unwrap();
            },
            &CAMERA,
        ),
        ("which is itself from close by", &|_| (), &near),
    ];
    let mut before = Vec::new();
    for (step, change, camera) in steps {
        change(&mut scene);
        let shadows = Shadows::Hard;
        let request = Request::new(camera, [97, 55]).shadows(shadows).deferred(true);
        let expected = agreed(&mut variants, &scene, &request, step);
        let lists = expected.deferred.unwrap().lists;
        assert_eq!(lists == before, step == "the same again", "{step}: the lists show nothing");
        before = lists;
    }
}

#[test]
fn a_shape_with_other_triangles_is_refused() {
    let (mut scene, cloth_index) = scene(0.0);
    let other = Mesh::new(vec![], vec![], vec![]).unwrap();
    let before = scene.versions();
    assert!(scene.reshape(cloth_index, &other).is_err());
    assert_eq!(scene.versions(), before);
}

#[test]
fn a_scene_of_hidden_objects_is_an_empty_one() {
    let mut build = Build::default();
    let cube = build.mesh(Shape::cube());
    let instance = build.instance(cube, Mat4::from_translation(Vec3::splat(5.0)));
    build.scene.hide(instance).unwrap();
    assert_eq!(build.scene.extent(), None);
    build.scene.set_transform(instance, Mat4::IDENTITY).unwrap();
    assert_eq!(build.scene.extent(), Some((Vec3::splat(-1.0), Vec3::ONE)));
}

#[test]
fn a_scene_without_what_was_removed_is_one_that_never_had_it() {
    let glass = rtrt_core::scene::Material::new([0.9, 0.5, 0.4]).blend(0.5);
    // Balls, a pane of glass behind them in the arrays, a floor; or boxes in the numbers of the balls.
    let build = |has_balls: bool, has_boxes: bool| {
        let mut build = Build::default();
        let balls = build.mesh(if has_balls { Shape::ball(4) } else { Shape::cube() });
        let at = |i: i32| Mat4::from_translation(Vec3::new((2 * i) as f32, 1.0, -1.0));
        let placed = [-1, 0, 1].map(|i| build.instance(balls, at(i)));
        if !has_balls && !has_boxes {
            placed.into_iter().for_each(|instance| build.scene.hide(instance).unwrap());
        }
        let build = build.shape_of(Shape::floor(2.0, 0.0), glass).shape(Shape::floor(9.0, -3.0));
        let sun = Light::sun(Vec3::new(0.3, -1.0, -0.4)).color(Vec3::splat(1.9));
        (build.light(sun).scene, balls, placed, at)
    };
    let request = Request::new(&CAMERA, [97, 55]).samples(4).layers(3).deferred(true);
    let mut variants = present(all(), requires_gpu());
    assert_eq!(variants.failed, 0);
    let mut same = |scene: &Scene, fresh: &Scene, step: &str| {
        let picture = agreed(&mut variants, scene, &request, step);
        let mut expected = Picture::default();
        reference().render(fresh, &request, &mut expected).unwrap();
        compare(&request, &expected, &picture).unwrap_or_else(|difference| panic!("{step}: {difference}"));
        picture.pixels
    };
    let (mut scene, balls, placed, at) = build(true, false);
    let with = same(&scene, &build(true, false).0, "balls");
    // The last that is removed has the number of the next.
    placed.into_iter().rev().for_each(|instance| scene.remove_instance(instance).unwrap());
    let without = same(&scene, &build(false, false).0, "no instance");
    scene.remove_mesh(balls).unwrap();
    assert_eq!(same(&scene, &build(false, false).0, "no mesh"), without);
    let cube = Shape::cube().mesh();
    let cubes = scene.add_mesh(&cube, &Bvh::build(&cube, &Sequential)).unwrap();
    let gray = scene.material_of(scene.instance_index(4).unwrap()).unwrap();
    for i in [-1, 0, 1] {
        scene.add_instance(cubes, gray, at(i)).unwrap();
    }
    let boxes = same(&scene, &build(false, true).0, "boxes");
    assert!(with != without && boxes != without && boxes != with);
}

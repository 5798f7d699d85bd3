//! What is chosen for a frame: levels of detail, levels of textures, and the structure.

use conformance::shape::{Build, Random, Shape};
use conformance::variants::{all, present, requires_gpu};
use conformance::{cases, compare, reference};
use glam::{Mat4, Vec3};
use rtrt_core::backend::{Backend, Picture, Request, Shadows};
use rtrt_core::scene::{Camera, Light, Material, Mip, Occluders, Projection, Scene, Structure};

const CAMERA: Camera = Camera {
    eye: Vec3::new(0.0, 3.0, 6.0),
    look_at: Vec3::new(0.0, 0.0, -4.0),
    up: Vec3::Y,
    projection: Projection::Perspective { fov_y: 0.9 },
};

fn request(camera: &Camera) -> Request<'_> {
    Request::new(camera, [97, 55]).shadows(Shadows::Hard).deferred(true)
}

/// From which distance on the balls have which level.
const STEPS: [(f32, u32); 3] = [(0.0, 8), (7.0, 4), (12.0, 2)];

/// Balls at many distances: with levels, or each with the mesh that is right for a camera at `eye`.
fn balls(eye: Option<Vec3>) -> (Scene, [u32; 3]) {
    let mut build = Build::default().shape(Shape::floor(40.0, -1.0));
    let meshes = STEPS.map(|(_, steps)| build.mesh(Shape::ball(steps)));
    // The coarsest ones have a color of their own.
    let blue = Material::new([0.2, 0.3, 0.9]).roughness(0.6);
    let blue = build.scene.add_material(blue).unwrap();
    let materials = [build.gray, build.gray, blue];
    let mut random = Random(4);
    let mut counts = [0; 3];
    for _ in 0..60 {
        let (center, size) = (random.vector(9.0) * Vec3::new(1.0, 0.1, 1.0), random.within(0.2, 0.7));
        let place = Mat4::from_translation(center) * Mat4::from_scale(Vec3::splat(size));
        match eye {
            None => {
                let ball = build.instance(meshes[0], place);
                let levels = [2, 1].map(|level| (STEPS[level].0, meshes[level], materials[level]));
                build.scene.set_levels_with(ball, &levels).unwrap();
            }
            Some(eye) => {
                // To the nearest point of the box around the ball.
                let away = ((eye - center).abs() - size).max(Vec3::ZERO).length();
                let level = STEPS.iter().rposition(|(from, _)| away >= *from).unwrap();
                counts[level] += 1;
                build.scene.add_instance(meshes[level], materials[level], place).unwrap();
            }
        }
    }
    (build.light(Light::point([2.0, 6.0, 3.0])).light(Light::sun([0.3, -1.0, 0.2])).scene, counts)
}

#[test]
fn a_scene_with_levels_is_one_with_the_meshes_that_are_chosen() {
    let (scene, _) = balls(None);
    let mut variants = present(all(), requires_gpu());
    assert_eq!(variants.failed, 0);
    let mut reference = reference();
    let (mut expected, mut actual) = (Picture::default(), Picture::default());
    let mut pictures = Vec::new();
    for eye in [CAMERA.eye, Vec3::new(3.0, 2.5, 5.0), CAMERA.eye] {
        let camera = Camera { eye, ..CAMERA };
        let (chosen, counts) = balls(Some(eye));
        assert!(counts.iter().all(|&count| count > 1), "{counts:?}");
        reference.render(&chosen, &request(&camera), &mut expected).unwrap();
        pictures.push(expected.pixels.clone());
        for (name, backend) in &mut variants.backends {
            backend.render(&scene, &request(&camera), &mut actual).unwrap();
            let compared = compare(&request(&camera), &expected, &actual);
            compared.unwrap_or_else(|why| panic!("{name}, from {eye}: {why}"));
        }
    }
    assert!(pictures[0] != pictures[1] && pictures[0] == pictures[2]);
    // Had the near mesh been drawn everywhere, it would show.
    let mut near = balls(None).0;
    for instance in 1..61 {
        let instance = near.instance_index(instance).unwrap();
        near.set_levels(instance, &[]).unwrap();
    }
    reference.render(&near, &request(&CAMERA), &mut actual).unwrap();
    assert_ne!(actual.pixels, pictures[0]);
}

#[test]
fn levels_that_make_no_sense_are_refused() {
    let (mut scene, _) = balls(None);
    let ball = scene.instance_index(1).unwrap();
    let mut other = Build::default();
    let mesh = [0, 1, 2, 3, 4].map(|_| other.mesh(Shape::cube()))[4];
    for from in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        assert!(scene.set_levels(ball, &[(from, mesh)]).is_err(), "{from}");
    }
    assert!(scene.set_levels(ball, &[(2.0, mesh)]).is_err());
    assert!(other.scene.set_levels(ball, &[]).is_err());
    assert_eq!(scene.instance_index(999), None);
}

#[test]
fn no_picture_depends_on_the_structure() {
    let mut reference = reference();
    let (mut expected, mut actual) = (Picture::default(), Picture::default());
    let mut differ = 0;
    for case in cases::all() {
        let mut scene = (case.scene)();
        // Whole lists for each ray of the largest take minutes.
        if scene.instances().len() > 1500 {
            continue;
        }
        scene.structure = Structure::Objects;
        reference.render(&scene, &case.request(), &mut expected).unwrap();
        let expected = expected.deferred.as_mut().unwrap();
        let lists = core::mem::take(&mut expected.lists);
        for structure in [Structure::Blocks, Structure::Parts(16), Structure::Parts(1), Structure::None] {
            scene.structure = structure;
            reference.render(&scene, &case.request(), &mut actual).unwrap();
            let actual = actual.deferred.as_mut().unwrap();
            differ += usize::from(actual.lists != lists);
            actual.lists.clear();
            assert_eq!(expected, actual, "{} {structure:?}", case.name);
        }
    }
    assert!(differ > 200, "{differ}");
}

#[test]
fn parts_follow_what_they_are_parts_of() {
    let mut variants = present(all(), requires_gpu());
    assert_eq!(variants.failed, 0);
    let mut build = Build::default().shape(Shape::floor(8.0, -1.0)).light(Light::point([2.0, 6.0, 3.0]));
    let ball = build.mesh(Shape::ball(8));
    let balls =
        [-1.4, 0.0, 1.4].map(|x| build.instance(ball, Mat4::from_translation(Vec3::new(x, 0.0, 1.0))));
    let mut scene = build.scene;
    let (mut expected, mut actual) = (Picture::default(), Picture::default());
    let mut pictures = Vec::new();
    for step in 0..7 {
        match step {
            1 => scene.structure = Structure::Parts(4),
            2 => scene.set_transform(balls[1], Mat4::from_scale(Vec3::new(1.0, 0.5, 1.5))).unwrap(),
            3 => scene.reshape(ball, &Shape::ball(8).at([0.0; 3], 0.7).mesh()).unwrap(),
            4 => scene.structure = Structure::Objects,
            5 => scene.structure = Structure::Parts(20),
            6 => scene.hide(balls[2]).unwrap(),
            _ => {}
        }
        // A setup without a frame before.
        reference().render(&scene, &request(&CAMERA), &mut expected).unwrap();
        pictures.push(expected.pixels.clone());
        for (name, backend) in &mut variants.backends {
            backend.render(&scene, &request(&CAMERA), &mut actual).unwrap();
            let compared = compare(&request(&CAMERA), &expected, &actual);
            compared.unwrap_or_else(|why| panic!("{name}, step {step}: {why}"));
        }
    }
    let changes: Vec<_> = pictures.windows(2).map(|pair| pair[0] != pair[1]).collect();
    assert_eq!(changes, [false, true, true, false, false, true]);
}

#[test]
fn far_shadows_of_suns_are_missing_and_take_no_room_in_lists() {
    let case = cases::named("bin/shadows_that_are_near").unwrap();
    let mut scene = (case.scene)();
    let mut reference = reference();
    let [all, near] = [Occluders::All, Occluders::Near(4.0)].map(|occluders| {
        scene.occluders = occluders;
        let mut picture = Picture::default();
        reference.render(&scene, &case.request(), &mut picture).unwrap();
        let deferred = picture.deferred.unwrap();
        let lit = deferred.masks.iter().map(|mask| mask.count_ones()).sum::<u32>();
        (deferred.lists.len(), deferred.hits, lit)
    });
    assert!(near.0 * 10 < all.0 * 9, "{} of {}", near.0, all.0);
    assert_eq!(near.1, all.1);
    assert!(near.2 > all.2);
}

#[test]
fn footprints_grow_by_one_over_the_cosine() {
    let floor = Shape::floor(60.0, -1.0).textured([90.0, 90.0], [0.0, 0.0]);
    let mut scene = Build::default().shape(floor).light(Light::point([1.0, 3.0, 0.0])).scene;
    let mut reference = reference();
    let (mut distance, mut angle) = (Picture::default(), Picture::default());
    reference.render(&scene, &request(&CAMERA), &mut distance).unwrap();
    scene.mip = Mip::Angle;
    reference.render(&scene, &request(&CAMERA), &mut angle).unwrap();
    let [distance, angle] = [distance, angle].map(|picture| picture.deferred.unwrap());
    assert_eq!(distance.hits, angle.hits);
    let (mut judged, mut most) = (0, 0.0_f64);
    for (before, after) in distance.surfaces.iter().zip(&angle.surfaces) {
        if before.material == 0 {
            continue;
        }
        let place = Vec3::from(before.origin).as_dvec3();
        let way = (place - CAMERA.eye.as_dvec3()).normalize();
        let ratio = f64::from(after.footprint) / f64::from(before.footprint);
        let expected = (1.0 / way.y.abs()).min(1024.0);
        assert!((ratio / expected - 1.0).abs() < 1e-4, "{ratio} {expected}");
        judged += 1;
        most = most.max(ratio);
    }
    assert!(judged > 500 && most > 5.0, "{judged} {most}");
}

//! Frames from within a closed mesh: no camera ray gets out, and no light gets in.

use conformance::reference;
use conformance::shape::{Build, Random, Shape};
use glam::{Mat4, Quat, Vec3};
use rtrt_core::backend::{Backend, Picture, Request, Shadows};
use rtrt_core::layout::NONE;
use rtrt_core::scene::{Camera, Light, Projection};

/// A ball of triangles without a gap: corners of neighbors are sums of the same numbers.
fn ball() -> Vec<[Vec3; 3]> {
    let mut triangles = vec![];
    for octant in 0..8 {
        let sign = |bit: u32| if octant >> bit & 1 == 0 { 1.0 } else { -1.0 };
        triangles.push([Vec3::X * sign(0), Vec3::Y * sign(1), Vec3::Z * sign(2)]);
    }
    for _ in 0..4 {
        triangles = triangles
            .into_iter()
            .flat_map(|[a, b, c]| {
                let [ab, bc, ca] = [a + b, b + c, c + a].map(Vec3::normalize);
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    triangles
}

/// The rays that get out of these triangles, and those that light from outside reaches, in frames from within: with
/// the triangles as they are, and stretched, turned and moved.
fn leaks(triangles: &[[Vec3; 3]]) -> [usize; 2] {
    let mut random = Random(9);
    let turn = Quat::from_scaled_axis(Vec3::new(0.3, -1.0, 0.4));
    let stretched =
        Mat4::from_scale_rotation_translation(Vec3::new(0.3, 2.0, 5.0), turn, Vec3::new(10.0, -3.0, 0.3));
    let mut leaks = [0; 2];
    for place in [Mat4::IDENTITY, stretched] {
        let shapes = triangles.iter().map(|corners| Shape::triangle(corners.map(|c| c.to_array())));
        let mut build = Build::default();
        let mesh = build.mesh(shapes.reduce(Shape::and).expect("triangles"));
        build.instance(mesh, place);
        let scene = build
            .light(Light::point(place.transform_point3(Vec3::new(0.0, 9.0, 2.0))))
            .light(Light::sun(Vec3::new(0.3, -1.0, 0.2)))
            .scene;
        for _ in 0..6 {
            let camera = Camera {
                eye: place.transform_point3(random.vector(0.3)),
                look_at: place.transform_point3(random.vector(1.0).normalize()),
                up: Vec3::Y,
                projection: Projection::Perspective { fov_y: 1.5 },
            };
            let request = Request::new(&camera, [160, 128]).shadows(Shadows::Hard).deferred(true);
            let mut picture = Picture::default();
            reference().render(&scene, &request, &mut picture).expect("a frame");
            let deferred = picture.deferred.take().expect("it was requested");
            leaks[0] += deferred.hits.iter().filter(|hit| hit.instance == NONE).count();
            leaks[1] += deferred.masks.iter().filter(|mask| **mask != 0).count();
        }
    }
    leaks
}

#[test]
fn nothing_outside_is_seen_and_no_light_gets_in() {
    assert_eq!(leaks(&ball()), [0; 2]);
}

#[test]
fn through_a_gap_rays_get_out_and_light_gets_in() {
    // In every other triangle.
    let gaps: Vec<_> = ball().into_iter().step_by(2).collect();
    let [out, lit] = leaks(&gaps);
    assert!(out > 1000 && lit > 1000, "{out} {lit}");
}

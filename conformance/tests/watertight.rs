//! Frames from within a closed mesh: no camera ray gets out, and no light gets in.

use conformance::reference;
use conformance::shape::{Build, Random, Shape};
use glam::{Mat4, Quat, Vec3};
use rtrt_core::backend::{Backend, Picture, Request, Shadows};
use rtrt_core::layout::NONE;
use rtrt_core::scene::{Camera, Light, Projection};

/// A ball of triangles without a gap: corners of neighbors are sums of the same numbers.
fn ball() -> Shape {
    let corner = |[x, y, z]: [f32; 3]| Vec3::new(x, y, z);
    let mut triangles = vec![];
    for octant in 0..8 {
        let sign = |bit: u32| if octant >> bit & 1 == 0 { 1.0_f32 } else { -1.0 };
        triangles.push([[sign(0), 0.0, 0.0], [0.0, sign(1), 0.0], [0.0, 0.0, sign(2)]].map(corner));
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
    let shapes = triangles.into_iter().map(|corners| Shape::triangle(corners.map(|c| c.to_array())));
    shapes.reduce(Shape::and).expect("triangles")
}

#[test]
fn nothing_outside_is_seen_and_no_light_gets_in() {
    let mut random = Random(9);
    let places = [
        Mat4::IDENTITY,
        Mat4::from_scale_rotation_translation(
            Vec3::new(0.3, 2.0, 5.0),
            Quat::from_scaled_axis(Vec3::new(0.3, -1.0, 0.4)),
            Vec3::new(10.0, -3.0, 0.3),
        ),
    ];
    for place in places {
        let mut build = Build::default();
        let mesh = build.mesh(ball());
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
            assert!(deferred.hits.iter().all(|hit| hit.instance != NONE), "a ray got out");
            assert!(deferred.masks.iter().all(|mask| *mask == 0), "light got in");
        }
    }
}

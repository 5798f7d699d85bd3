//! Instances that are not double-sided: their picture, and their shadows.

use conformance::reference;
use conformance::shape::{Build, Shape};
use glam::{Mat4, Vec3};
use rtrt_core::backend::{Backend, Deferred, Picture, Request, Shadows};
use rtrt_core::layout::NONE;
use rtrt_core::scene::{Camera, Light, Material, Projection, Scene};

/// A material that is seen from one side.
fn one_sided() -> Material {
    Material::new([0.8; 3]).roughness(0.5).double_sided(false)
}

/// The hits of rays from `eye` toward the origin, 0.02 apart.
fn seen(scene: &Scene, eye: Vec3) -> Deferred {
    let projection = Projection::Orthographic { height: 0.3 };
    let camera = Camera { eye, look_at: Vec3::ZERO, up: Vec3::Y, projection };
    let (shadows, size) = (Shadows::Hard, [16, 16]);
    let request = Request::new(&camera, size).shadows(shadows).layers(4).deferred(true);
    let mut picture = Picture::default();
    reference().render(scene, &request, &mut picture).unwrap();
    picture.deferred.take().unwrap()
}

/// The instance that every ray meets first.
fn met(scene: &Scene, eye: Vec3) -> u32 {
    let deferred = seen(scene, eye);
    let first = deferred.hits[0].instance;
    assert!(deferred.hits.iter().all(|hit| hit.instance == first), "an edge is seen");
    first
}

/// A square across the view, which faces +z.
fn square(z: f32) -> Shape {
    Shape::quad([-3.0, -3.0, z], [6.0, 0.0, 0.0], [0.0, 6.0, 0.0])
}

#[test]
fn a_back_is_looked_through() {
    let scene = Build::default().shape_of(square(0.0), one_sided()).shape(square(-1.0)).scene;
    assert_eq!(met(&scene, Vec3::Z * 4.0), 0);
    // From behind, the other square is nearer, and double-sided.
    assert_eq!(met(&scene, Vec3::Z * -4.0), 1);
    assert_eq!(met(&scene, Vec3::Z * -0.5), NONE);
}

#[test]
fn the_front_of_what_is_mirrored_is_where_it_was() {
    let mut build = Build::default();
    let material = build.scene.add_material(one_sided()).unwrap();
    let mesh = build.mesh(square(0.0));
    let instance =
        build.scene.add_instance(mesh, material, Mat4::from_scale(Vec3::new(-1.0, 1.0, 1.0))).unwrap();
    assert_eq!(met(&build.scene, Vec3::Z * 4.0), 0);
    assert_eq!(met(&build.scene, Vec3::Z * -4.0), NONE);
    // Moved, it is as before; turned over by a mirror, it faces the other way.
    build.scene.set_transform(instance, Mat4::from_scale(Vec3::new(1.0, 1.0, -1.0))).unwrap();
    assert_eq!(met(&build.scene, Vec3::Z * 4.0), NONE);
    assert_eq!(met(&build.scene, Vec3::Z * -4.0), 0);
}

#[test]
fn a_sphere_has_no_inside() {
    let mut build = Build::default();
    let material = build.scene.add_material(one_sided()).unwrap();
    let around = Mat4::from_scale(Vec3::splat(2.0));
    build.scene.add_sphere(material, around).unwrap();
    assert_eq!(met(&build.scene, Vec3::Z * 4.0), 0);
    assert_eq!(met(&build.scene, Vec3::Z), NONE);
}

#[test]
fn light_passes_what_it_sees_the_back_of() {
    // The sun is above the front of a floor, or below its back; another floor is beyond.
    for (sun_goes, screen, through) in [(-1.0, 1.0, 0), (1.0, -1.0, 256)] {
        let lit = |screen_material: Option<Material>| {
            let floor =
                Build::default().shape(Shape::floor(3.0, 0.0)).light(Light::sun([0.1, sun_goes, 0.1]));
            let scene = match screen_material {
                Some(material) => floor.shape_of(Shape::floor(3.0, screen), material),
                None => floor,
            }
            .scene;
            let deferred = seen(&scene, Vec3::new(0.0, 0.5 * screen, 0.01));
            assert!(deferred.hits.iter().all(|hit| hit.instance == 0));
            deferred.masks.iter().filter(|&&mask| mask == 1).count()
        };
        assert_eq!([lit(None), lit(Some(one_sided().double_sided(true)))], [256, 0]);
        assert_eq!(lit(Some(one_sided())), through);
    }
}

#[test]
fn a_glass_is_as_many_layers_as_it_has_fronts() {
    let glass = one_sided().blend(0.5);
    let layers = |material| {
        let scene = Build::default().shape_of(Shape::cube(), material).scene;
        let deferred = seen(&scene, Vec3::Z * 4.0);
        deferred.layers[..deferred.layer_count as usize].iter().filter(|hit| hit.instance != NONE).count()
    };
    assert_eq!(layers(glass), 0);
    assert_eq!(layers(glass.double_sided(true)), 1);
}

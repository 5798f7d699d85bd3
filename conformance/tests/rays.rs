//! Single rays with every instruction set and on all threads, against the world's own answers.

use conformance::shape::Random;
use glam::{Mat4, Vec3};
use rtrt_core::query::{Ray, Tree};
use rtrt_core::scene::{Attribute, Bvh, Material, Mesh, Scene};
use rtrt_cpu::{Caster, Cpu, InstructionSet, Options, Parallel};

#[test]
fn answers_are_those_of_the_world_one_by_one_and_in_slices() {
    let mut random = Random(1);
    let mut point = |size: f32| [(); 3].map(|()| random.within(-size, size));
    let positions: Vec<_> = (0..900).map(|_| point(1.0)).collect();
    let attribute = Attribute { normal: [0.0; 3], uv: [0.0; 2], color: Attribute::WHITE };
    let mesh = Mesh::new(positions, vec![attribute; 900], (0..900).collect()).expect("a mesh");
    let mut scene = Scene::new();
    let white = scene.add_material(Material::default()).expect("a material");
    let mesh = scene.add_mesh(&mesh, &Bvh::build(&mesh, &Parallel)).expect("a mesh");
    for _ in 0..40 {
        let place = Mat4::from_translation(Vec3::from(point(4.0)));
        scene.add_instance(mesh, white, place).expect("an instance");
        scene.add_sphere(white, place).expect("a sphere");
    }
    let mut tree = Tree::new(&scene, &Parallel);
    let world = tree.world(&scene);
    let mut rays: Vec<_> = (0..3000).map(|_| Ray::new(point(5.0), point(1.0)).until(20.0)).collect();
    rays[77].direction = [0.0; 3];
    let mut expected: Vec<_> = rays.iter().map(|ray| world.closest(ray)).collect();
    let mut occluded: Vec<_> = rays.iter().map(|ray| world.occluded(ray)).collect();
    assert!(expected.iter().filter(|hit| matches!(hit, Ok(Some(_)))).count() > 500);
    assert!(expected[77].is_err());
    let levels = InstructionSet::wide().into_iter().chain([InstructionSet::Scalar]);
    for caster in levels.map(Caster::with) {
        for (ray, expected) in rays.iter().zip(&expected) {
            assert_eq!(caster.closest(&world, ray), *expected);
        }
        for (ray, occluded) in rays.iter().zip(&occluded) {
            assert_eq!(caster.occluded(&world, ray), *occluded);
        }
    }
    // Rows of a picture are traced together.
    let eye = Vec3::new(0.5, 1.0, 9.0);
    let to = |i: u16| Vec3::new(f32::from(i % 64) / 4.0 - 8.0, f32::from(i / 64) / 4.0 - 8.0, 0.0);
    rays.extend((0..64 * 64).map(|i| Ray::new(eye, to(i) - eye)));
    expected.extend(rays[3000..].iter().map(|ray| world.closest(ray)));
    occluded.extend(rays[3000..].iter().map(|ray| world.occluded(ray)));
    let nothing = || (vec![Ok(None); rays.len()], vec![Ok(false); rays.len()]);
    for caster in InstructionSet::wide().into_iter().chain([InstructionSet::Scalar]).map(Caster::with) {
        let (mut hits, mut hidden) = nothing();
        caster.closest_each(&world, &rays, &mut hits);
        caster.occluded_each(&world, &rays, &mut hidden);
        assert_eq!((&hits, &hidden), (&expected, &occluded));
    }
    let cpu = Cpu::new(Options { threads: Some(3), ..Options::default() }).expect("a backend");
    let (mut hits, mut hidden) = nothing();
    cpu.closest(&world, &rays, &mut hits);
    cpu.occluded(&world, &rays, &mut hidden);
    assert_eq!((hits, hidden), (expected, occluded));
}

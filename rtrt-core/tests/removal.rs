//! What is removed is gone, what takes its number is there, and the rest is as it was.

use glam::{Mat4, Vec3};
use rtrt_core::query::{Hit, Ray, Shapes, Source, Tree, World};
use rtrt_core::scene::{
    Attribute, Bvh, InstanceIndex, Material, Mesh, MeshIndex, Scene, SceneError, Sequential,
};

/// Numbers that look random.
struct Random(u32);

impl Random {
    fn below(&mut self, end: usize) -> usize {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (self.0 >> 8) as usize % end
    }
    /// Within −1 .. 1.
    fn signed(&mut self) -> f32 {
        self.below(1 << 24) as f32 / (1 << 23) as f32 - 1.0
    }
    fn vector(&mut self, size: f32) -> Vec3 {
        Vec3::new(self.signed(), self.signed(), self.signed()) * size
    }
    /// Half of the places are where the mesh was modelled.
    fn place(&mut self) -> Mat4 {
        if self.below(2) == 0 { Mat4::IDENTITY } else { Mat4::from_translation(self.vector(5.0)) }
    }
}

/// Triangles strewn over a cube.
fn heap(random: &mut Random, triangles: u32) -> Mesh {
    let positions: Vec<_> = (0..triangles)
        .flat_map(|_| {
            let center = random.vector(4.0);
            [0; 3].map(|_| (center + random.vector(0.5)).to_array())
        })
        .collect();
    let attribute = Attribute { normal: [0.0, 1.0, 0.0], uv: [0.0; 2], color: Attribute::WHITE };
    let count = positions.len();
    Mesh::new(positions, vec![attribute; count], (0..count as u32).collect()).unwrap()
}

/// What a ray hits, but for the instance's number.
fn row(hit: Option<Hit>) -> Option<(f32, u32, f32, f32)> {
    hit.map(|Hit { t, triangle, u, v, .. }| (t, triangle, u, v))
}

/// Compares a world that has followed with new ones.
fn compare<S: Source, T: Source>(
    random: &mut Random,
    followed: World<'_, S>,
    others: [World<'_, T>; 2],
) -> usize {
    let mut hits = 0;
    for _ in 0..60 {
        let ray = Ray::new(random.vector(9.0), random.vector(1.0));
        let hit = followed.closest(&ray).unwrap();
        for other in &others {
            assert_eq!(row(hit), row(other.closest(&ray).unwrap()), "{ray:?}");
            assert_eq!(followed.occluded(&ray), other.occluded(&ray));
        }
        hits += usize::from(hit.is_some_and(|hit| followed.surface(&hit).is_some()));
    }
    hits
}

#[test]
fn a_tree_follows_what_is_removed_and_what_takes_its_place() {
    let mut random = Random(4);
    let shapes: Vec<Mesh> = [40, 300, 1000, 7].map(|triangles| heap(&mut random, triangles)).into();
    let (mut scene, mut own) = (Scene::new(), Shapes::new());
    let white = scene.add_material(Material::default().double_sided(true)).unwrap();
    // The meshes that are there by number of the shape, and the instances with shape and place.
    let mut meshes: Vec<(usize, MeshIndex, MeshIndex)> = vec![];
    let mut there: Vec<(usize, Mat4, InstanceIndex, InstanceIndex)> = vec![];
    let (mut tree, mut own_tree) = (Tree::default(), Tree::default());
    let (mut hits, mut refused, mut most) = (0, 0, 0);
    for step in 0..400 {
        match random.below(8) {
            0 | 1 if meshes.len() < 6 => {
                let shape = random.below(shapes.len());
                let mesh = &shapes[shape];
                let a = scene.add_mesh(mesh, &Bvh::build(mesh, &Sequential)).unwrap();
                let b = own.add_mesh(mesh.positions(), mesh.indices(), &Sequential).unwrap();
                meshes.push((shape, a, b));
            }
            2 if !meshes.is_empty() => {
                let number = random.below(meshes.len());
                let (_, a, b) = meshes[number];
                let result = scene.remove_mesh(a);
                assert_eq!(result.is_ok(), own.remove_mesh(b).is_ok());
                match result {
                    Ok(()) => {
                        meshes.swap_remove(number);
                        assert!(scene.add_instance(a, white, Mat4::IDENTITY).is_err());
                        assert!(own.add_instance(b, Mat4::IDENTITY).is_err() && own.bvh(b).is_none());
                    }
                    Err(error) => {
                        assert!(matches!(error, SceneError::InUse { .. }));
                        refused += 1;
                    }
                }
            }
            3..=5 if !meshes.is_empty() => {
                let (shape, a, b) = meshes[random.below(meshes.len())];
                let place = random.place();
                let added = (scene.add_instance(a, white, place), own.add_instance(b, place));
                there.push((shape, place, added.0.unwrap(), added.1.unwrap()));
            }
            _ if !there.is_empty() => {
                let (.., a, b) = there.swap_remove(random.below(there.len()));
                assert_eq!((scene.remove_instance(a), own.remove_instance(b)), (Ok(()), Ok(())));
                assert!(scene.remove_instance(a).is_err() && own.set_transform(b, Mat4::IDENTITY).is_err());
                assert_eq!((scene.instance_index(a.number()), own.instance_index(b.number())), (None, None));
            }
            _ => {}
        }
        most = most.max(scene.instances().len());
        let mut fresh = Scene::new();
        let white = fresh.add_material(Material::default().double_sided(true)).unwrap();
        for &(shape, place, ..) in &there {
            let mesh = &shapes[shape];
            let index = fresh.add_mesh(mesh, &Bvh::build(mesh, &Sequential)).unwrap();
            fresh.add_instance(index, white, place).unwrap();
        }
        // Every other step, so that changes come alone and together.
        if step % 2 == 0 {
            let (mut new, mut newer) = (Tree::default(), Tree::default());
            let others = [new.world(&fresh), newer.world(&fresh)];
            hits += compare(&mut random, tree.world(&scene), others);
            compare(&mut random, own_tree.world(&own), others);
        }
        assert_eq!(scene.extent(), fresh.extent());
    }
    // Numbers were used again.
    assert!(hits > 600 && refused > 3 && most < 40, "{hits} {refused} {most}");
}

#[test]
fn a_hit_of_what_is_gone_is_no_hit_of_what_has_its_number() {
    let mut random = Random(9);
    let mesh = heap(&mut random, 50);
    let mut scene = Scene::new();
    let white = scene.add_material(Material::default()).unwrap();
    let index = scene.add_mesh(&mesh, &Bvh::build(&mesh, &Sequential)).unwrap();
    let first = scene.add_instance(index, white, Mat4::IDENTITY).unwrap();
    scene.set_user_data(first, 7).unwrap();
    scene.set_ray_mask(first, 1).unwrap();
    let mut tree = Tree::default();
    let aim = Vec3::from(mesh.positions()[0]).lerp(mesh.positions()[1].into(), 0.4);
    let ray =
        Ray::between([20.0, 21.0, 22.0], aim.lerp(mesh.positions()[2].into(), 0.3)).until(f32::INFINITY);
    let hit = tree.world(&scene).closest(&ray).unwrap().unwrap();
    assert!(!scene.is_removed(first) && !scene.is_mesh_removed(index));
    scene.remove_instance(first).unwrap();
    assert!(scene.is_removed(first) && !Scene::new().is_removed(first));
    let second = scene.add_instance(index, white, Mat4::IDENTITY).unwrap();
    assert!(scene.is_removed(first) && !scene.is_removed(second));
    let world = tree.world(&scene);
    assert_eq!(
        (world.surface(&hit), world.source_triangle(&hit), world.user_data(first)),
        (None, None, None)
    );
    // The new one has no groups or numbers of the old one, and to skip the old one skips nothing.
    let again = world.closest(&ray.mask(2).skip(first)).unwrap().unwrap();
    assert_eq!(
        (again.instance, row(Some(again)), world.user_data(second)),
        (second, row(Some(hit)), Some(0))
    );
    assert_eq!(world.closest(&ray.skip(second)), Ok(None));
    scene.remove_instance(second).unwrap();
    scene.remove_mesh(index).unwrap();
    assert!(scene.is_mesh_removed(index) && !Scene::new().is_mesh_removed(index));
    let next = scene.add_mesh(&mesh, &Bvh::build(&mesh, &Sequential)).unwrap();
    assert!(scene.is_mesh_removed(index) && !scene.is_mesh_removed(next));
}

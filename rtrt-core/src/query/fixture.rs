//! Scenes for tests of queries.

use super::seek::Placed;
use super::tree::Tree;
use crate::layout::Attribute;
use crate::scene::{Bvh, InstanceIndex, Material, Mesh, MeshIndex, Scene, Sequential};
use glam::{DVec3, Mat4, Quat, Vec3};
use std::vec;
use std::vec::Vec;

/// Numbers that look random.
pub(crate) struct Random(pub u32);

impl Random {
    fn bits(&mut self) -> u32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        self.0 >> 8
    }

    /// A number below another one.
    pub fn below(&mut self, end: usize) -> usize {
        self.bits() as usize % end
    }

    /// A number within −1 .. 1.
    pub fn signed(&mut self) -> f32 {
        self.bits() as f32 / (1 << 23) as f32 - 1.0
    }

    /// A vector of numbers within −`size` .. `size`.
    pub fn vector(&mut self, size: f32) -> Vec3 {
        Vec3::new(self.signed(), self.signed(), self.signed()) * size
    }

    /// A place in a world of this size, turned and stretched.
    pub fn place(&mut self, size: f32) -> Mat4 {
        let [place, turn, scale] = [0; 3].map(|_| self.vector(1.0));
        Mat4::from_scale_rotation_translation(scale.exp(), Quat::from_scaled_axis(turn * 3.0), place * size)
    }

    /// A mesh of triangles that are anywhere within a box of this size.
    pub fn mesh(&mut self, triangles: usize, size: f32) -> Mesh {
        let attribute = Attribute { normal: [0.0; 3], uv: [0.0; 2], color: Attribute::WHITE };
        let corners = |_| {
            let center = self.vector(size);
            [0; 3].map(|_| (center + self.vector(size * 0.3)).to_array())
        };
        let positions: Vec<_> = (0..triangles).flat_map(corners).collect();
        let indices = (0..positions.len() as u32).collect();
        Mesh::new(positions, vec![attribute; 3 * triangles], indices).unwrap()
    }
}

/// Adds a mesh.
pub(crate) fn add(scene: &mut Scene, mesh: &Mesh) -> MeshIndex {
    scene.add_mesh(mesh, &Bvh::build(mesh, &Sequential)).unwrap()
}

/// Whether an instance is met in the merged tree.
pub(crate) fn is_merged(tree: &Tree, instance: InstanceIndex) -> bool {
    tree.instances.entries[instance.number as usize].is_merged
}

/// Meshes and spheres strewn over a world, the last one hidden, every other one not of group 2; and trees over them. The
/// first three are merged but for the second one, which has moved out.
pub(crate) fn strewn(random: &mut Random) -> (Scene, Tree) {
    let mut scene = Scene::new();
    let material = scene.add_material(Material::default()).unwrap();
    let turn = Quat::from_scaled_axis(Vec3::Z);
    let together = Mat4::from_scale_rotation_translation(Vec3::new(3.0, -1.0, 2.0), turn, Vec3::Y);
    let mut instances = vec![];
    for _ in 0..3 {
        let mesh = add(&mut scene, &random.mesh(100, 1.0));
        instances.push(scene.add_instance(mesh, material, together).unwrap());
    }
    let mesh = add(&mut scene, &random.mesh(100, 1.0));
    for number in 0..57 {
        let scale = if number % 3 == 0 { Vec3::new(0.5, 2.0, -0.1) } else { Vec3::splat(0.7) };
        let turn = Quat::from_scaled_axis(random.vector(3.0));
        let place = Mat4::from_scale_rotation_translation(scale, turn, random.vector(6.0));
        instances.push(if number % 4 == 0 {
            scene.add_sphere(material, place).unwrap()
        } else {
            scene.add_instance(mesh, material, place).unwrap()
        });
    }
    scene.hide(instances[instances.len() - 1]).unwrap();
    instances.iter().step_by(2).for_each(|&instance| scene.set_ray_mask(instance, 1).unwrap());
    let mut tree = Tree::new(&scene, &Sequential);
    scene.set_transform(instances[1], Mat4::from_translation(Vec3::X)).unwrap();
    tree.update(&scene, &Sequential);
    assert!(instances[..4].iter().map(|&instance| is_merged(&tree, instance)).eq([true, false, true, false]));
    (scene, tree)
}

/// Everything that can be near or overlap, one after the other: a sphere, or a triangle.
pub(crate) fn each(scene: &Scene, mut see: impl FnMut(u32, u32, &Placed, Option<[DVec3; 3]>)) {
    for (number, instance) in (0..).zip(scene.instances()) {
        let placed = Placed::of(instance);
        if instance.is_sphere() {
            see(number, 0, &placed, None);
            continue;
        }
        for id in 0..instance.triangles {
            let corners = instance.corners(scene.mesh_data(), id).map(|v| scene.positions()[v as usize]);
            see(number, id, &placed, Some(placed.triangle(corners)));
        }
    }
}

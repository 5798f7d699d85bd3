//! What is near a point, and what a box or a sphere overlaps.

use super::block::Block;
use super::merged::MergedLeaf;
use super::ray::{QueryError, check_point};
use super::shape::{box_meets_ellipsoid, box_meets_triangle, nearest_on_ellipsoid, nearest_on_triangle};
use super::source::Source;
use super::tree::MeshTree;
use super::wide::{Child, WIDTH, WideNode, WideTree};
use super::world::{Hit, World};
use crate::kernel::environment::octahedral;
use crate::kernel::traverse::STACK;
use crate::lane::V3;
use crate::layout::Instance;
use crate::scene::{Bounds, InstanceIndex, from_rows};
use glam::{DMat3, DVec3};

/// A box along the axes, or a ball.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Volume {
    low: [f32; 3],
    high: [f32; 3],
    /// Of a ball.
    radius: Option<f32>,
}

impl Volume {
    /// The box between two corners, whichever is the lower along each axis.
    pub fn between(one: impl Into<[f32; 3]>, other: impl Into<[f32; 3]>) -> Self {
        let (one, other) = (one.into(), other.into());
        let low = [0, 1, 2].map(|axis| one[axis].min(other[axis]));
        let high = [0, 1, 2].map(|axis| one[axis].max(other[axis]));
        // The lesser of NaN and a number is the number: NaN must be seen.
        let is_whole = one.iter().chain(&other).all(|c| !c.is_nan());
        if is_whole { Self { low, high, radius: None } } else { Self { low: one, high: other, radius: None } }
    }

    /// The ball around a point.
    pub fn ball(center: impl Into<[f32; 3]>, radius: f32) -> Self {
        let center = center.into();
        Self { low: center, high: center, radius: Some(radius) }
    }

    fn check(&self) -> Result<(), QueryError> {
        check_point(self.low)?;
        check_point(self.high)?;
        match self.radius {
            Some(distance) => check_distance(distance),
            None => Ok(()),
        }
    }
}

fn check_distance(distance: f32) -> Result<(), QueryError> {
    if distance >= 0.0 { Ok(()) } else { Err(QueryError::Distance { distance }) }
}

/// Something that a [`Volume`] overlaps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Overlap {
    /// The instance.
    pub instance: InstanceIndex,
    /// The triangle, numbered as that of a [`Hit`]; of a sphere, 0.
    pub triangle: u32,
}

impl Overlap {
    /// No overlap: what slices can be filled with before [`World::overlaps`].
    pub const NONE: Self = Self { instance: Hit::NONE.instance, triangle: u32::MAX };
}

impl<S: Source> World<'_, S> {
    /// The point of all surfaces that is nearest to `point`, if one is no farther away than `within`, as a hit whose `t` is
    /// the distance; [`World::surface`] has its position. Of a sphere the triangle is 0 outside and 1 inside.
    ///
    /// # Errors
    /// The point or the distance is out of range: see [`QueryError`].
    pub fn nearest(&self, point: impl Into<[f32; 3]>, within: f32) -> Result<Option<Hit>, QueryError> {
        self.nearest_where(point, within, |_| true)
    }

    /// [`World::nearest`] of what `accept` accepts: it is called with instances, in no particular order, with some perhaps often.
    ///
    /// # Errors
    /// As for [`World::nearest`].
    pub fn nearest_where(
        &self,
        point: impl Into<[f32; 3]>,
        within: f32,
        mut accept: impl FnMut(InstanceIndex) -> bool,
    ) -> Result<Option<Hit>, QueryError> {
        let point = point.into();
        check_point(point)?;
        check_distance(within)?;
        let p = DVec3::from(point.map(f64::from));
        let slack = self.slack(point);
        let mut best = Best { squared: f64::from(within) * f64::from(within), found: None };
        let reach = |best: &Best| libm::sqrt(best.squared) + slack;
        let apart = |bounds: &Bounds, pad: f64| {
            let (low, high) = corners(bounds);
            let away = (low - pad - p).max(p - high - pad).max(DVec3::ZERO);
            libm::sqrt(away.length_squared())
        };
        let padded = |bounds: &Bounds, slack: f32| apart(bounds, self.pad(point, slack));
        let top = &self.tree.instances;
        let space = Placed::new(&top.merged.space.to_world, &top.merged.space.to_object);
        let distance = |bounds: &Bounds, _| space.apart(bounds, p);
        walk(&top.merged.tree, None, reach(&best), distance, |leaf, _| {
            let MergedLeaf { instance: number, block, triangles } = top.merged.leaves[leaf as usize];
            if self.meets_merged(number) && accept(self.source.numbered(number)) {
                best.take_blocks(p, number, &space, self.mesh(number).blocks(block, triangles));
            }
            reach(&best)
        });
        walk(&top.tree, Some(&top.slacks), reach(&best), padded, |number, count| {
            // What is hidden or merged is not in its leaf.
            if count == 0 || !self.sees(number) || !accept(self.source.numbered(number)) {
                return reach(&best);
            }
            let instance = &self.source.instances()[number as usize];
            let placed = Placed::of(instance);
            if instance.is_sphere() {
                let n = nearest_on_ellipsoid(p - placed.moved, &placed.to_world);
                let squared = (placed.to_world * n + placed.moved - p).length_squared();
                let is_inside = (placed.to_ball * p + placed.ball_moved).length_squared() < 1.0;
                let [u, v] = octahedral(V3::<f32>::splat((), n.to_array().map(|c| c as f32)));
                best.take(squared, number, u32::from(is_inside), [u, v]);
                return reach(&best);
            }
            let mesh = self.mesh(number);
            let distance = |bounds: &Bounds, _| placed.apart(bounds, p);
            walk(&mesh.tree, None, reach(&best), distance, |first, count| {
                best.take_blocks(p, number, &placed, mesh.blocks(first, count));
                reach(&best)
            });
            reach(&best)
        });
        Ok(best.found.map(|(number, triangle, [u, v])| Hit {
            t: libm::sqrt(best.squared) as f32,
            instance: self.source.numbered(number),
            triangle,
            u,
            v,
        }))
    }

    /// Fills `overlaps` with the triangles and spheres that a volume has a point of, and returns how many they are: those with
    /// the least numbers, in order. If it fills all of them, there may be more. Surfaces count, not what they enclose.
    ///
    /// # Errors
    /// The volume is out of range: see [`QueryError`].
    pub fn overlaps(&self, volume: &Volume, overlaps: &mut [Overlap]) -> Result<usize, QueryError> {
        let mut count = 0;
        self.overlapped(volume, |new| {
            let place = overlaps[..count].partition_point(|old| key(old) < key(&new));
            if place < overlaps.len() {
                count = overlaps.len().min(count + 1);
                overlaps[place..count].rotate_right(1);
                overlaps[place] = new;
            }
            true
        })?;
        Ok(count)
    }

    /// Fills `instances` with those that a volume has a point of, as [`World::overlaps`].
    ///
    /// # Errors
    /// As for [`World::overlaps`].
    pub fn overlapped_instances(
        &self,
        volume: &Volume,
        instances: &mut [InstanceIndex],
    ) -> Result<usize, QueryError> {
        let mut count = 0;
        self.overlapped(volume, |Overlap { instance, .. }| {
            let place = instances[..count].partition_point(|old| old.number < instance.number);
            // It may have been found in another leaf of it.
            let is_new = instances[..count].get(place) != Some(&instance);
            if is_new && place < instances.len() {
                count = instances.len().min(count + 1);
                instances[place..count].rotate_right(1);
                instances[place] = instance;
            }
            // One triangle of it is enough.
            false
        })?;
        Ok(count)
    }

    /// Calls `found` for each triangle or sphere that a volume has a point of, in no particular order; if it returns
    /// false, no longer for this instance.
    fn overlapped(&self, volume: &Volume, mut found: impl FnMut(Overlap) -> bool) -> Result<(), QueryError> {
        volume.check()?;
        let (low, high) = corners(&Bounds { low: volume.low, high: volume.high });
        let radius = volume.radius.map(f64::from);
        let reach = radius.unwrap_or(0.0) + self.slack(volume.low).max(self.slack(volume.high));
        let meets = |low_at: DVec3, high_at: DVec3, pad: f64| {
            let away = (low_at - pad - high).max(low - high_at - pad);
            away.max_element().max(0.0)
        };
        let padded = |bounds: &Bounds, slack: f32| {
            let (from, to) = corners(bounds);
            meets(from, to, self.pad(volume.low, slack).max(self.pad(volume.high, slack)))
        };
        let meets_triangle = |corners: [DVec3; 3]| match radius {
            Some(radius) => nearest_on_triangle(low, corners).squared <= radius * radius,
            None => box_meets_triangle(low, high, corners),
        };
        // Returns whether more of the instance is wanted.
        let find = |found: &mut dyn FnMut(Overlap) -> bool, number, placed: &Placed, blocks: &[Block]| {
            let instance = self.source.numbered(number);
            let triangles = blocks.iter().flat_map(|block| (0..block.count).map(move |lane| (block, lane)));
            for (block, lane) in triangles {
                let overlap = Overlap { instance, triangle: block.first + lane };
                if meets_triangle(placed.triangle(block.triangle(lane as usize))) && !found(overlap) {
                    return false;
                }
            }
            true
        };
        let apart = |placed: &Placed, bounds: &Bounds| {
            let (from, to) = placed.bounds(bounds);
            meets(from, to, 0.0)
        };
        let top = &self.tree.instances;
        let space = Placed::new(&top.merged.space.to_world, &top.merged.space.to_object);
        walk(
            &top.merged.tree,
            None,
            reach,
            |bounds, _| apart(&space, bounds),
            |leaf, _| {
                let MergedLeaf { instance: number, block, triangles } = top.merged.leaves[leaf as usize];
                if self.meets_merged(number) {
                    find(&mut found, number, &space, self.mesh(number).blocks(block, triangles));
                }
                reach
            },
        );
        walk(&top.tree, Some(&top.slacks), reach, padded, |number, count| {
            // What is hidden or merged is not in its leaf.
            if count == 0 || !self.sees(number) {
                return reach;
            }
            let instance = &self.source.instances()[number as usize];
            let placed = Placed::of(instance);
            if instance.is_sphere() {
                let is_met = match radius {
                    Some(radius) => {
                        let n = nearest_on_ellipsoid(low - placed.moved, &placed.to_world);
                        (placed.to_world * n + placed.moved - low).length_squared() <= radius * radius
                    }
                    None => box_meets_ellipsoid(low, high, &placed.to_ball, placed.ball_moved),
                };
                if is_met {
                    found(Overlap { instance: self.source.numbered(number), triangle: 0 });
                }
                return reach;
            }
            let mesh = self.mesh(number);
            walk(
                &mesh.tree,
                None,
                reach,
                |bounds, _| apart(&placed, bounds),
                |first, count| {
                    if find(&mut found, number, &placed, mesh.blocks(first, count)) { reach } else { -1.0 }
                },
            );
            reach
        });
        Ok(())
    }

    /// Whether an instance is of a group of this world.
    fn sees(&self, number: u32) -> bool {
        self.source.tags()[number as usize].mask & self.mask != 0
    }

    /// Whether an instance counts that is a member of the merged tree.
    fn meets_merged(&self, number: u32) -> bool {
        self.tree.instances.entries[number as usize].is_merged && self.sees(number)
    }

    /// The tree of an instance's mesh.
    fn mesh(&self, number: u32) -> &MeshTree {
        &self.tree.meshes[self.source.mesh_of(number as usize)]
    }

    /// The rounding errors of distances: `f64` has 52 bits, of which many are spare.
    fn slack(&self, point: [f32; 3]) -> f64 {
        f64::from(self.magnitude_from(point)) * 1e-12
    }

    /// How far an instance may reach out of its box in the tree.
    fn pad(&self, point: [f32; 3], slack: f32) -> f64 {
        f64::from(self.magnitude_from(point)) * f64::from(slack)
    }
}

/// The order of overlaps.
fn key(overlap: &Overlap) -> (u32, u32) {
    (overlap.instance.number, overlap.triangle)
}

/// The nearest so far, or the farthest that counts.
struct Best {
    squared: f64,
    /// The instance, the triangle, and where on it.
    found: Option<(u32, u32, [f32; 2])>,
}

impl Best {
    /// Takes the triangles of an instance.
    fn take_blocks(&mut self, p: DVec3, number: u32, placed: &Placed, blocks: &[Block]) {
        for block in blocks {
            for lane in 0..block.count {
                let found = nearest_on_triangle(p, placed.triangle(block.triangle(lane as usize)));
                let weights = found.weights.map(|weight| weight as f32);
                self.take(found.squared, number, block.first + lane, weights);
            }
        }
    }

    fn take(&mut self, squared: f64, instance: u32, triangle: u32, weights: [f32; 2]) {
        let is_earlier = self.found.is_none_or(|(i, t, _)| (instance, triangle) < (i, t));
        if squared < self.squared || (squared == self.squared && is_earlier) {
            *self = Self { squared, found: Some((instance, triangle, weights)) };
        }
    }
}

/// An instance's matrices.
struct Placed {
    to_world: DMat3,
    moved: DVec3,
    to_ball: DMat3,
    ball_moved: DVec3,
}

impl Placed {
    fn of(instance: &Instance) -> Self {
        Self::new(&instance.to_world, &instance.to_object)
    }

    fn new(to_world: &[[f32; 4]; 3], to_object: &[[f32; 4]; 3]) -> Self {
        let [to_world, to_object] = [to_world, to_object].map(from_rows);
        let moved = to_world.w_axis.truncate();
        let [to_world, to_ball] = [to_world, to_object].map(DMat3::from_mat4);
        Self { to_world, moved, to_ball, ball_moved: -(to_ball * moved) }
    }

    /// A triangle in world space.
    fn triangle(&self, corners: [[f32; 3]; 3]) -> [DVec3; 3] {
        corners.map(|corner| self.to_world * DVec3::from(corner.map(f64::from)) + self.moved)
    }

    /// The bounds of a box in world space.
    fn bounds(&self, bounds: &Bounds) -> (DVec3, DVec3) {
        let (low, high) = corners(bounds);
        let middle = self.to_world * ((low + high) * 0.5) + self.moved;
        let half = self.to_world.abs() * ((high - low) * 0.5);
        (middle - half, middle + half)
    }

    /// How far a point is from those.
    fn apart(&self, bounds: &Bounds, p: DVec3) -> f64 {
        let (low, high) = self.bounds(bounds);
        libm::sqrt((low - p).max(p - high).max(DVec3::ZERO).length_squared())
    }
}

fn corners(bounds: &Bounds) -> (DVec3, DVec3) {
    (DVec3::from(bounds.low.map(f64::from)), DVec3::from(bounds.high.map(f64::from)))
}

/// The children of a node that wait, farthest first.
#[derive(Clone, Copy)]
struct Waiting {
    node: u32,
    count: usize,
    children: [(f64, usize); WIDTH],
}

/// Shows `leaf` the leaves below a node whose boxes are no farther away than `reach`, near ones first; it returns the new
/// reach, and a negative one ends the walk.
fn walk(
    tree: &WideTree,
    slacks: Option<&[[f32; WIDTH]]>,
    mut reach: f64,
    distance: impl Fn(&Bounds, f32) -> f64,
    mut leaf: impl FnMut(u32, u32) -> f64,
) {
    let mut stack = [Waiting { node: 0, count: 0, children: [(0.0, 0); WIDTH] }; STACK];
    let mut depth = 0;
    let mut index = 0;
    loop {
        let node: &WideNode = &tree.nodes[index as usize];
        let waiting = &mut stack[depth];
        (waiting.node, waiting.count) = (index, 0);
        for slot in 0..WIDTH {
            let bounds = node.bounds(slot);
            if bounds.is_empty() {
                continue;
            }
            let away = distance(&bounds, slacks.map_or(0.0, |slacks| slacks[index as usize][slot]));
            let place = waiting.children[..waiting.count].partition_point(|(other, _)| *other > away);
            waiting.count += 1;
            waiting.children[place..waiting.count].rotate_right(1);
            waiting.children[place] = (away, slot);
        }
        depth += 1;
        index = loop {
            if depth == 0 || reach < 0.0 {
                return;
            }
            let top = &mut stack[depth - 1];
            if top.count == 0 {
                depth -= 1;
                continue;
            }
            top.count -= 1;
            let (away, slot) = top.children[top.count];
            if away > reach {
                // So are the others.
                depth -= 1;
                continue;
            }
            match tree.nodes[top.node as usize].child(slot) {
                Child::Node(child) => break child,
                Child::Leaf(first, count) => reach = leaf(first, count),
            }
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::Attribute;
    use crate::query::Tree;
    use crate::scene::{Bvh, Material, Mesh, MeshIndex, Scene, Sequential};
    use glam::{Mat4, Quat, Vec3};
    use std::vec;
    use std::vec::Vec;

    /// Numbers within −1 .. 1 that look random.
    struct Random(u32);

    impl Random {
        fn signed(&mut self) -> f32 {
            self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (self.0 >> 8) as f32 / (1 << 23) as f32 - 1.0
        }
        fn vector(&mut self, size: f32) -> Vec3 {
            Vec3::new(self.signed(), self.signed(), self.signed()) * size
        }
    }

    /// Adds a mesh of triangles that are anywhere.
    fn add_triangles(scene: &mut Scene, random: &mut Random) -> MeshIndex {
        let positions: Vec<_> = (0..300).map(|_| random.vector(1.0).to_array()).collect();
        let attributes = vec![Attribute { normal: [0.0; 3], uv: [0.0; 2], color: [0; 2] }; 300];
        let mesh = Mesh::new(positions, attributes, (0..300).collect()).unwrap();
        scene.add_mesh(&mesh, &Bvh::build(&mesh, &Sequential)).unwrap()
    }

    /// Meshes and spheres strewn over a world, one of them hidden, and three meshes in one space.
    fn strewn(random: &mut Random) -> Scene {
        let mut scene = Scene::new();
        let material = scene.add_material(Material::default()).unwrap();
        let together = Mat4::from_scale_rotation_translation(
            Vec3::new(3.0, -1.0, 2.0),
            Quat::from_scaled_axis(Vec3::Z),
            Vec3::Y,
        );
        for _ in 0..3 {
            let mesh = add_triangles(&mut scene, random);
            scene.add_instance(mesh, material, together).unwrap();
        }
        let mesh = add_triangles(&mut scene, random);
        let mut last = None;
        for number in 0..57 {
            let scale = if number % 3 == 0 { Vec3::new(0.5, 2.0, -0.1) } else { Vec3::splat(0.7) };
            let turn = Quat::from_scaled_axis(random.vector(3.0));
            let place = Mat4::from_scale_rotation_translation(scale, turn, random.vector(6.0));
            last = Some(if number % 4 == 0 {
                scene.add_sphere(material, place).unwrap()
            } else {
                scene.add_instance(mesh, material, place).unwrap()
            });
        }
        scene.hide(last.unwrap()).unwrap();
        scene
    }

    /// Everything that can be near or overlap, one after the other: a sphere, or a triangle.
    fn each(scene: &Scene, mut see: impl FnMut(u32, u32, &Placed, Option<[DVec3; 3]>)) {
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

    #[test]
    fn nothing_is_nearer_than_the_nearest() {
        let mut random = Random(1);
        let scene = strewn(&mut random);
        let mut tree = Tree::default();
        let world = tree.world(&scene);
        assert!((0..5).map(|number| world.meets_merged(number)).eq([true, true, true, false, false]));
        let mut hits = 0;
        for round in 0..300 {
            let point = random.vector(if round % 5 == 0 { 40.0 } else { 6.0 });
            let within = if round % 2 == 0 { 100.0 } else { 0.3 };
            let p = point.as_dvec3();
            let even = |instance: u32| round % 3 > 0 || instance.is_multiple_of(2);
            let mut least = (f64::from(within) * f64::from(within), u32::MAX, u32::MAX);
            each(&scene, |instance, triangle, placed, corners| {
                let squared = match corners {
                    Some(corners) => nearest_on_triangle(p, corners).squared,
                    None => {
                        let n = nearest_on_ellipsoid(p - placed.moved, &placed.to_world);
                        (placed.to_world * n + placed.moved - p).length_squared()
                    }
                };
                if even(instance) && (squared, instance, triangle) < least {
                    least = (squared, instance, triangle);
                }
            });
            let found = world.nearest_where(point, within, |instance| even(instance.number())).unwrap();
            let Some(hit) = found else {
                assert_eq!(least.1, u32::MAX);
                continue;
            };
            hits += 1;
            assert_eq!(
                (f64::from(hit.t), hit.instance.number),
                (f64::from(libm::sqrt(least.0) as f32), least.1)
            );
            let surface = world.surface(&hit).unwrap();
            let off = Vec3::from(surface.position).distance(point) - hit.t;
            assert!(off.abs() < 1e-4, "{off} {hit:?}");
            if !scene.instances()[least.1 as usize].is_sphere() {
                assert_eq!(hit.triangle, least.2);
            }
        }
        assert!(hits > 150, "{hits}");
    }

    #[test]
    fn overlaps_are_those_of_each_triangle() {
        let mut random = Random(2);
        let scene = strewn(&mut random);
        let mut tree = Tree::default();
        let world = tree.world(&scene);
        assert!((0..5).map(|number| world.meets_merged(number)).eq([true, true, true, false, false]));
        let mut met = 0;
        for round in 0..300 {
            let center = random.vector(6.0);
            let radius = random.signed().abs() * if round % 4 == 0 { 3.0 } else { 0.4 };
            let volume = if round % 2 == 0 {
                Volume::ball(center, radius)
            } else {
                Volume::between(center, center + random.vector(radius))
            };
            let (low, high) = corners(&Bounds { low: volume.low, high: volume.high });
            let mut expected = vec![];
            each(&scene, |number, triangle, placed, corners| {
                let r = f64::from(radius);
                let is_met = match (corners, volume.radius) {
                    (Some(corners), Some(_)) => nearest_on_triangle(low, corners).squared <= r * r,
                    (Some(corners), None) => box_meets_triangle(low, high, corners),
                    (None, Some(_)) => {
                        let n = nearest_on_ellipsoid(low - placed.moved, &placed.to_world);
                        (placed.to_world * n + placed.moved - low).length_squared() <= r * r
                    }
                    (None, None) => box_meets_ellipsoid(low, high, &placed.to_ball, placed.ball_moved),
                };
                if is_met {
                    let instance = scene.instance_index(number).unwrap();
                    expected.push(Overlap { instance, triangle });
                }
            });
            for size in [0, 1, 5, 4000] {
                let mut found = vec![Overlap::NONE; size];
                let count = world.overlaps(&volume, &mut found).unwrap();
                assert_eq!(found[..count], expected[..expected.len().min(size)]);
                let mut instances = vec![Overlap::NONE.instance; size];
                let count = world.overlapped_instances(&volume, &mut instances).unwrap();
                let mut numbers: Vec<_> = expected.iter().map(|overlap| overlap.instance).collect();
                numbers.dedup();
                assert_eq!(instances[..count], numbers[..numbers.len().min(size)]);
            }
            met += expected.len();
        }
        assert!(met > 1000, "{met}");
    }

    #[test]
    fn what_is_no_place_is_an_error() {
        let scene = strewn(&mut Random(3));
        let mut tree = Tree::default();
        let world = tree.world(&scene);
        for bad in [f32::NAN, f32::INFINITY, -2e9] {
            let point = [0.0, bad, 0.0];
            assert!(matches!(world.nearest(point, 1.0), Err(QueryError::Point { .. })));
            for volume in
                [Volume::ball(point, 1.0), Volume::between(point, [0.0; 3]), Volume::between([0.0; 3], point)]
            {
                assert!(
                    matches!(world.overlaps(&volume, &mut []), Err(QueryError::Point { .. })),
                    "{volume:?}"
                );
            }
        }
        for bad in [f32::NAN, -1.0, f32::NEG_INFINITY] {
            assert!(matches!(world.nearest([0.0; 3], bad), Err(QueryError::Distance { .. })));
            let ball = Volume::ball([0.0; 3], bad);
            assert!(matches!(world.overlapped_instances(&ball, &mut []), Err(QueryError::Distance { .. })));
        }
        assert!(world.nearest([0.0; 3], f32::INFINITY).unwrap().is_some());
        let ball = Volume::ball([0.0; 3], f32::INFINITY);
        assert_eq!(world.overlapped_instances(&ball, &mut [Overlap::NONE.instance; 99]), Ok(59));
    }
}

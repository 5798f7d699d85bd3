//! What a device needs to answer rays, and what of it changes with the scene.

use super::narrow::NarrowTree;
use super::ray::{QueryError, Ray, Sides};
use super::source::Parts;
use super::world::{Hit, magnitude};
use crate::layout::{Hit as HitRecord, NONE, Node, QueryFrame, RayRecord};
use crate::scene::{InstanceIndex, Join, Scene, Versions};
use alloc::vec;
use alloc::vec::Vec;
use bytemuck::Zeroable;
use core::ops::Range;

/// What a backend on a device takes of a [`Scene`] beyond its own arrays, for
/// [`stage::query`](crate::stage::query). The default is that of no scene: it has no nodes.
#[derive(Debug, Clone)]
pub struct DeviceWorld {
    /// The numbers, for no rays yet.
    pub frame: QueryFrame,
    /// The groups of each instance; 0 if it is hidden.
    pub masks: Vec<u32>,
    tree: NarrowTree,
    indices: Vec<InstanceIndex>,
    known: Option<Known>,
}

/// The scene that is known, as it was.
#[derive(Debug, Clone, Copy)]
struct Known {
    id: u32,
    versions: Versions,
    moves: u64,
}

/// What [`DeviceWorld::update`] found changed: what copies on a device lack.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DeviceChanges {
    /// Nodes, mesh data and positions of the scene.
    pub geometry: Changed,
    /// Texels of the scene.
    pub texels: Changed,
    /// Instances of the scene, and the masks of the same numbers.
    pub instances: Changed,
    /// Nodes of the tree; all of them if they lie elsewhere now, because the scene's nodes before them are more or fewer.
    pub tree: Changed,
}

/// What has changed of an array.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Changed {
    /// All, perhaps even how many elements there are.
    All,
    /// The elements with these numbers, ascending.
    These(Vec<u32>),
}

impl Changed {
    /// The elements with these numbers, in any order.
    fn these(mut numbers: Vec<u32>) -> Self {
        numbers.sort_unstable();
        numbers.dedup();
        Self::These(numbers)
    }

    /// All or nothing.
    fn all_if(is_changed: bool) -> Self {
        if is_changed { Self::All } else { Self::These(vec![]) }
    }

    /// Ranges with all that has changed of an array of `count` elements, ascending. Where no more than `gap` elements
    /// are between two of them, they are one.
    pub fn ranges(&self, count: usize, gap: usize) -> Vec<Range<usize>> {
        let numbers = match self {
            Self::All => return Vec::from_iter((count > 0).then_some(0..count)),
            Self::These(numbers) => numbers,
        };
        let mut ranges: Vec<Range<usize>> = vec![];
        for number in numbers.iter().map(|&number| number as usize) {
            match ranges.last_mut() {
                Some(range) if number - range.end <= gap => range.end = number + 1,
                _ => ranges.push(number..number + 1),
            }
        }
        ranges
    }
}

impl Default for DeviceWorld {
    fn default() -> Self {
        let (tree, masks) = (NarrowTree::default(), vec![]);
        Self { frame: QueryFrame::zeroed(), masks, tree, indices: vec![], known: None }
    }
}

impl DeviceWorld {
    /// The scene as it is now; workers of `join` build the tree over its instances.
    pub fn new(scene: &Scene, join: &impl Join) -> Self {
        let mut world = Self::default();
        world.update(scene, join);
        world
    }

    /// Follows to the scene as it is now, which may be another one. Returns what changed since the last call.
    ///
    /// After a move, the boxes above what moved are computed again, and nothing else. After many moves that is done
    /// for all, and the tree is built again, by workers of `join`, if it has become twice as bad.
    pub fn update(&mut self, scene: &Scene, join: &impl Join) -> DeviceChanges {
        let (id, versions, moves) = (scene.id(), scene.versions(), Parts::places(scene).moves());
        let known = self.known.replace(Known { id, versions, moves }).filter(|known| known.id == id);
        let is_other =
            |part: fn(&Versions) -> u32| known.is_none_or(|known| part(&known.versions) != part(&versions));
        let [mut instances, mut tree] = self.follow(scene, known.map(|known| known.moves), join);
        if is_other(|v| v.materials) || is_other(|v| v.geometry) {
            // Instances have some of their materials, and name places in the arrays of meshes.
            instances = Changed::All;
        }
        let root = scene.nodes().len() as u32;
        if root != self.frame.root {
            tree = Changed::All;
        }
        let (magnitude, slack) = (magnitude(Parts::places(scene)), self.tree.slack());
        self.frame = QueryFrame { rays: 0, root, magnitude, slack };
        DeviceChanges {
            geometry: Changed::all_if(is_other(|v| v.geometry)),
            texels: Changed::all_if(is_other(|v| v.texels)),
            instances,
            tree,
        }
    }

    /// Takes over what moved after the first `moves` moves of the scene; all, if they are `None`. Gives the instances
    /// and the nodes of the tree that changed.
    fn follow(&mut self, scene: &Scene, moves: Option<u64>, join: &impl Join) -> [Changed; 2] {
        let count = scene.instances().len();
        let moves = moves.filter(|_| self.masks.len() == count);
        let mut changes = [Changed::All, Changed::All];
        if let Some(moved) = moves.and_then(|moves| Parts::places(scene).moved_since(moves)) {
            let mut nodes = vec![];
            for instance in moved.iter().map(|&instance| instance as usize) {
                self.masks[instance] = mask(scene, instance);
                self.indices[instance] = scene.numbered(instance as u32);
                self.tree.refit(scene, instance, &mut nodes);
            }
            changes = [Changed::these(moved.to_vec()), Changed::these(nodes)];
        } else {
            self.masks.clear();
            self.masks.extend((0..count).map(|instance| mask(scene, instance)));
            self.indices.clear();
            self.indices.extend((0..count as u32).map(|number| scene.numbered(number)));
            if moves.is_some() {
                self.tree.refit_all(scene);
            }
        }
        if moves.is_none() || self.tree.is_worn() {
            self.tree = NarrowTree::new(scene, join);
            changes[1] = Changed::All;
        }
        changes
    }

    /// The tree over the instances: on a device, its nodes follow those of the scene.
    pub fn tree(&self) -> &[Node] {
        &self.tree.nodes
    }

    /// A ray as a device takes it.
    ///
    /// # Errors
    /// The ray has no start, direction or range: see [`QueryError`].
    pub fn record(&self, ray: &Ray) -> Result<RayRecord, QueryError> {
        let scaled = ray.scaled()?;
        let sides = match ray.sides {
            Sides::Both => RayRecord::BOTH,
            Sides::Fronts => RayRecord::FRONTS,
            Sides::Backs => RayRecord::BACKS,
            Sides::Drawn => RayRecord::DRAWN,
        };
        let is_here = |skip: &InstanceIndex| self.indices.get(skip.number as usize) == Some(skip);
        let holes = if ray.through_holes { RayRecord::THROUGH_HOLES } else { 0 };
        Ok(RayRecord {
            origin: ray.origin,
            from: scaled.span.from,
            direction: scaled.ray.direction.lane(0),
            to: scaled.span.to,
            mask: ray.mask,
            skip: ray.skip.filter(is_here).map_or(NONE, |skip| skip.number),
            options: sides | holes,
            unused: 0,
        })
    }

    /// The hit that a device found on a ray; `None` for a miss.
    pub fn hit(&self, ray: &Ray, found: &HitRecord) -> Option<Hit> {
        let scaled = ray.scaled().ok()?;
        let &HitRecord { t, instance, triangle, u, v } = found;
        let instance = *self.indices.get(instance as usize)?;
        Some(Hit { t: scaled.span.t(t), instance, triangle, u, v })
    }
}

/// The groups of an instance; 0 if it is hidden.
fn mask(scene: &Scene, instance: usize) -> u32 {
    if Parts::places(scene).bounds(instance).is_empty() { 0 } else { Parts::tags(scene)[instance].mask }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Material, Sequential};
    use glam::{Mat4, Vec3};

    fn place(number: usize) -> Mat4 {
        let turn = number as f32;
        Mat4::from_translation(Vec3::new(turn.sin(), turn.cos(), turn / 450.0) * 50.0)
    }

    /// Balls, from a number on.
    fn balls(first: usize) -> (Scene, Vec<InstanceIndex>) {
        let mut scene = Scene::new();
        let white = scene.add_material(Material::default()).unwrap();
        let balls = (first..first + 300).map(|i| scene.add_sphere(white, place(3 * i)).unwrap()).collect();
        (scene, balls)
    }

    #[test]
    fn a_move_changes_a_path_and_many_build_the_tree_again() {
        let (mut scene, balls) = balls(0);
        let mut world = DeviceWorld::new(&scene, &Sequential);
        scene.set_transform(balls[7], place(22)).unwrap();
        let DeviceChanges { geometry, texels, instances, tree } = world.update(&scene, &Sequential);
        let nothing = Changed::These(vec![]);
        assert_eq!((geometry, texels, instances), (nothing.clone(), nothing, Changed::These(vec![7])));
        assert!(matches!(&tree, Changed::These(nodes) if (2..20).contains(&nodes.len())), "{tree:?}");
        // A fifth of them goes to the other end.
        scene.set_transforms((0..60).map(|i| (balls[i], place(3 * (299 - i))))).unwrap();
        let DeviceChanges { instances, tree, .. } = world.update(&scene, &Sequential);
        assert_eq!((instances, tree), (Changed::These((0..60).collect()), Changed::All));
        assert!(!world.tree.is_worn());
    }

    #[test]
    fn another_scene_has_nothing_in_common_however_alike_it_is() {
        let [(scene, _), (other, _)] = [balls(0), balls(1)];
        assert_eq!(scene.versions(), other.versions());
        let mut world = DeviceWorld::new(&scene, &Sequential);
        let all = || Changed::All;
        let everything = DeviceChanges { geometry: all(), texels: all(), instances: all(), tree: all() };
        assert_eq!(world.update(&other, &Sequential), everything);
        assert_eq!(world.frame, DeviceWorld::new(&other, &Sequential).frame);
    }

    #[test]
    fn ranges_hold_all_that_changed_and_small_gaps() {
        let these = Changed::these(vec![9, 3, 4, 20, 3, 6]);
        assert_eq!(these, Changed::These(vec![3, 4, 6, 9, 20]));
        let ranges = |changed: &Changed, count: usize, gap: usize| {
            let pair = |range: Range<usize>| (range.start, range.end);
            changed.ranges(count, gap).into_iter().map(pair).collect::<Vec<_>>()
        };
        assert_eq!(ranges(&these, 30, 0), [(3, 5), (6, 7), (9, 10), (20, 21)]);
        assert_eq!(ranges(&these, 30, 1), [(3, 7), (9, 10), (20, 21)]);
        assert_eq!(ranges(&these, 30, 2), [(3, 10), (20, 21)]);
        assert_eq!(ranges(&these, 30, 10), [(3, 21)]);
        assert_eq!((ranges(&Changed::All, 5, 0), ranges(&Changed::All, 0, 9)), (vec![(0, 5)], vec![]));
        assert_eq!(ranges(&Changed::all_if(false), 5, 9), []);
    }
}

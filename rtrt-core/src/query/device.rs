//! What a device needs to answer rays.

use super::ray::{QueryError, Ray, Sides};
use super::source::Parts;
use super::world::Hit;
use crate::layout::{Hit as HitRecord, NONE, Node, QueryFrame, RayRecord};
use crate::scene::{Bounds, Bvh, Join, Scene};
use alloc::vec::Vec;

/// What a backend on a device takes of a [`Scene`] beyond its own arrays, for
/// [`stage::query`](crate::stage::query).
#[derive(Debug, Clone)]
pub struct DeviceWorld {
    /// The numbers, for no rays yet.
    pub frame: QueryFrame,
    /// The scene's nodes, followed by the tree over its instances.
    pub nodes: Vec<Node>,
    /// The groups of each instance; 0 if it is hidden.
    pub masks: Vec<u32>,
    scene: u32,
}

impl DeviceWorld {
    /// The scene as it is now.
    pub fn new(scene: &Scene, join: &impl Join) -> Self {
        let instances = Parts::instances(scene);
        let boxes: Vec<_> = instances.iter().map(|i| Bounds { low: i.low, high: i.high }).collect();
        let tree = Bvh::over(&boxes, 1, join);
        let mut nodes = scene.nodes().to_vec();
        let root = nodes.len() as u32;
        nodes.extend(tree.nodes.iter().map(|node| match node.triangles() {
            1 if node.is_leaf() => Node { first: tree.triangles[node.first as usize], ..*node },
            _ => *node,
        }));
        let mask = |index: usize| {
            if Parts::places(scene).bounds(index).is_empty() { 0 } else { Parts::tags(scene)[index].mask }
        };
        let slack = instances.iter().fold(0.0_f32, |most, instance| most.max(instance.slack));
        let corners = boxes.iter().flat_map(|b| b.low.into_iter().chain(b.high));
        let magnitude = corners.fold(crate::num::FLOOR, |most, c| most.max(c.abs()));
        Self {
            frame: QueryFrame { rays: 0, root, magnitude, slack },
            nodes,
            masks: (0..instances.len()).map(mask).collect(),
            scene: scene.family(),
        }
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
        let holes = if ray.through_holes { RayRecord::THROUGH_HOLES } else { 0 };
        Ok(RayRecord {
            origin: ray.origin,
            from: scaled.from,
            direction: scaled.ray.direction.lane(0),
            to: scaled.to,
            mask: ray.mask,
            skip: ray.skip.filter(|skip| skip.scene == self.scene).map_or(NONE, |skip| skip.number),
            options: sides | holes,
            unused: 0,
        })
    }

    /// The hit that a device found on a ray; `None` for a miss.
    pub fn hit(&self, ray: &Ray, found: &HitRecord) -> Option<Hit> {
        let scaled = ray.scaled().ok()?;
        let &HitRecord { t, instance, triangle, u, v } = found;
        let is_there = (instance as usize) < self.masks.len();
        let number = crate::scene::InstanceIndex { number: instance, scene: self.scene };
        is_there.then(|| Hit { t: scaled.t(t), instance: number, triangle, u, v })
    }
}

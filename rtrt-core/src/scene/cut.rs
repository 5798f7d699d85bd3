//! A cut of the BVHs: nodes that the lists of the camera hold instead of whole instances.

use crate::layout::{Instance, Node};
use crate::scene::bvh::Bounds;
use crate::scene::place;
use crate::scene::{Scene, SetupError, Structure, Versions};
use alloc::vec::Vec;

/// Instances, then their parts. They are reused until something that they depend on changes.
#[derive(Debug, Clone, Default)]
pub(super) struct BvhCut {
    /// The key of the parts: the scene, its versions, the chosen levels of detail, and the largest number of
    /// triangles of a part. `None` without parts.
    source: Option<(u32, Versions, u32, u32)>,
    /// The largest number of triangles of a part, if there are parts.
    pub triangles: Option<u32>,
    /// Whether instances stay whole, whatever the scene asks for.
    pub are_refused: bool,
    instances: Vec<Instance>,
    /// Nodes that may have to be divided.
    waiting: Vec<u32>,
}

/// The most parts that a frame may have.
const MOST: usize = 1 << 20;

/// The approximate number of parts of scenes with fewer instances. Measured: more parts slow down scenes
/// whose instances stand side by side, and speed up scenes whose instances lie behind one another.
const USUAL: u64 = 256;
/// The smallest number of triangles that pays for a part.
const LEAST: u64 = 64;

/// The largest number of triangles of a part of these instances; `None` where parts gain nothing.
fn triangles(instances: &[Instance]) -> Option<u32> {
    if instances.len() as u64 >= USUAL {
        return None;
    }
    let all: u64 = instances.iter().map(|instance| u64::from(instance.triangles)).sum();
    let triangles = (all / USUAL).max(LEAST) as u32;
    instances.iter().any(|instance| instance.triangles > triangles).then_some(triangles)
}

impl BvhCut {
    /// The instances, then the parts of at most `triangles` triangles.
    pub fn instances(&self) -> &[Instance] {
        &self.instances
    }

    /// Builds the parts that the scene asks for, or reuses those of the last frame if they are equal.
    /// `chosen` changes whenever the levels of detail do. Returns the first of the instances or parts that
    /// the camera's lists choose from, and their number.
    pub fn prepare(
        &mut self,
        scene: &Scene,
        instances: &[Instance],
        chosen: u32,
    ) -> Result<[u32; 2], SetupError> {
        self.triangles = match scene.structure {
            _ if self.are_refused => None,
            Structure::Blocks => triangles(instances),
            Structure::Parts(triangles) => Some(triangles.max(1)),
            Structure::Objects | Structure::None => None,
        };
        let whole = instances.len() as u32;
        let Some(triangles) = self.triangles else { return Ok([0, whole]) };
        self.make(scene, instances, chosen, triangles)?;
        Ok([whole, self.instances.len() as u32 - whole])
    }

    fn make(
        &mut self,
        scene: &Scene,
        instances: &[Instance],
        chosen: u32,
        triangles: u32,
    ) -> Result<(), SetupError> {
        let source = Some((scene.id(), scene.versions(), chosen, triangles));
        if self.source == source {
            return Ok(());
        }
        self.source = None;
        self.instances.clear();
        self.instances.extend_from_slice(instances);
        for (number, instance) in (0..).zip(instances) {
            if instance.is_sphere() {
                self.instances.push(Instance { opened_from: number, ..*instance });
            } else if instance.triangles > 0 {
                self.cut(scene.nodes(), number, instance, triangles)?;
            }
        }
        self.source = source;
        Ok(())
    }

    /// Adds the parts of an instance: nodes from the root down, until they are small enough.
    fn cut(
        &mut self,
        nodes: &[Node],
        number: u32,
        instance: &Instance,
        triangles: u32,
    ) -> Result<(), SetupError> {
        let matrix = place::matrix(instance).as_dmat4();
        self.waiting.clear();
        self.waiting.push(instance.root);
        while let Some(index) = self.waiting.pop() {
            let node = &nodes[index as usize];
            if !node.is_leaf() && held(nodes, instance.root, node) > triangles {
                self.waiting.extend([1, 0].map(|child| instance.root + node.first + child));
                continue;
            }
            if self.instances.len() >= MOST {
                return Err(SetupError::BvhCut { triangles, limit: MOST });
            }
            let bounds = Bounds::around(node);
            let part = place::part(instance, &matrix, &bounds);
            self.instances.push(Instance { start: index, opened_from: number, ..part });
        }
        Ok(())
    }
}

/// The number of triangles below a node. Triangles are numbered in the order of the leaves, so it is the
/// last one of the last leaf less the first one of the first leaf, plus 1.
fn held(nodes: &[Node], root: u32, node: &Node) -> u32 {
    let leaf = |side: u32| {
        let mut node = node;
        while !node.is_leaf() {
            node = &nodes[(root + node.first + side) as usize];
        }
        node
    };
    let last = leaf(1);
    last.first + last.triangles() - leaf(0).first
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::Attribute;
    use crate::scene::{Bvh, Material, Mesh, Sequential};
    use glam::{Mat4, Vec3};

    /// `count` instances of 200 triangles on a strip, each turned.
    fn strips(count: u32) -> Scene {
        let corner = |i: u32| [(i / 2) as f32, (i % 2) as f32, (i % 7) as f32 * 0.1];
        let attribute = Attribute { normal: [0.0; 3], uv: [0.0; 2], color: Attribute::WHITE };
        let indices = (0..200).flat_map(|i| [i, i + 1, i + 2]).collect();
        let mesh = Mesh::new((0..202).map(corner).collect(), alloc::vec![attribute; 202], indices).unwrap();
        let mut scene = Scene::new();
        let gray = scene.add_material(Material::new([0.5; 3]).roughness(0.5)).unwrap();
        let strip = scene.add_mesh(&mesh, &Bvh::build(&mesh, &Sequential)).unwrap();
        for i in 0..count {
            let place = Mat4::from_rotation_y(i as f32) * Mat4::from_scale(Vec3::new(1.0, 2.0, 0.5));
            scene.add_instance(strip, gray, place).unwrap();
        }
        scene
    }

    #[test]
    fn parts_hold_every_triangle_once_and_lie_in_their_objects_bounds() {
        let scene = strips(2);
        for most in [1, 5, 64, 1000] {
            let mut parts = BvhCut::default();
            parts.make(&scene, scene.instances(), 0, most).unwrap();
            let mut seen = alloc::vec![0; 400];
            for part in &parts.instances()[2..] {
                let (whole, node) =
                    (&scene.instances()[part.opened_from as usize], &scene.nodes()[part.start as usize]);
                let (mut below, mut held_here) = (alloc::vec![node], 0);
                while let Some(node) = below.pop() {
                    if node.is_leaf() {
                        held_here += node.triangles();
                        for id in node.first..node.first + node.triangles() {
                            seen[(200 * part.opened_from + id) as usize] += 1;
                        }
                    } else {
                        below.extend(&scene.nodes()[(whole.root + node.first) as usize..][..2]);
                    }
                }
                assert_eq!(held_here, held(scene.nodes(), whole.root, node));
                assert!(held_here <= most || node.is_leaf(), "{held_here} of {most}");
                assert!((0..3).all(|i| whole.low[i] <= part.low[i] && part.high[i] <= whole.high[i]));
            }
            assert!(seen.iter().all(|&times| times == 1), "{most}: {seen:?}");
        }
    }

    #[test]
    fn few_objects_of_many_triangles_are_cut() {
        assert_eq!(triangles(strips(3).instances()), Some(64));
        assert_eq!(triangles(strips(100).instances()), Some(20_000 / 256));
        assert_eq!(triangles(strips(256).instances()), None);
        assert_eq!(triangles(&[]), None);
        assert_eq!(Structure::default(), Structure::Blocks);
    }
}

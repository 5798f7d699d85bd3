//! Meshes that stand in one space, as one tree.
//!
//! A ray enters the meshes of a building one after the other if each has a tree of its own, since their boxes
//! overlap. Instances with the same transform are met in one tree over the leaves of all their meshes
//! (after Benthin et al., "Improved Two-Level BVHs using Partial Re-Braiding", HPG 2017, opened down to leaves).

use super::source::{MeshVersion, Parts};
use super::tree::MeshTree;
use super::wide::{Child, WIDTH, WideTree};
use super::widen::widened;
use crate::layout::Instance;
use crate::scene::{Bounds, Bvh, Join};
use alloc::vec;
use alloc::vec::Vec;

/// A leaf of the mesh of an instance.
#[derive(Debug, Clone, Copy)]
pub(crate) struct MergedLeaf {
    pub instance: u32,
    /// The first of its blocks, and how many they are.
    pub block: u32,
    pub count: u32,
}

/// A transform.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Space {
    pub to_object: [[f32; 4]; 3],
    pub to_world: [[f32; 4]; 3],
    /// Whether world and object space are the same.
    pub is_identity: bool,
}

impl Space {
    fn of(instance: &Instance) -> Self {
        let &Instance { to_object, to_world, is_identity, .. } = instance;
        Self { to_object, to_world, is_identity: is_identity == 1 }
    }

    /// Whether an instance stands in it.
    fn has(&self, instance: &Instance) -> bool {
        bits(&self.to_world) == bits(&instance.to_world)
    }
}

fn bits(rows: &[[f32; 4]; 3]) -> [[u32; 4]; 3] {
    rows.map(|row| row.map(f32::to_bits))
}

/// The mesh that an instance had when its leaves were taken, and how many blocks these have.
#[derive(Debug, Clone, Copy)]
struct Member {
    mesh: usize,
    version: MeshVersion,
    blocks: usize,
}

/// The tree over the leaves of meshes that stand in one space.
#[derive(Debug)]
pub(crate) struct Merged {
    /// Its leaves hold one leaf of a mesh each.
    pub tree: WideTree,
    pub leaves: Vec<MergedLeaf>,
    /// The box of all, object space.
    pub bounds: Bounds,
    pub space: Space,
    /// The instances, by number.
    members: Vec<Option<Member>>,
    /// The blocks of all leaves.
    blocks: usize,
    /// The blocks of those instances that are met here now.
    met: usize,
}

impl Default for Merged {
    fn default() -> Self {
        Self {
            tree: WideTree::default(),
            leaves: vec![],
            bounds: Bounds::EMPTY,
            space: Space::default(),
            members: vec![],
            blocks: 0,
            met: 0,
        }
    }
}

impl Merged {
    /// Whether an instance is met in this tree: it stands where the others do, with the mesh that it had.
    pub fn holds(&self, source: &impl Parts, meshes: &[MeshTree], number: usize) -> bool {
        let is_same = |member: &Member| {
            let mesh = source.mesh_of(number);
            member.mesh == mesh && member.version == meshes[mesh].version
        };
        self.members.get(number).is_some_and(|member| member.as_ref().is_some_and(is_same))
            && self.space.has(&source.instances()[number])
            && !source.places().bounds(number).is_empty()
    }

    /// Counts an instance that has come in or gone out.
    pub fn count(&mut self, number: usize, is_met: bool) {
        let blocks = self.members[number].map_or(0, |member| member.blocks);
        if is_met {
            self.met += blocks;
        } else {
            self.met -= blocks;
        }
    }

    /// Whether less than half of it is met.
    pub fn is_hollow(&self) -> bool {
        self.blocks > 2 * self.met
    }

    /// Follows these instances, which have moved, where they are most of it and stand in another space together; returns
    /// whether that is so.
    pub fn follow(&mut self, source: &impl Parts, moved: impl Iterator<Item = usize> + Clone) -> bool {
        let of = |number: usize| {
            let member = self.members.get(number).copied().flatten();
            member.map(|member| (&source.instances()[number], member.blocks))
        };
        // The only one that can be that of most (Boyer and Moore's vote).
        let (mut most, mut votes) = (None::<Space>, 0);
        for (instance, blocks) in moved.clone().filter_map(of) {
            if most.is_some_and(|space| space.has(instance)) {
                votes += blocks;
            } else if votes >= blocks {
                votes -= blocks;
            } else {
                (most, votes) = (Some(Space::of(instance)), blocks - votes);
            }
        }
        let Some(space) = most else { return false };
        let blocks: usize =
            moved.filter_map(of).filter(|(instance, _)| space.has(instance)).map(|(_, blocks)| blocks).sum();
        let follows = bits(&space.to_world) != bits(&self.space.to_world) && 2 * blocks > self.blocks;
        if follows {
            self.space = space;
        }
        follows
    }

    /// Makes a new tree if that would hold twice as much as is met in this one, and ends this one if it is hollow. No
    /// instance is counted after it.
    pub fn renew(&mut self, source: &impl Parts, meshes: &[MeshTree], join: &impl Join) {
        self.met = (0..self.members.len())
            .filter(|&number| self.holds(source, meshes, number))
            .map(|number| self.members[number].map_or(0, |member| member.blocks))
            .sum();
        let together = together(source, meshes);
        let blocks = |&number: &u32| meshes[source.mesh_of(number as usize)].blocks.len();
        let all: usize = together.iter().map(blocks).sum();
        // A mesh that is most of it has as good a tree of its own.
        let largest = together.iter().map(blocks).max().unwrap_or(0);
        if 4 * largest <= 3 * all && all > 2 * self.met {
            *self = Self::new(source, meshes, &together, join);
        } else if self.is_hollow() {
            *self = Self::default();
        }
        self.met = 0;
    }

    fn new(source: &impl Parts, meshes: &[MeshTree], together: &[u32], join: &impl Join) -> Self {
        let mut members = vec![None; source.instances().len()];
        let (mut leaves, mut boxes, mut blocks) = (vec![], vec![], 0);
        for &instance in together {
            let mesh = source.mesh_of(instance as usize);
            let tree = &meshes[mesh];
            for node in &tree.tree.nodes {
                for slot in 0..WIDTH {
                    let Child::Leaf(block, count) = node.child(slot) else { continue };
                    if count > 0 {
                        leaves.push(MergedLeaf { instance, block, count });
                        boxes.push(node.bounds(slot));
                    }
                }
            }
            let member = Member { mesh, version: tree.version, blocks: tree.blocks.len() };
            members[instance as usize] = Some(member);
            blocks += member.blocks;
        }
        let narrow = Bvh::over(&boxes, 1, join);
        let tree = widened(&narrow.nodes, 1);
        Self {
            bounds: tree.nodes[0].all_bounds(),
            tree,
            leaves: narrow.triangles.iter().map(|&leaf| leaves[leaf as usize]).collect(),
            space: together.first().map_or(Space::default(), |&i| Space::of(&source.instances()[i as usize])),
            members,
            blocks,
            met: 0,
        }
    }

    /// Its bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.tree.nodes[..]) + size_of_val(&self.leaves[..]) + size_of_val(&self.members[..])
    }
}

/// The instances of the space with the most blocks. Those that are hidden stay away, and those with a mesh that bends.
fn together(source: &impl Parts, meshes: &[MeshTree]) -> Vec<u32> {
    let instances = source.instances();
    let can_join = |number: &usize| {
        let is_rigid = || meshes[source.mesh_of(*number)].version.shape == 0;
        !instances[*number].is_sphere() && !source.places().bounds(*number).is_empty() && is_rigid()
    };
    let mut sorted: Vec<(u64, u32)> = (0..instances.len())
        .filter(can_join)
        .map(|number| (hash(&instances[number].to_world), number as u32))
        .collect();
    sorted.sort_unstable();
    let blocks = |run: &&[(u64, u32)]| -> usize {
        run.iter().map(|&(_, number)| meshes[source.mesh_of(number as usize)].blocks.len()).sum()
    };
    let Some(largest) = sorted.chunk_by(|a, b| a.0 == b.0).max_by_key(blocks) else { return vec![] };
    let space = Space::of(&instances[largest[0].1 as usize]);
    largest
        .iter()
        .map(|&(_, number)| number)
        .filter(|&number| space.has(&instances[number as usize]))
        .collect()
}

/// A number that transforms share if they are the same, and hardly else (FNV-1a, by words).
fn hash(rows: &[[f32; 4]; 3]) -> u64 {
    let mix = |hash: u64, c: &f32| (hash ^ u64::from(c.to_bits())).wrapping_mul(0x0100_0000_01b3);
    rows.as_flattened().iter().fold(0xcbf2_9ce4_8422_2325, mix)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::triangle::{Triangle, intersect};
    use crate::query::fixture::{Random, add, is_merged};
    use crate::query::search::Found;
    use crate::query::{Ray, Tree};
    use crate::scene::{Material, MaterialIndex, MeshIndex, Scene, Sequential};
    use glam::{Mat4, Vec3};

    /// A scene with so many meshes, and a material.
    fn scene(random: &mut Random, meshes: usize) -> (Scene, Vec<MeshIndex>, MaterialIndex) {
        let mut scene = Scene::new();
        let white = scene.add_material(Material::default()).unwrap();
        let meshes = (0..meshes).map(|_| add(&mut scene, &random.mesh(90, 5.0))).collect();
        (scene, meshes, white)
    }

    /// The closest hit, of all triangles one after the other.
    fn brute(scene: &Scene, ray: &Ray) -> Option<(u32, u32, u32, u32, u32)> {
        let scaled = ray.scaled().unwrap();
        let mut best: Option<Found> = None;
        for (number, instance) in (0..).zip(scene.instances()) {
            let is_hidden = Parts::places(scene).bounds(number as usize).is_empty();
            let is_skipped = ray.skip.is_some_and(|skip| skip.number == number);
            if is_hidden || is_skipped || Parts::tags(scene)[number as usize].mask & ray.mask == 0 {
                continue;
            }
            let local = match instance.is_identity {
                1 => scaled.ray,
                _ => scaled.ray.transformed(&instance.to_object),
            };
            for triangle in 0..instance.triangles {
                let [a, b, c] =
                    instance.corners(scene.mesh_data(), triangle).map(|v| scene.positions()[v as usize]);
                let relative = Triangle::new(a, b, c).relative_to(local.origin);
                let hit = intersect(&local, &relative, f32::MAX);
                let found = Found { t: hit.t, instance: number, triangle, u: hit.u, v: hit.v };
                if hit.mask && found.t >= scaled.span.from && best.is_none_or(|best| found.is_before(&best)) {
                    best = Some(found);
                }
            }
        }
        best.map(|found| {
            (
                scaled.span.t(found.t).to_bits(),
                found.instance,
                found.triangle,
                found.u.to_bits(),
                found.v.to_bits(),
            )
        })
    }

    #[test]
    fn meshes_are_merged_that_stand_in_one_space() {
        let mut random = Random(1);
        let (mut scene, meshes, white) = scene(&mut random, 5);
        let space = random.place(6.0);
        let merged: Vec<_> =
            meshes[..3].iter().map(|&mesh| scene.add_instance(mesh, white, space).unwrap()).collect();
        let ball = scene.add_sphere(white, space).unwrap();
        let elsewhere = scene.add_instance(meshes[3], white, random.place(6.0)).unwrap();
        let bent = scene.add_instance(meshes[4], white, space).unwrap();
        scene.reshape(meshes[4], &random.mesh(90, 5.0)).unwrap();
        let hidden = scene.add_instance(meshes[3], white, space).unwrap();
        scene.hide(hidden).unwrap();
        let mut tree = Tree::new(&scene, &Sequential);
        assert!(merged.iter().all(|&instance| is_merged(&tree, instance)));
        assert!([ball, elsewhere, bent, hidden].iter().all(|&instance| !is_merged(&tree, instance)));
        // What moves is met by itself, and here again once it is back.
        scene.set_transform(merged[0], Mat4::IDENTITY).unwrap();
        tree.world(&scene);
        assert!(!is_merged(&tree, merged[0]) && is_merged(&tree, merged[1]));
        scene.set_transform(merged[0], space).unwrap();
        tree.world(&scene);
        assert!(is_merged(&tree, merged[0]));
        // All that move together stay together.
        let nodes = tree.instances.merged.tree.nodes.as_ptr();
        merged.iter().for_each(|&instance| scene.set_transform(instance, random.place(6.0)).unwrap());
        let space = random.place(6.0);
        merged.iter().for_each(|&instance| scene.set_transform(instance, space).unwrap());
        tree.world(&scene);
        assert!(merged.iter().all(|&instance| is_merged(&tree, instance)));
        assert_eq!(tree.instances.merged.tree.nodes.as_ptr(), nodes);
        // Where most are elsewhere, none is merged.
        merged[..2].iter().for_each(|&instance| scene.set_transform(instance, random.place(6.0)).unwrap());
        tree.world(&scene);
        assert!(!is_merged(&tree, merged[2]) && tree.instances.merged.leaves.is_empty());
    }

    #[test]
    fn what_moves_out_does_not_build_the_tree_over_the_instances() {
        let (mut scene, meshes, white) = scene(&mut Random(4), 40);
        let add = |mesh: &MeshIndex| scene.add_instance(*mesh, white, Mat4::IDENTITY).unwrap();
        let instances: Vec<_> = meshes.iter().map(add).collect();
        let mut tree = Tree::new(&scene, &Sequential);
        let nodes = tree.instances.tree.nodes.as_ptr();
        for (number, &instance) in instances[..15].iter().enumerate() {
            scene.set_transform(instance, Mat4::from_translation(Vec3::X * (number + 1) as f32)).unwrap();
            tree.world(&scene);
            assert!(!is_merged(&tree, instance) && is_merged(&tree, instances[20]));
            assert_eq!(tree.instances.tree.nodes.as_ptr(), nodes);
        }
    }

    #[test]
    fn a_mesh_that_is_most_of_it_stays_alone() {
        let mut random = Random(2);
        let (mut scene, meshes, white) = scene(&mut random, 2);
        scene.add_instance(meshes[0], white, Mat4::IDENTITY).unwrap();
        assert!(Tree::new(&scene, &Sequential).instances.merged.leaves.is_empty());
        scene.add_instance(meshes[1], white, Mat4::IDENTITY).unwrap();
        assert!(!Tree::new(&scene, &Sequential).instances.merged.leaves.is_empty());
        let large = add(&mut scene, &random.mesh(900, 5.0));
        scene.add_instance(large, white, Mat4::IDENTITY).unwrap();
        assert!(Tree::new(&scene, &Sequential).instances.merged.leaves.is_empty());
    }

    #[test]
    fn whatever_changes_rays_meet_what_is_there() {
        let mut random = Random(3);
        let (mut scene, mut meshes, white) = scene(&mut random, 6);
        let mut spaces = [random.place(6.0), Mat4::IDENTITY, random.place(6.0)];
        let mut instances: Vec<_> =
            meshes.iter().map(|&mesh| scene.add_instance(mesh, white, spaces[1]).unwrap()).collect();
        let mut tree = Tree::default();
        let (mut hits, mut merged, mut apart) = (0, 0, 0);
        for step in 0..2000 {
            let which = random.below(instances.len());
            let space = if random.below(8) == 0 {
                random.place(6.0)
            } else {
                spaces[[1, 1, 1, 0, 2][random.below(5)]]
            };
            match random.below(13) {
                0 => scene.hide(instances[which]).unwrap(),
                1 => {
                    scene.remove_instance(instances.swap_remove(which)).unwrap();
                    let mesh = meshes[random.below(meshes.len())];
                    instances.push(scene.add_instance(mesh, white, space).unwrap());
                }
                2 if instances.len() < 12 => {
                    let mesh = meshes[random.below(meshes.len())];
                    instances.push(scene.add_instance(mesh, white, space).unwrap());
                }
                3 if step % 4 == 0 => {
                    let mesh = random.below(meshes.len());
                    scene.reshape(meshes[mesh], &random.mesh(90, 5.0)).unwrap();
                }
                4 => {
                    let gone = meshes.swap_remove(random.below(meshes.len()));
                    meshes.push(add(&mut scene, &random.mesh(90, 5.0)));
                    let of_it: Vec<_> = (0..instances.len())
                        .filter(|&i| {
                            Parts::mesh_of(&scene, instances[i].number as usize) == gone.number as usize
                        })
                        .collect();
                    for i in of_it.into_iter().rev() {
                        scene.remove_instance(instances.swap_remove(i)).unwrap();
                    }
                    scene.remove_mesh(gone).unwrap();
                    instances.push(scene.add_instance(meshes[0], white, space).unwrap());
                }
                5 => {
                    spaces[1] = if random.below(2) == 0 { Mat4::IDENTITY } else { random.place(6.0) };
                    let but = if random.below(2) == 0 { Some(instances[which]) } else { None };
                    for &instance in instances.iter().filter(|instance| but != Some(**instance)) {
                        scene.set_transform(instance, spaces[1]).unwrap();
                    }
                }
                6 => scene.set_ray_mask(instances[which], 1 + random.below(3) as u32).unwrap(),
                _ => scene.set_transform(instances[which], space).unwrap(),
            }
            let world = tree.world(&scene);
            for _ in 0..8 {
                let start = random.vector(9.0);
                let at = &scene.instances()[random.below(scene.instances().len())];
                let to = Vec3::from(at.center) + random.vector(3.0);
                let mut ray = Ray::new(start, to - start + Vec3::splat(0.001));
                ray = ray.mask(1 + random.below(3) as u32);
                if random.below(4) == 0 {
                    ray = ray.skip(instances[random.below(instances.len())]);
                }
                let hit = world.closest(&ray).unwrap();
                let expected = brute(&scene, &ray);
                let found = hit.map(|hit| {
                    (hit.t.to_bits(), hit.instance.number, hit.triangle, hit.u.to_bits(), hit.v.to_bits())
                });
                assert_eq!(found, expected, "step {step}");
                assert_eq!(world.occluded(&ray).unwrap(), expected.is_some(), "step {step}");
                hits += u32::from(expected.is_some());
            }
            let top = &tree.instances;
            let met = top.entries.iter().filter(|entry| entry.is_merged).count();
            let counted: usize = (0..top.entries.len())
                .filter(|&number| top.entries[number].is_merged)
                .map(|number| top.merged.members[number].unwrap().blocks)
                .sum();
            assert_eq!(counted, top.merged.met, "step {step}");
            merged += u32::from(met > 0);
            apart += u32::from(met > 0 && met < instances.len());
        }
        assert!(hits > 5000 && merged > 300 && apart > 200, "{hits} {merged} {apart}");
    }
}

//! Removal of instances and meshes.

use super::{InstanceIndex, MeshIndex, Scene, SceneError};
use crate::layout::{Instance, Transparency, TransparencyVertex};
use crate::scene::place::Stored;
use crate::scene::{Bvh, Mesh, Sequential};
use alloc::vec::Vec;
use bytemuck::cast_slice_mut;
use core::mem::take;
use core::ops::Range;

impl Scene {
    /// Removes an instance. Its index names nothing from now on; its number goes to the next instance that is added. The
    /// others keep their numbers, and its mesh stays. No memory is given back.
    ///
    /// # Errors
    /// There is no such instance.
    pub fn remove_instance(&mut self, instance: InstanceIndex) -> Result<(), SceneError> {
        self.hide(instance)?;
        let index = instance.number as usize;
        self.instances[index].transparency = 0;
        self.tags[index] = self.tags[index].next();
        self.levels.remove(&instance.number);
        self.shown.retain(|_, sphere| *sphere != instance.number);
        self.free_instances.push(instance.number);
        Ok(())
    }

    /// Removes a mesh. Its index names nothing from now on. What follows it in the arrays moves up, so that the next meshes
    /// have its memory; the time is that of a copy of those arrays. Materials and textures stay.
    ///
    /// # Errors
    /// There is no such mesh, or an instance, visible or hidden, has it or has it as a level of detail. The scene then
    /// stays as it was.
    pub fn remove_mesh(&mut self, mesh: MeshIndex) -> Result<(), SceneError> {
        let stored = *self.indexed_mesh(mesh)?;
        let own = self.object_meshes.iter().zip(&self.tags);
        let own = own.filter(|(number, tag)| **number == mesh.number && tag.is_live()).count();
        let levels = self.levels.values().filter(|levels| levels.iter().any(|level| level.mesh == mesh));
        let instances = own + levels.count();
        if instances > 0 {
            return Err(SceneError::InUse { index: mesh.number, instances });
        }
        let nothing = match self.nothing {
            Some(nothing) => nothing,
            None => {
                let shape = Mesh::nothing();
                self.add_mesh(&shape, &Bvh::build(&shape, &Sequential))?.number
            }
        };
        self.nothing = Some(nothing);
        let words = self.words(mesh, &stored);
        self.cut_out(&stored, &words);
        // Numbers that are free stand for a mesh without triangles, which no instance that is seen has.
        let generation = stored.generation.wrapping_add(1);
        self.meshes[mesh.number as usize] = Stored { generation, ..self.meshes[nothing as usize] };
        self.free_meshes.push(mesh.number);
        self.transparencies.retain(|(of, _), _| *of != mesh.number);
        for at in self.transparencies.values_mut() {
            *at = words.moved(*at);
            let record = &mut self.mesh_data[*at as usize..][..Transparency::WORDS as usize];
            let [record] = cast_slice_mut::<_, Transparency>(record) else { continue };
            record.first_vertex = words.moved(record.first_vertex);
        }
        self.point_again(&words);
        self.versions.geometry += 1;
        self.versions.instances += 1;
        Ok(())
    }

    /// Whether this is the index of an instance of this scene that was removed.
    pub fn is_removed(&self, instance: InstanceIndex) -> bool {
        let was_here = instance.scene == self.family() && (instance.number as usize) < self.tags.len();
        was_here && self.instance_index(instance.number) != Some(instance)
    }

    /// Whether this is the index of a mesh of this scene that was removed.
    pub fn is_mesh_removed(&self, mesh: MeshIndex) -> bool {
        let was_here = mesh.scene == self.family() && (mesh.number as usize) < self.meshes.len();
        was_here && self.indexed_mesh(mesh).is_err()
    }

    /// The words of a mesh in the mesh data.
    fn words(&self, mesh: MeshIndex, stored: &Stored) -> Holes {
        let optional = |first: u32, count: u32| if first == 0 { 0 } else { count * stored.vertices };
        let more = optional(stored.first_tangent, 1) + optional(stored.first_second_uv, 2);
        let own = stored.first_index..stored.first_index + 3 * stored.triangles + more;
        let mut holes = Vec::from_iter([own]);
        let vertices = TransparencyVertex::WORDS * stored.vertices;
        holes.extend(stored.transparencies.into_iter().filter(|at| *at > 0).map(|at| at..at + vertices));
        let records = self.transparencies.iter().filter(|((of, _), _)| *of == mesh.number);
        holes.extend(records.map(|(_, &at)| at..at + Transparency::WORDS));
        holes.sort_by_key(|hole| hole.start);
        Holes(holes)
    }

    /// Cuts a mesh out of all arrays, and moves the ranges of those behind it.
    fn cut_out(&mut self, gone: &Stored, words: &Holes) {
        let pairs = gone.nodes.div_ceil(2);
        let pair = (gone.root - 1) / 2;
        self.nodes.drain(pair as usize..(pair + pairs) as usize);
        let vertices = gone.first_vertex as usize..(gone.first_vertex + gone.vertices) as usize;
        self.positions.drain(vertices.clone());
        self.attributes.drain(vertices);
        self.sources.drain(gone.first_source..gone.first_source + gone.triangles as usize);
        for hole in words.0.iter().rev() {
            self.mesh_data.drain(hole.start as usize..hole.end as usize);
        }
        for mesh in &mut self.meshes {
            if mesh.root > gone.root {
                mesh.root -= 2 * pairs;
                mesh.first_vertex -= gone.vertices;
                mesh.first_source -= gone.triangles as usize;
            }
            let [a, b] = &mut mesh.transparencies;
            for at in [&mut mesh.first_index, &mut mesh.first_tangent, &mut mesh.first_second_uv, a, b] {
                *at = words.moved(*at);
            }
        }
    }

    /// Lets instances point to where their meshes are now.
    fn point_again(&mut self, words: &Holes) {
        let point = |instance: &mut Instance, mesh: &Stored, is_seen: bool| {
            let root = if is_seen { mesh.root } else { mesh.root - 1 };
            (instance.root, instance.start) = (root, root);
            instance.first_vertex = mesh.first_vertex;
            instance.first_index = mesh.first_index;
            instance.first_tangent = mesh.first_tangent;
            instance.first_second_uv = mesh.first_second_uv;
            instance.transparency = words.moved(instance.transparency);
        };
        for (index, instance) in self.instances.iter_mut().enumerate() {
            let is_seen = !self.places.bounds(index).is_empty();
            point(instance, &self.meshes[self.object_meshes[index] as usize], is_seen);
        }
        let mut levels = take(&mut self.levels);
        for level in levels.values_mut().flatten() {
            point(&mut level.placed, &self.meshes[level.mesh.number as usize], true);
        }
        self.levels = levels;
    }
}

/// Ranges that are cut out of an array, in order.
struct Holes(Vec<Range<u32>>);

impl Holes {
    /// Where an element is that was at `at`, outside of the ranges. 0, which stands for nothing, stays.
    fn moved(&self, at: u32) -> u32 {
        let before = self.0.iter().take_while(|hole| hole.start < at);
        at - before.map(|hole| hole.end.min(at) - hole.start).sum::<u32>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::Attribute;
    use crate::scene::{Image, Material, Wrap};
    use alloc::vec;
    use bytemuck::cast_slice;
    use glam::Mat4;

    /// A mesh of so many triangles, with everything that a mesh can have.
    fn mesh(triangles: u32) -> Mesh {
        let corners = || 0..3 * triangles;
        let position = |i: u32| [(i * 7 % 10) as f32, (i * 3 % 7) as f32 + (i % 3) as f32, i as f32];
        let attribute = Attribute { normal: [0.0, 0.0, 1.0], uv: [0.1, 0.2], color: Attribute::WHITE };
        let mesh = Mesh::new(
            corners().map(position).collect(),
            vec![attribute; corners().len()],
            corners().collect(),
        );
        let mesh = mesh.unwrap().with_second_uv(vec![[0.3, 0.4]; corners().len()]).unwrap();
        mesh.with_tangents(&vec![[1.0, 0.0, 0.0, 1.0]; corners().len()]).unwrap()
    }

    /// What rays and pictures read of an instance: corners, words, the corner of its box, what its root is.
    type Seen = (Vec<[f32; 3]>, Vec<u32>, [f32; 3], u32);

    /// Those of the instances that are there.
    fn seen(scene: &Scene) -> Vec<Seen> {
        let live = |number: u32| scene.instance_index(number).is_some();
        let numbers = (0..scene.instances().len() as u32).filter(|&number| live(number));
        numbers
            .map(|number| {
                let instance = &scene.instances()[number as usize];
                let stored = &scene.stored_meshes()[scene.mesh_numbers()[number as usize] as usize];
                let corners = (0..instance.triangles).flat_map(|t| instance.corners(scene.mesh_data(), t));
                let places = corners.clone().map(|vertex| scene.positions()[vertex as usize]).collect();
                let of = |first: u32, words: u32| {
                    let range = first as usize..(first + if first > 0 { words } else { 0 }) as usize;
                    scene.mesh_data()[range].to_vec()
                };
                let mut words = of(instance.first_tangent, stored.vertices);
                words.extend(of(instance.first_second_uv, 2 * stored.vertices));
                if instance.transparency > 0 {
                    // All of the record but where its vertices are, and those.
                    let record = of(instance.transparency, Transparency::WORDS);
                    let record: Transparency = *bytemuck::from_bytes(cast_slice(&record));
                    words.extend(of(record.first_vertex, TransparencyVertex::WORDS * stored.vertices));
                    words.extend_from_slice(cast_slice(&[Transparency { first_vertex: 0, ..record }]));
                }
                let node = scene.nodes()[instance.root as usize];
                words.extend((0..stored.triangles).filter_map(|t| {
                    let index = scene.instance_index(number).unwrap();
                    scene.source_triangle(index, t)
                }));
                (places, words, node.low, node.kind)
            })
            .collect()
    }

    #[test]
    fn what_stays_is_as_if_the_rest_had_never_been() {
        for gone in 0..5_u32 {
            let build = |is_there: &dyn Fn(u32) -> bool| {
                let mut scene = Scene::new();
                let map = Image { width: 4, height: 4, rgba: (0..64).collect() };
                let texture = scene.add_texture(&map, [Wrap::Repeat; 2]).unwrap();
                let glass = Material::new([0.5; 3]).base_color_map(texture).blend(0.5);
                let materials = [Material::default(), glass, glass].map(|m| scene.add_material(m).unwrap());
                let mut indices = vec![];
                for number in (0..5).filter(|&number| is_there(number)) {
                    let shape = mesh(3 + 2 * number);
                    let index = scene.add_mesh(&shape, &Bvh::build(&shape, &Sequential)).unwrap();
                    for (copy, material) in materials.into_iter().enumerate() {
                        let place = Mat4::from_translation([copy as f32, number as f32, 0.0].into());
                        let placed = scene.add_instance(index, material, place).unwrap();
                        indices.push((number, index, placed));
                    }
                }
                (scene, indices)
            };
            let (mut scene, indices) = build(&|_| true);
            let (_, hidden, _) = indices[3 * ((gone as usize + 1) % 5)];
            let own: Vec<_> = indices.iter().filter(|(number, ..)| *number == gone).copied().collect();
            let refused = scene.remove_mesh(own[0].1);
            assert_eq!(refused, Err(SceneError::InUse { index: own[0].1.number, instances: 3 }));
            for (_, _, instance) in &own {
                scene.remove_instance(*instance).unwrap();
                assert!(scene.set_transform(*instance, Mat4::IDENTITY).is_err());
                assert!(scene.remove_instance(*instance).is_err());
                assert_eq!(scene.instance_index(instance.number()), None);
            }
            scene.remove_mesh(own[0].1).unwrap();
            assert!(scene.remove_mesh(own[0].1).is_err());
            let (without, _) = build(&|number| number != gone);
            assert_eq!(seen(&scene), seen(&without));
            assert_eq!(scene.drawn_triangles(), without.drawn_triangles());
            assert_eq!(scene.source_bytes(), without.source_bytes());
            // One pair of nodes more: what is removed stands on it.
            assert_eq!(scene.nodes().len(), without.nodes().len() + 2);
            assert_eq!(scene.mesh_data().len(), without.mesh_data().len());
            assert_eq!((scene.extent(), scene.triangles()), (without.extent(), without.triangles()));
            // The numbers go to the next ones, under other indices.
            let shape = mesh(3 + 2 * gone);
            let again = scene.add_mesh(&shape, &Bvh::build(&shape, &Sequential)).unwrap();
            assert!(again.number == own[0].1.number && again != own[0].1);
            let material = scene.material_of(scene.instance_index(hidden.number).unwrap_or(indices[14].2));
            let placed = scene.add_instance(again, material.unwrap(), Mat4::IDENTITY).unwrap();
            assert!(placed.number() == own[2].2.number() && placed != own[2].2);
            assert!(scene.hide(own[2].2).is_err() && scene.hide(placed).is_ok());
            assert!(scene.add_instance(own[0].1, material.unwrap(), Mat4::IDENTITY).is_err());
        }
    }

    #[test]
    fn the_sphere_of_a_light_can_be_removed_and_shown_again() {
        let mut scene = Scene::new();
        scene.add_light(crate::scene::Light::point([1.0; 3]).radius(0.5));
        let sphere = scene.show_light(0).unwrap().unwrap();
        scene.remove_instance(sphere).unwrap();
        assert_eq!(scene.extent(), None);
        let again = scene.show_light(0).unwrap().unwrap();
        assert!(again.number() == sphere.number() && again != sphere && scene.extent().is_some());
    }

    #[test]
    fn a_mesh_that_is_a_level_of_detail_stays() {
        let mut scene = Scene::new();
        let material = scene.add_material(Material::default()).unwrap();
        let [near, far] = [9, 3].map(|triangles| {
            let shape = mesh(triangles);
            scene.add_mesh(&shape, &Bvh::build(&shape, &Sequential)).unwrap()
        });
        let instance = scene.add_instance(near, material, Mat4::IDENTITY).unwrap();
        scene.set_levels(instance, &[(5.0, far)]).unwrap();
        assert!(matches!(scene.remove_mesh(far), Err(SceneError::InUse { instances: 1, .. })));
        scene.remove_instance(instance).unwrap();
        assert_eq!((scene.remove_mesh(near), scene.remove_mesh(far)), (Ok(()), Ok(())));
        assert_eq!((scene.nodes().len(), scene.mesh_data().len(), scene.positions().len()), (2, 0, 0));
    }
}

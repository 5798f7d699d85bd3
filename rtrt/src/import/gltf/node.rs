//! The node hierarchy.

use super::accessor::Column;
use super::extensions::GPU_INSTANCING;
use super::meshes::Import;
use super::transform::{children, local, parts};
use super::{levels, light};
use crate::import::animation::{self, SceneNode};
use crate::import::error::quoted;
use crate::import::track::Track;
use crate::import::{ImportError, NamedCamera};
use glam::{DMat4, Mat4};
use gltf_json::accessor::{Accessor, Type};
use gltf_json::validation::Checked;
use gltf_json::{Index, Node, camera};
use rtrt_core::scene::{InstanceIndex, Join, Projection};
use std::collections::HashMap;

/// The most names of a path.
const PATH: usize = 16;

impl<J: Join> Import<'_, '_, J> {
    /// Adds the scene that the file names, else the first one, else all nodes that are neither children
    /// nor levels of detail.
    pub fn draw_scene(&mut self) -> Result<(), ImportError> {
        let root = self.root;
        let scene = match root.scene {
            Some(index) => {
                Some(root.get(index).ok_or_else(|| self.invalid("the scene is not there".into()))?)
            }
            None => root.scenes.first(),
        };
        let mut is_visited = vec![false; root.nodes.len()];
        let mut tracks: HashMap<usize, Vec<Track>> = HashMap::new();
        for track in self.tracks() {
            tracks.entry(track.node).or_default().push(track);
        }
        let from_origin = DMat4::from_translation(-self.builder.origin);
        let mut worlds: Vec<(DMat4, bool)> = vec![];
        // The places of the file's nodes in `self.nodes`, and the reverse.
        let mut places = HashMap::new();
        let mut numbers: Vec<usize> = vec![];
        let mut next: Vec<(usize, Option<usize>)> = match scene {
            Some(scene) => scene.nodes.iter().rev().map(|node| (node.value(), None)).collect(),
            None => {
                let mut is_child = vec![false; root.nodes.len()];
                for child in
                    root.nodes.iter().flat_map(|node| levels::ids(node).into_iter().chain(children(node)))
                {
                    if let Some(is_child) = is_child.get_mut(child) {
                        *is_child = true;
                    }
                }
                (0..root.nodes.len()).rev().filter(|&i| !is_child[i]).map(|i| (i, None)).collect()
            }
        };
        // Depth first with a stack: recursion would overflow on long chains.
        while let Some((number, parent)) = next.pop() {
            let Some(node) = root.nodes.get(number) else {
                return Err(self.invalid(format!("there is no node {number}")));
            };
            if std::mem::replace(&mut is_visited[number], true) {
                return Err(self.invalid(format!("node {number} has two parents or is its own ancestor")));
            }
            let (from, is_carried) = parent.map_or((from_origin, false), |place: usize| worlds[place]);
            let (local, tracks) = (local(node), tracks.remove(&number).unwrap_or_default());
            let to_world = from * local.matrix();
            let moves = is_carried || !tracks.is_empty();
            worlds.push((to_world, moves));
            let mut placed = SceneNode {
                parent,
                local,
                tracks,
                objects: vec![],
                shapes: vec![],
                camera: None,
                light: None,
            };
            let path = if node.mesh.is_some() { self.path(parent, &numbers) } else { String::new() };
            self.draw_node(number, &path, &to_world, moves, &mut placed)?;
            self.nodes.push(placed);
            numbers.push(number);
            let place = self.nodes.len() - 1;
            places.insert(number, place);
            next.extend(node.children.iter().flatten().rev().map(|child| (child.value(), Some(place))));
        }
        let skins = self.nodes.iter_mut().flat_map(|node| &mut node.shapes).filter_map(|s| s.skin.as_mut());
        for joint in skins.flat_map(|skin| &mut skin.joints) {
            *joint = places.get(joint).copied().unwrap_or(usize::MAX);
        }
        Ok(())
    }

    /// Adds the mesh, the camera and the light of a node, and lists them in `placed` for animations.
    fn draw_node(
        &mut self,
        number: usize,
        path: &str,
        to_world: &DMat4,
        moves: bool,
        placed: &mut SceneNode,
    ) -> Result<(), ImportError> {
        let root = self.root;
        let node = &root.nodes[number];
        let name = match &node.name {
            Some(name) => format!("node {number} ({})", quoted(name)),
            None => format!("node {number}"),
        };
        if let Some(index) = node.mesh {
            let skin = node.skin.map(|skin| self.skin(skin)).transpose()?;
            let is_skinned = skin.is_some();
            let has_targets = self.source(index)?.primitives.iter().any(|p| p.targets.is_some());
            let parts = if is_skinned || has_targets {
                self.shapes(index, node.weights.as_ref(), skin, &mut placed.shapes)?
            } else {
                self.mesh(index)?
            };
            let label = [
                node.name.clone().unwrap_or_else(|| format!("node {number}")),
                self.source(index)?.name.clone().unwrap_or_else(|| format!("mesh {}", index.value())),
            ];
            // The joints place a skinned mesh; the node of the mesh does not.
            for &(mesh, material) in parts.iter().filter(|_| is_skinned) {
                let object = self.builder.add_instance(&name, mesh, material, Mat4::IDENTITY)?;
                self.label(object, &label, path);
            }
            let is_rigid = !is_skinned && !has_targets;
            let levels = if is_rigid { self.levels(&name, node, &parts)? } else { vec![] };
            let instances = if is_skinned { vec![] } else { self.instances(node)? };
            for instance in instances {
                let to_world = (*to_world * instance).as_mat4();
                for (part, &(mesh, material)) in parts.iter().enumerate() {
                    let object = if moves {
                        Some(self.builder.add_moving(&name, mesh, material, to_world)?)
                    } else {
                        self.builder.add_instance(&name, mesh, material, to_world)?
                    };
                    self.label(object, &label, path);
                    if let Some(object) = object.filter(|_| !levels.is_empty()) {
                        self.set_levels(object, part, &levels)?;
                    }
                    placed.objects.extend(object.map(|object| (object, instance)));
                }
            }
        }
        if let Some(index) = node.camera {
            let missing = || self.invalid(format!("{name} has a camera that is not there"));
            let source = self.root.get(index).ok_or_else(missing)?;
            let projection = projection(source);
            match projection.and_then(|projection| animation::camera(projection, to_world)) {
                Some(camera) => {
                    placed.camera = projection.map(|projection| (self.cameras.len(), projection));
                    let clip = clip(source).unwrap_or_else(|[near, far]| {
                        let why =
                            format!("the clip planes of the camera of {name} are ignored: {near} and {far}");
                        self.builder.warn(why);
                        [0.0, f32::INFINITY]
                    });
                    self.cameras.push(NamedCamera {
                        name: source.name.clone().or(node.name.clone()).unwrap_or_default(),
                        camera,
                        aspect: aspect(source),
                        clip,
                    });
                }
                None => {
                    self.builder.warn(format!("the camera of {name} is left out: its picture would be empty"))
                }
            }
        }
        let light = node.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref());
        if let Some(light) = light {
            let lights = self.root.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref());
            let source = lights.and_then(|lights| lights.lights.get(light.light.value()));
            let source =
                source.ok_or_else(|| self.invalid(format!("{name} has a light that is not there")))?;
            let before = self.builder.scene.lights().len();
            light::add(self.builder, source, to_world);
            placed.light = (self.builder.scene.lights().len() > before).then_some(before);
        }
        Ok(())
    }

    /// The names of the nodes from the nearest 16 down to this one, each followed by a slash. `numbers` has the file's
    /// number of each place.
    fn path(&self, place: Option<usize>, numbers: &[usize]) -> String {
        let parents = std::iter::successors(place, |&place| self.nodes[place].parent);
        let mut names: Vec<String> = parents
            .take(PATH)
            .map(|place| match &self.root.nodes[numbers[place]].name {
                Some(name) => format!("{name}/"),
                None => format!("node {}/", numbers[place]),
            })
            .collect();
        names.reverse();
        names.concat()
    }

    /// Labels an instance with the names of its node and its mesh, and of the nodes above.
    fn label(&mut self, object: Option<InstanceIndex>, [node, mesh]: &[String; 2], path: &str) {
        if let Some(object) = object {
            self.builder.label(object, node.clone(), mesh.clone());
            self.builder.set_path(object, path);
        }
    }

    /// The transforms of the node's mesh relative to the node: one, or those of EXT_mesh_gpu_instancing.
    fn instances(&self, node: &Node) -> Result<Vec<DMat4>, ImportError> {
        let extension = node.extensions.as_ref().and_then(|e| e.others.get(GPU_INSTANCING));
        let Some(attributes) = extension.and_then(|extension| extension.get("attributes")) else {
            return Ok(vec![DMat4::IDENTITY]);
        };
        let column = |name: &str, kind: Type| {
            let index = attributes.get(name).and_then(|index| index.as_u64());
            index
                .map(|index| {
                    let index: Index<Accessor> = Index::new(u32::try_from(index).unwrap_or(u32::MAX));
                    Column::new(&self.builder.path, self.root, self.buffers, index, &[kind])
                })
                .transpose()
        };
        let translations = column("TRANSLATION", Type::Vec3)?;
        let rotations = column("ROTATION", Type::Vec4)?;
        let scales = column("SCALE", Type::Vec3)?;
        let columns = || [&translations, &rotations, &scales].into_iter().flatten();
        let count = columns().map(|column| column.count).max().unwrap_or(0);
        if columns().any(|column| column.count != count) {
            return Err(self.invalid("the attributes of instances differ in number".into()));
        }
        let three = |column: &Option<Column<'_>>, i: usize| {
            column.as_ref().map(|column| {
                let [x, y, z, _] = column.at(i);
                [x, y, z]
            })
        };
        let instance = |i: usize| {
            let rotation = rotations.as_ref().map(|column| column.at(i));
            parts(three(&translations, i), rotation, three(&scales, i)).matrix()
        };
        Ok((0..count).map(instance).collect())
    }
}

/// The shape of the picture that a camera is made for: width / height.
fn aspect(source: &camera::Camera) -> Option<f32> {
    let aspect = match source.type_ {
        Checked::Valid(camera::Type::Perspective) => source.perspective.as_ref()?.aspect_ratio?,
        Checked::Valid(camera::Type::Orthographic) => {
            let camera = source.orthographic.as_ref()?;
            (camera.xmag / camera.ymag).abs()
        }
        Checked::Invalid => return None,
    };
    (aspect > 0.0 && aspect.is_finite()).then_some(aspect)
}

/// The depths of a camera's clip planes; an error with those that no camera has.
fn clip(source: &camera::Camera) -> Result<[f32; 2], [f32; 2]> {
    let perspective = source.perspective.as_ref().map(|p| [p.znear, p.zfar.unwrap_or(f32::INFINITY)]);
    let orthographic = source.orthographic.as_ref().map(|o| [o.znear, o.zfar]);
    let planes = match source.type_ {
        Checked::Valid(camera::Type::Orthographic) => orthographic,
        _ => perspective,
    };
    let [near, far] = planes.unwrap_or([0.0, f32::INFINITY]);
    if near >= 0.0 && near < far { Ok([near, far]) } else { Err([near, far]) }
}

/// The projection of a camera; none if the file does not say.
fn projection(source: &camera::Camera) -> Option<Projection> {
    match source.type_ {
        Checked::Valid(camera::Type::Perspective) => {
            Some(Projection::Perspective { fov_y: source.perspective.as_ref()?.yfov })
        }
        Checked::Valid(camera::Type::Orthographic) => {
            Some(Projection::Orthographic { height: 2.0 * source.orthographic.as_ref()?.ymag.abs() })
        }
        Checked::Invalid => None,
    }
}

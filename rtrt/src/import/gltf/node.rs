//! The node hierarchy: where everything is.

use super::Import;
use super::accessor::Column;
use super::light;
use crate::import::ImportError;
use crate::import::error::quoted;
use glam::{DMat4, DQuat, DVec3, Vec3};
use gltf_json::accessor::{Accessor, Type};
use gltf_json::validation::Checked;
use gltf_json::{Index, Node, camera};
use rtrt_core::scene::{Camera, Join, Projection};

impl<J: Join> Import<'_, '_, J> {
    /// Draws the file's scene: the one it names, else the first, else all nodes that are
    /// nobody's children.
    pub fn draw_scene(&mut self) -> Result<(), ImportError> {
        let root = self.root;
        let scene = match root.scene {
            Some(index) => {
                Some(root.get(index).ok_or_else(|| self.invalid("the scene is not there".into()))?)
            }
            None => root.scenes.first(),
        };
        let mut met = vec![false; root.nodes.len()];
        let mut next: Vec<(usize, DMat4)> = match scene {
            Some(scene) => scene.nodes.iter().rev().map(|node| (node.value(), DMat4::IDENTITY)).collect(),
            None => {
                let mut is_child = vec![false; root.nodes.len()];
                let children = root.nodes.iter().flat_map(|node| node.children.iter().flatten());
                for child in children {
                    if let Some(is_child) = is_child.get_mut(child.value()) {
                        *is_child = true;
                    }
                }
                (0..root.nodes.len()).rev().filter(|&i| !is_child[i]).map(|i| (i, DMat4::IDENTITY)).collect()
            }
        };
        // Depth first, children in their order, and no recursion: a chain may be long.
        while let Some((number, parent)) = next.pop() {
            let Some(node) = root.nodes.get(number) else {
                return Err(self.invalid(format!("there is no node {number}")));
            };
            if std::mem::replace(&mut met[number], true) {
                return Err(self.invalid(format!("node {number} has two parents or is its own ancestor")));
            }
            let to_world = parent * local(node);
            self.draw_node(number, node, &to_world)?;
            next.extend(node.children.iter().flatten().rev().map(|child| (child.value(), to_world)));
        }
        Ok(())
    }

    fn draw_node(&mut self, number: usize, node: &Node, to_world: &DMat4) -> Result<(), ImportError> {
        let name = match &node.name {
            Some(name) => format!("node {number} ({})", quoted(name)),
            None => format!("node {number}"),
        };
        if let Some(index) = node.mesh {
            if node.skin.is_some() {
                self.builder.not_drawn.insert("skins");
            }
            let parts = self.mesh(index)?;
            for to_world in self.instances(node, to_world)? {
                let to_world = to_world.as_mat4();
                for &(mesh, material) in parts.iter() {
                    self.builder.add_object(&name, mesh, material, to_world)?;
                }
            }
        }
        if let Some(index) = node.camera {
            let missing = || self.invalid(format!("{name} has a camera that is not there"));
            let source = self.root.get(index).ok_or_else(missing)?;
            match camera(source, to_world) {
                Some(camera) => self.cameras.push(crate::import::NamedCamera {
                    name: source.name.clone().or(node.name.clone()).unwrap_or_default(),
                    camera,
                }),
                None => self.builder.warn(format!("the camera of {name} is left out: it shows nothing")),
            }
        }
        let light = node.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref());
        if let Some(light) = light {
            let lights = self.root.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref());
            let source = lights.and_then(|lights| lights.lights.get(light.light.value()));
            let source =
                source.ok_or_else(|| self.invalid(format!("{name} has a light that is not there")))?;
            light::add(self.builder, source, to_world);
        }
        Ok(())
    }

    /// Where the node's mesh is: once, or as often as EXT_mesh_gpu_instancing says.
    fn instances(&self, node: &Node, to_world: &DMat4) -> Result<Vec<DMat4>, ImportError> {
        let extension = node.extensions.as_ref().and_then(|e| e.others.get("EXT_mesh_gpu_instancing"));
        let Some(attributes) = extension.and_then(|extension| extension.get("attributes")) else {
            return Ok(vec![*to_world]);
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
            *to_world * compose(three(&translations, i), rotation, three(&scales, i))
        };
        Ok((0..count).map(instance).collect())
    }
}

/// The node's own transform, in double precision: long chains multiply many.
fn local(node: &Node) -> DMat4 {
    match &node.matrix {
        Some(matrix) => DMat4::from_cols_array(&matrix.map(f64::from)),
        None => compose(node.translation, node.rotation.as_ref().map(|q| q.0), node.scale),
    }
}

/// Scaled, then turned, then moved.
fn compose(translation: Option<[f32; 3]>, rotation: Option<[f32; 4]>, scale: Option<[f32; 3]>) -> DMat4 {
    let vector = |v: [f32; 3]| DVec3::from(v.map(f64::from));
    let rotation = DQuat::from_array(rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]).map(f64::from));
    let length = libm::sqrt(rotation.length_squared());
    let rotation = if length > 0.0 { rotation * (1.0 / length) } else { DQuat::IDENTITY };
    DMat4::from_cols(
        (rotation * DVec3::X).extend(0.0),
        (rotation * DVec3::Y).extend(0.0),
        (rotation * DVec3::Z).extend(0.0),
        translation.map_or(DVec3::ZERO, vector).extend(1.0),
    ) * DMat4::from_scale(scale.map_or(DVec3::ONE, vector))
}

/// A camera at its node's place; none if it shows nothing. The aspect ratio is the frame's.
fn camera(source: &camera::Camera, to_world: &DMat4) -> Option<Camera> {
    let projection = match source.type_ {
        Checked::Valid(camera::Type::Perspective) => {
            Projection::Perspective { fov_y: source.perspective.as_ref()?.yfov }
        }
        Checked::Valid(camera::Type::Orthographic) => {
            Projection::Orthographic { height: 2.0 * source.orthographic.as_ref()?.ymag.abs() }
        }
        Checked::Invalid => return None,
    };
    let usable = match projection {
        Projection::Perspective { fov_y } => fov_y > 0.0 && fov_y < std::f32::consts::PI,
        Projection::Orthographic { height } => height > 0.0 && height.is_finite(),
    };
    let eye = to_world.w_axis.truncate();
    let up = to_world.y_axis.truncate().as_vec3();
    let forward = -to_world.z_axis.truncate();
    let length = libm::sqrt(forward.length_squared());
    // Far enough to be another point in single precision.
    let distance = eye.abs().max_element().max(1.0);
    let look_at = (eye + forward * (distance / length)).as_vec3();
    let across = up.cross(forward.as_vec3());
    let usable = usable && look_at.is_finite() && up.is_finite() && across != Vec3::ZERO;
    usable.then_some(Camera { eye: eye.as_vec3(), look_at, up, projection })
}

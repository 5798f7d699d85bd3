//! Where the scene of a file is, before anything of it is read.

use super::transform::{children, rest_worlds};
use crate::import::origin::{self, Bounds};
use glam::{DMat4, DVec3};
use gltf_json::mesh::Semantic;
use gltf_json::validation::Checked;
use gltf_json::{Accessor, Node, Root, Value};

/// What to subtract from the world of this file: see [`origin::origin`]. The eye is that of its first camera.
///
/// Bounds are those that accessors of positions state, placed by the nodes of the scene at rest. Of a mesh with a skin,
/// which joints place, they are the joints.
pub(super) fn origin(root: &Root) -> DVec3 {
    let worlds = rest_worlds(&root.nodes);
    let (mut objects, mut eye) = (Vec::new(), None);
    for (node, world) in drawn(root).map(|number| (&root.nodes[number], &worlds[number])) {
        let mut bounds = Bounds::NONE;
        if let Some(camera) = node.camera.map(|camera| camera.value()) {
            let is_first = eye.is_none_or(|(first, _)| camera < first);
            eye = if is_first { Some((camera, world.w_axis.truncate())) } else { eye };
        }
        let skin = node.skin.and_then(|skin| root.get(skin));
        match skin {
            Some(skin) => {
                let joints = skin.joints.iter().filter_map(|joint| worlds.get(joint.value()));
                joints.for_each(|joint| bounds.add(joint.w_axis.truncate()));
            }
            None => add_mesh(root, node, world, &mut bounds),
        }
        if bounds.low.cmple(bounds.high).all() {
            objects.push(bounds);
        }
    }
    origin::origin(&objects, eye.map(|(_, place)| place))
}

/// The numbers of nodes in the scene that is drawn, each once.
fn drawn(root: &Root) -> impl Iterator<Item = usize> {
    let scene = root.scene.and_then(|index| root.get(index)).or(root.scenes.first());
    let mut next: Vec<usize> = match scene {
        Some(scene) => scene.nodes.iter().map(|node| node.value()).collect(),
        None => (0..root.nodes.len()).collect(),
    };
    let mut is_visited = vec![false; root.nodes.len()];
    std::iter::from_fn(move || {
        loop {
            let number = next.pop()?;
            let Some(node) = root.nodes.get(number) else { continue };
            if !std::mem::replace(&mut is_visited[number], true) {
                next.extend(children(node));
                return Some(number);
            }
        }
    })
}

/// Takes in the corners of the mesh of a node.
fn add_mesh(root: &Root, node: &Node, world: &DMat4, bounds: &mut Bounds) {
    let mesh = node.mesh.and_then(|mesh| root.get(mesh));
    for primitive in mesh.iter().flat_map(|mesh| &mesh.primitives) {
        let positions = primitive.attributes.get(&Checked::Valid(Semantic::Positions));
        let Some(accessor) = positions.and_then(|index| root.get(*index)) else { continue };
        let (low, high) = (corner(accessor, &accessor.min), corner(accessor, &accessor.max));
        for number in 0..8 {
            let side = |bit: u32, axis: usize| if number >> bit & 1 == 0 { low[axis] } else { high[axis] };
            bounds.add(world.transform_point3(DVec3::new(side(0, 0), side(1, 1), side(2, 2))));
        }
    }
}

/// A corner of the bounds that an accessor states; 0 where it states none.
fn corner(accessor: &Accessor, values: &Option<Value>) -> [f64; 3] {
    // Of integers that are normalized, the numbers are not positions.
    let values = values.as_ref().filter(|_| !accessor.normalized).and_then(Value::as_array);
    let number = |axis: usize| values.and_then(|values| values.get(axis)).and_then(Value::as_f64);
    [0, 1, 2].map(|axis| number(axis).unwrap_or(0.0))
}

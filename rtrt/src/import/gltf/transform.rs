//! The transforms of nodes.

use crate::import::animation::Local;
use glam::{DMat4, DQuat, DVec3};
use gltf_json::{Index, Node};

/// The node's own transform.
pub(super) fn local(node: &Node) -> Local {
    match &node.matrix {
        Some(matrix) => Local::Matrix(DMat4::from_cols_array(&matrix.map(f64::from))),
        None => parts(node.translation, node.rotation.as_ref().map(|q| q.0), node.scale),
    }
}

/// Scaled, then turned, then moved.
pub(super) fn parts(
    translation: Option<[f32; 3]>,
    rotation: Option<[f32; 4]>,
    scale: Option<[f32; 3]>,
) -> Local {
    let vector = |v: [f32; 3]| DVec3::from(v.map(f64::from));
    Local::Parts {
        translation: translation.map_or(DVec3::ZERO, vector),
        rotation: DQuat::from_array(rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]).map(f64::from)),
        scale: scale.map_or(DVec3::ONE, vector),
    }
}

/// The way of each node to world space at rest. A node with several parents takes one of them.
pub(super) fn rest_worlds(nodes: &[Node]) -> Vec<DMat4> {
    let mut is_child = vec![false; nodes.len()];
    for child in nodes.iter().flat_map(children).filter(|&child| child < nodes.len()) {
        is_child[child] = true;
    }
    let mut worlds = vec![DMat4::IDENTITY; nodes.len()];
    let mut is_known = vec![false; nodes.len()];
    let mut next: Vec<(usize, DMat4)> =
        (0..nodes.len()).filter(|&node| !is_child[node]).map(|node| (node, DMat4::IDENTITY)).collect();
    while let Some((node, parent)) = next.pop() {
        if !std::mem::replace(&mut is_known[node], true) {
            worlds[node] = parent * local(&nodes[node]).matrix();
            let known = children(&nodes[node]).filter(|&child| child < nodes.len());
            next.extend(known.map(|child| (child, worlds[node])));
        }
    }
    worlds
}

/// The numbers of a node's children.
pub(super) fn children(node: &Node) -> impl Iterator<Item = usize> {
    node.children.iter().flatten().map(Index::value)
}

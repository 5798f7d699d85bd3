//! The transform of a node.

use crate::import::animation::Local;
use glam::{DMat4, DQuat, DVec3};
use gltf_json::Node;

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

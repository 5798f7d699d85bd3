//! The size of points and lines in meshes of glTF.

use super::accessor::one;
use super::transform::rest_worlds;
use crate::import::marks;
use glam::DVec3;
use gltf_json::mesh::{Mode, Primitive, Semantic};
use gltf_json::validation::Checked;
use gltf_json::{Root, Value};
use std::collections::HashMap;

/// Whether a primitive consists of points or lines.
pub(super) fn is_mark(primitive: &Primitive) -> bool {
    matches!(primitive.mode, Checked::Valid(Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip))
}

/// The diameters of points and lines, in the units of their meshes.
pub(super) struct MarkSizes {
    /// In the scene; none if the file does not state its bounds.
    diameter: Option<f64>,
    /// How much the first node of each mesh enlarges it at rest.
    scales: HashMap<usize, f64>,
}

impl MarkSizes {
    /// The bounds of the file at rest decide, as its accessors state them, unless a diameter is asked for.
    pub fn new(root: &Root, asked: Option<f32>) -> Self {
        let mut scales = HashMap::new();
        if !root.meshes.iter().flat_map(|mesh| &mesh.primitives).any(is_mark) {
            return Self { diameter: None, scales };
        }
        let mut corners = Vec::new();
        for (node, world) in root.nodes.iter().zip(rest_worlds(&root.nodes)) {
            let Some(index) = node.mesh else { continue };
            let scale = libm::cbrt(world.determinant().abs());
            scales.entry(index.value()).or_insert(if scale > 0.0 && scale.is_finite() { scale } else { 1.0 });
            for primitive in root.get(index).iter().flat_map(|mesh| &mesh.primitives) {
                let Some([low, high]) = bounds(root, primitive) else { continue };
                let pick =
                    |corner: u32, axis: usize| if corner >> axis & 1 == 0 { low[axis] } else { high[axis] };
                corners.extend((0..8).map(|corner| {
                    let at = DVec3::new(pick(corner, 0), pick(corner, 1), pick(corner, 2));
                    world.transform_point3(at).as_vec3().to_array()
                }));
            }
        }
        let is_known = asked.is_some() || !corners.is_empty();
        let (low, high) = marks::bounds(corners);
        Self { diameter: is_known.then(|| marks::diameter(asked, low, high)), scales }
    }

    /// The diameter in the units of the mesh with this number; none if it follows from the mesh alone.
    pub fn of(&self, mesh: usize) -> Option<f64> {
        Some(self.diameter? / self.scales.get(&mesh).copied().unwrap_or(1.0))
    }
}

/// The least and greatest position of a primitive, as its accessor states them.
fn bounds(root: &Root, primitive: &Primitive) -> Option<[[f64; 3]; 2]> {
    let accessor = root.get(*primitive.attributes.get(&Checked::Valid(Semantic::Positions))?)?;
    let unit = match accessor.component_type {
        Checked::Valid(component) if accessor.normalized => one(component.0),
        _ => 1.0,
    };
    let three = |value: &Option<Value>| {
        let numbers = value.as_ref()?.as_array()?;
        let number = |i: usize| numbers.get(i).and_then(Value::as_f64).map(|number| number / unit);
        Some([number(0)?, number(1)?, number(2)?])
    };
    Some([three(&accessor.min)?, three(&accessor.max)?])
}

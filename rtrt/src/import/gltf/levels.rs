//! Levels of detail of nodes: MSFT_lod.

use super::extensions::LOD;
use super::meshes::{Import, MeshParts};
use super::transform::local;
use crate::import::ImportError;
use crate::import::geometry::Geometry;
use gltf_json::camera::Type;
use gltf_json::validation::Checked;
use gltf_json::{Node, Value, deserialize};
use rtrt_core::scene::{InstanceIndex, Join, MaterialIndex, MeshIndex};

/// The aspect ratio of the picture that coverages refer to.
const ASPECT: f64 = 16.0 / 9.0;
/// The field of view of files without a perspective camera, radians: 45°.
const FOV_Y: f64 = core::f64::consts::FRAC_PI_4;

/// A lower level: the share of the picture below which it is drawn, and its primitives.
pub(super) type NodeLevel = (f64, MeshParts);

/// The numbers of a node's lower levels, which are nodes.
pub(super) fn ids(node: &Node) -> Vec<usize> {
    let extension = node.extensions.as_ref().and_then(|extensions| extensions.others.get(LOD));
    let ids = extension.and_then(|extension| extension.get("ids")?.as_array());
    ids.into_iter().flatten().map(|id| id.as_u64().map_or(usize::MAX, |id| id as usize)).collect()
}

/// The least share of a picture that each level of a node covers.
fn coverages(node: &Node) -> Vec<f64> {
    let extras = node.extras.as_ref().and_then(|extras| deserialize::from_str::<Value>(extras.get()).ok());
    let shares = extras.as_ref().and_then(|extras| extras.get("MSFT_screencoverage")?.as_array());
    shares.into_iter().flatten().map(|share| share.as_f64().unwrap_or(0.0)).collect()
}

impl<J: Join> Import<'_, '_, J> {
    /// The lower levels of a node with these primitives. A level that cannot replace the node is left out
    /// with a warning. `name` is for messages.
    pub fn levels(
        &mut self,
        name: &str,
        node: &Node,
        parts: &MeshParts,
    ) -> Result<Vec<NodeLevel>, ImportError> {
        let (ids, shares, mut levels) = (ids(node), coverages(node), Vec::new());
        let mut before = 1.0;
        for (number, &id) in ids.iter().enumerate() {
            before = match shares.get(number) {
                Some(&share) if share > 0.0 => share,
                _ => before / 4.0,
            };
            let missing = || self.invalid(format!("{name} has a level of detail that is not there"));
            let level = self.root.nodes.get(id).ok_or_else(missing)?;
            match self.level(node, level, parts.len())? {
                Ok(parts) => levels.push((before, parts)),
                Err(why) => {
                    self.builder.warn(format!("level of detail {number} of {name} is left out: {why}"))
                }
            }
        }
        // Nothing is drawn below the share of the last level.
        if let Some(&last) = shares.get(ids.len()).filter(|&&share| share > 0.0) {
            let nothing = self.builder.add_mesh(name, Geometry::default())?;
            levels.push((last, parts.iter().map(|&(_, material)| (nothing, material)).collect()));
        }
        Ok(levels)
    }

    /// The primitives of a level, or why it cannot replace its node.
    fn level(
        &mut self,
        node: &Node,
        level: &Node,
        parts: usize,
    ) -> Result<Result<MeshParts, &'static str>, ImportError> {
        let Some(index) = level.mesh else { return Ok(Err("it has no mesh of its own")) };
        if level.children.as_ref().is_some_and(|children| !children.is_empty()) {
            return Ok(Err("it has children"));
        }
        if local(level).matrix() != local(node).matrix() {
            return Ok(Err("it is placed elsewhere"));
        }
        if level.skin.is_some() || self.source(index)?.primitives.iter().any(|p| p.targets.is_some()) {
            return Ok(Err("it changes its shape"));
        }
        let found = self.mesh(index)?;
        Ok(if found.len() == parts { Ok(found) } else { Err("it has another number of primitives") })
    }

    /// Gives an instance, which is a primitive of a node, that primitive's levels.
    pub fn set_levels(
        &mut self,
        object: InstanceIndex,
        part: usize,
        levels: &[NodeLevel],
    ) -> Result<(), ImportError> {
        let Some(placed) = self.builder.scene.instances().get(object.number() as usize) else {
            return Ok(());
        };
        let size = placed.high.iter().zip(placed.low).map(|(high, low)| f64::from(high - low));
        let radius = 0.5 * libm::sqrt(size.map(|side| side * side).sum());
        let fov_y = self.root.cameras.iter().find_map(|camera| match camera.type_ {
            Checked::Valid(Type::Perspective) => Some(f64::from(camera.perspective.as_ref()?.yfov)),
            _ => None,
        });
        let fov_y = fov_y.filter(|angle| (1e-3..3.1).contains(angle)).unwrap_or(FOV_Y);
        let level = |(coverage, parts): &NodeLevel| -> (f32, MeshIndex, MaterialIndex) {
            let (mesh, material) = parts[part];
            (distance(*coverage, radius, fov_y) as f32, mesh, material)
        };
        let levels: Vec<_> = levels.iter().map(level).filter(|(from, ..)| *from > 0.0).collect();
        let set = self.builder.scene.set_levels_with(object, &levels);
        set.map_err(|source| ImportError::Scene { path: self.builder.path.clone(), source })
    }
}

/// The distance to the surface of a ball that covers this share of a picture.
///
/// ```text
/// share = π r² / (4 · d² · tan²(fov / 2) · aspect)
/// ```
///
/// `d` is the distance of its center; levels are chosen by the distance of bounds.
fn distance(share: f64, radius: f64, fov_y: f64) -> f64 {
    let tangent = libm::tan(fov_y * 0.5);
    let middle = radius / tangent * libm::sqrt(core::f64::consts::PI / (4.0 * ASPECT * share));
    (middle - radius).max(radius / 1024.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ball_at_the_distance_covers_the_share() {
        for (share, radius, fov_y) in [(0.5, 2.0, FOV_Y), (0.01, 0.3, 1.2), (0.2, 1e6, 0.4)] {
            let away = distance(share, radius, fov_y);
            if away > radius / 1000.0 {
                let height = (away + radius) * 2.0 * libm::tan(fov_y * 0.5);
                let found = core::f64::consts::PI * radius * radius / (height * height * ASPECT);
                assert!((found - share).abs() < 1e-9, "{found} {share}");
            }
        }
        // A level that fills the picture has a distance above 0.
        assert_eq!(distance(1.0, 1024.0, 3.0), 1.0);
        assert!(distance(0.2, 1.0, FOV_Y) < distance(0.1, 1.0, FOV_Y));
    }
}

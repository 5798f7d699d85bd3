//! The offsets at which a device reads the fields of shared records.

use crate::layout::{Attribute, Frame, Hit, Instance, MaterialRecord, Node, Surface, View};

/// The number of words of [`probe`].
pub const PROBES: usize = 33;

/// Fields of the frame and of the second element of each slice, as words. In buffers whose words hold their
/// own index, the result shows the offset and the stride that a device uses for each field.
#[inline(always)]
#[allow(clippy::too_many_arguments, reason = "one slice for each layout that is probed")]
pub fn probe(
    frame: &Frame,
    views: &[View],
    instances: &[Instance],
    nodes: &[Node],
    attributes: &[Attribute],
    materials: &[MaterialRecord],
    surfaces: &[Surface],
    hits: &[Hit],
) -> [u32; PROBES] {
    let (view, instance, node) = (&views[1], &instances[1], &nodes[1]);
    let (attribute, material) = (&attributes[1], &materials[1]);
    let (surface, hit) = (&surfaces[1], &hits[1]);
    [
        frame.width,
        frame.rays,
        frame.magnitude.to_bits(),
        frame.layers,
        frame.penumbra_window,
        frame.backdrop,
        view.center[0].to_bits(),
        view.kind,
        view.depth[2].to_bits(),
        view.first_block,
        view.reach_squared.to_bits(),
        view.jitter,
        instance.to_object[0][0].to_bits(),
        instance.to_world[2][3].to_bits(),
        instance.root,
        instance.center[1].to_bits(),
        instance.slack.to_bits(),
        instance.kind,
        instance.opened_from,
        instance.double_sided,
        node.first,
        node.kind,
        attribute.normal[0].to_bits(),
        attribute.color[1],
        material.specular[0].to_bits(),
        material.cutoff.to_bits(),
        material.double_sided,
        material.textures[0].first,
        material.textures[4].shift[1].to_bits(),
        surface.material,
        surface.footprint.to_bits(),
        hit.t.to_bits(),
        hit.v.to_bits(),
    ]
}

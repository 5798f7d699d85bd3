//! The order of a frame: the sequence of its steps, the unit that each works on, and the barriers where
//! all blocks wait for one another.
//!
//! A backend is a loop over [`steps`]. It decides where and when each of them runs:
//!
//! ```
//! use bytemuck::Zeroable;
//! use rtrt_core::layout::Frame;
//! use rtrt_core::schedule::{Pass, Stage, Unit, steps};
//!
//! let frame = Frame { width: 32, height: 16, side: 1, rays: 512, lights: 2, views: 1, ..Frame::zeroed() };
//! let occlusion = steps(&frame).find(|step| step.pass == Pass::Occlusion).unwrap();
//! assert_eq!(occlusion.unit(), Unit::RayAndLight);
//! assert_eq!(occlusion.unit().count(&frame), [512, 2]);
//! assert_eq!(steps(&frame).last().unwrap().stage(), Stage::Resolve);
//! ```

use crate::grid::{BLOCK_RAYS, RayIndex};
use crate::layout::{Frame, ShadowKind};
use crate::stage::prepare;

/// The stages of a frame, in order, as timings name them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// The bounds of instances on the screen.
    Prepare,
    /// The lists of blocks.
    Bin,
    /// The closest surfaces.
    Visibility,
    /// Their geometry and materials.
    Surface,
    /// Normal maps and second texture coordinates.
    Detail,
    /// The lights that reach them.
    Occlusion,
    /// The light that arrives.
    Light,
    /// The color that goes to the camera.
    Shade,
    /// All passes over the surfaces behind the first.
    Layers,
    /// Pixels.
    Resolve,
}

impl Stage {
    /// The number of stages.
    pub const COUNT: usize = Self::Resolve as usize + 1;

    /// All of them, in order.
    pub const ALL: [Self; Self::COUNT] = [
        Self::Prepare,
        Self::Bin,
        Self::Visibility,
        Self::Surface,
        Self::Detail,
        Self::Occlusion,
        Self::Light,
        Self::Shade,
        Self::Layers,
        Self::Resolve,
    ];

    /// Its name in reports.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Prepare => "prepare",
            Self::Bin => "bin",
            Self::Visibility => "visibility",
            Self::Surface => "surface",
            Self::Detail => "detail",
            Self::Occlusion => "occlusion",
            Self::Light => "light",
            Self::Shade => "shade",
            Self::Layers => "layers",
            Self::Resolve => "resolve",
        }
    }
}

/// The work of a step: a function of [`stage`](crate::stage) for every unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pass {
    /// The bounds of instances in views.
    Prepare,
    /// The list of each block, from these bounds.
    Bin,
    /// The surfaces that a rasterizer has drawn, in frames where [`Frame::is_drawn`] is 1. [`Pass::Peel`]
    /// then traces the rays whose pixels identify no surface.
    Pick,
    /// The closest surface on each ray, in frames without transparency and without a near plane.
    Visibility,
    /// Ends the rays that the layers so far cover.
    EndCovered,
    /// The closest surface behind the last one; in the first layer, where the last hit is at 0, the
    /// closest of all.
    Peel,
    /// Which sub-rays of a pixel are shaded, in frames where [`Frame::is_shared`] is 1.
    Share,
    /// The geometry and material of a surface.
    Surface,
    /// Normal maps and second texture coordinates.
    Detail,
    /// One bit a light.
    Occlusion,
    /// The share of a light that reaches a surface, a color.
    Transmittance,
    /// The same, with the radius of the penumbra.
    BlockerSearch,
    /// A summary of the penumbras of a block.
    SummarizePenumbras,
    /// Whether the filter may change a block.
    SelectFilterBlocks,
    /// The transmittance, blurred by the radii of penumbras.
    FilterPenumbra,
    /// The shadow mask that follows from the transmittance. Only the deferred buffers hold it.
    Mask,
    /// How much of the light from all around reaches a surface.
    Ambient,
    /// The light that arrives at a surface.
    Light,
    /// The color of the first layer.
    Shade,
    /// The color of a layer, added to those in front of it.
    Blend,
    /// The colors of pixels.
    Resolve,
}

/// The unit of a step: it runs once for each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// An instance in a view.
    Bounds,
    /// A block of a view.
    List,
    /// A ray.
    Ray,
    /// A ray and a light.
    RayAndLight,
    /// A block of the camera and a light.
    BlockAndLight,
    /// A pixel.
    Pixel,
}

impl Unit {
    /// The number of units of a frame (of rays and pixels, those of a dispatch), and the number of lights
    /// for each.
    pub fn count(self, frame: &Frame) -> [u32; 2] {
        match self {
            Self::Bounds => [prepare::count(frame), 1],
            Self::List => [frame.blocks, 1],
            Self::Ray => [frame.rays, 1],
            Self::RayAndLight => [frame.rays, frame.lights],
            Self::BlockAndLight => [frame.rays / BLOCK_RAYS, frame.lights],
            Self::Pixel => [frame.grid().pixels(RayIndex(frame.first_ray), frame.rays)[1], 1],
        }
    }
}

/// A pass over one layer of surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Step {
    /// Its work.
    pub pass: Pass,
    /// The number of layers in front; its frame is [`Frame::of_layer`].
    pub layer: u32,
}

impl Step {
    /// The stage that its time counts for.
    pub fn stage(self) -> Stage {
        match self.pass {
            Pass::Prepare => Stage::Prepare,
            Pass::Bin => Stage::Bin,
            Pass::Resolve => Stage::Resolve,
            _ if self.layer > 0 => Stage::Layers,
            Pass::Pick | Pass::Visibility | Pass::EndCovered | Pass::Peel | Pass::Share => Stage::Visibility,
            Pass::Surface => Stage::Surface,
            Pass::Detail => Stage::Detail,
            Pass::Occlusion
            | Pass::Transmittance
            | Pass::BlockerSearch
            | Pass::SummarizePenumbras
            | Pass::SelectFilterBlocks
            | Pass::FilterPenumbra
            | Pass::Mask
            | Pass::Ambient => Stage::Occlusion,
            Pass::Light => Stage::Light,
            Pass::Shade | Pass::Blend => Stage::Shade,
        }
    }

    /// The unit that it runs once for.
    pub fn unit(self) -> Unit {
        match self.pass {
            Pass::Prepare => Unit::Bounds,
            Pass::Bin => Unit::List,
            Pass::Occlusion | Pass::Transmittance | Pass::BlockerSearch | Pass::FilterPenumbra => {
                Unit::RayAndLight
            }
            Pass::SummarizePenumbras | Pass::SelectFilterBlocks => Unit::BlockAndLight,
            Pass::Share | Pass::Resolve => Unit::Pixel,
            _ => Unit::Ray,
        }
    }

    /// Whether it reads results of other blocks, so that all blocks must have finished the steps before.
    ///
    /// From one barrier to the next, blocks are independent. A backend that runs them one by one lets
    /// neighbors read a copy, since some blocks are ahead of others.
    pub fn has_barrier(self) -> bool {
        match self.pass {
            Pass::Bin | Pass::Pick | Pass::Visibility => true,
            Pass::Peel => self.layer == 0,
            Pass::SelectFilterBlocks | Pass::FilterPenumbra => true,
            _ => false,
        }
    }
}

/// The passes over a layer of surfaces, in order. No layer has all of them.
const LAYER: [Pass; 18] = [
    Pass::EndCovered,
    Pass::Pick,
    Pass::Visibility,
    Pass::Peel,
    Pass::Share,
    Pass::Surface,
    Pass::Detail,
    Pass::Occlusion,
    Pass::Transmittance,
    Pass::BlockerSearch,
    Pass::SummarizePenumbras,
    Pass::SelectFilterBlocks,
    Pass::FilterPenumbra,
    Pass::Mask,
    Pass::Ambient,
    Pass::Light,
    Pass::Shade,
    Pass::Blend,
];

impl Step {
    /// Whether a layer of the frame has it.
    fn is_in(self, frame: &Frame) -> bool {
        let (shadows, is_first) = (frame.shadow_kind(), self.layer == 0);
        let is_drawn = is_first && frame.is_drawn == 1;
        match self.pass {
            Pass::Pick => is_drawn,
            Pass::Visibility => !is_drawn && !frame.is_peeled(),
            Pass::Peel => is_drawn || frame.is_peeled(),
            Pass::Share => is_first && frame.is_shared == 1,
            Pass::Detail => frame.details == 1,
            Pass::Occlusion => shadows == ShadowKind::Bits,
            Pass::Transmittance => shadows == ShadowKind::Transmittance,
            Pass::BlockerSearch
            | Pass::SummarizePenumbras
            | Pass::SelectFilterBlocks
            | Pass::FilterPenumbra => shadows == ShadowKind::Penumbra,
            Pass::Mask => is_first && shadows != ShadowKind::Bits,
            Pass::Ambient => frame.has_ambient_rays(),
            Pass::Shade => is_first,
            Pass::EndCovered | Pass::Blend => !is_first,
            _ => true,
        }
    }
}

/// The steps of a frame, in order.
pub fn steps(frame: &Frame) -> impl Iterator<Item = Step> + use<> {
    let frame = *frame;
    let step = |pass| Step { pass, layer: 0 };
    let of_layer = move |layer| {
        LAYER.into_iter().map(move |pass| Step { pass, layer }).filter(move |step| step.is_in(&frame))
    };
    let lists = [Pass::Prepare, Pass::Bin].into_iter().map(step);
    lists.chain((0..=frame.layers_behind()).flat_map(of_layer)).chain([step(Pass::Resolve)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;
    use std::vec::Vec;

    fn frames() -> impl Iterator<Item = Frame> {
        let frame = |number: u32| Frame {
            layers: 3 * (number & 1),
            penumbra_window: 24 * (number >> 1 & 1),
            details: number >> 2 & 1,
            is_drawn: number >> 3 & 1,
            near: (number >> 4 & 1) as f32,
            ambient_view: number >> 5,
            ..Frame::zeroed()
        };
        (0..64).map(frame)
    }

    #[test]
    fn stages_are_named_and_in_order() {
        assert!((0..).zip(Stage::ALL).all(|(number, stage)| stage as usize == number));
        for frame in frames() {
            let stages: Vec<_> = steps(&frame).map(|step| step.stage() as usize).collect();
            assert!(stages.is_sorted(), "{stages:?}");
        }
    }

    #[test]
    fn every_layer_finds_lights_and_shades_once() {
        for frame in frames() {
            for layer in 0..=frame.layers_behind() {
                let count = |passes: &[Pass]| {
                    steps(&frame).filter(|step| step.layer == layer && passes.contains(&step.pass)).count()
                };
                assert_eq!(count(&[Pass::Visibility, Pass::Pick, Pass::EndCovered]).max(1), 1);
                assert!(count(&[Pass::Visibility, Pass::Peel]) == 1);
                assert_eq!(count(&[Pass::Occlusion, Pass::Transmittance, Pass::BlockerSearch]), 1);
                assert_eq!(count(&[Pass::Shade, Pass::Blend]), 1);
                assert_eq!(count(&[Pass::FilterPenumbra]), count(&[Pass::BlockerSearch]));
            }
        }
    }

    #[test]
    fn only_soft_shadows_make_blocks_wait_behind_the_lists() {
        let barriers = |frame: &Frame| steps(frame).filter(|step| step.has_barrier()).count();
        let frame = Frame { layers: 3, ..Frame::zeroed() };
        assert_eq!(barriers(&frame), 2);
        assert_eq!(barriers(&Frame { penumbra_window: 24, ..frame }), 2 + 2 * 3);
    }

    #[test]
    fn layers_count_down_to_the_opaque_one() {
        let frame = Frame { layers: 3, is_drawn: 1, ..Frame::zeroed() };
        assert_eq!(steps(&frame).map(|step| step.layer).max(), Some(2));
        assert_eq!((frame.of_layer(2).layers, frame.of_layer(2).is_drawn), (1, 0));
    }
}

//! Beyond: where the light comes from that reaches a ray through all that lets light through.
//!
//! Surfaces behind glass are found along the straight ray, and are sharp. Only the environment, behind all of them, is
//! looked up where bodies have turned the light from, and as blurred as rough glass leaves it.

use crate::kernel::refraction::{exit_normal, refracted};
use crate::lane::{Lane, Mask, Select, V3};
use crate::layout::Frame;
use crate::num::{flush, normalize, recip, sqrt};

/// What is known of it behind the layers so far.
#[derive(Clone, Copy)]
pub struct Beyond<L> {
    /// Toward where it comes from, of any length above 0.
    pub direction: V3<L>,
    /// The sum of the squares of the widths of all lobes that have scattered it, 0 ..= 1.
    spread: L,
    /// The normal of the surface at which the ray entered the body that it is in.
    entry: V3<L>,
    /// 1 inside of a body, 0 outside.
    inside: L,
}

/// A surface that lets light through.
#[derive(Clone, Copy)]
pub struct Pane<L> {
    /// Unit length, toward the viewer.
    pub normal: V3<L>,
    /// 0 ..= 1.
    pub roughness: L,
    /// Of the body that it bounds; 1 for a thin pane.
    pub refraction: L,
}

impl<L: Lane> Beyond<L> {
    /// Before the first layer: along the ray.
    #[inline(always)]
    pub fn new(direction: V3<L>) -> Self {
        let none = direction.x.broadcast(0.0);
        Self { direction, spread: none, entry: V3 { x: none, y: none, z: none }, inside: none }
    }

    /// That of the records of a ray in this direction; they count in frames that keep them.
    #[inline(always)]
    pub fn load(frame: &Frame, direction: V3<L>, [toward, entry]: [[L; 4]; 2]) -> Self {
        if !frame.has_deflecting_layers() {
            return Self::new(direction);
        }
        Self {
            direction: V3 { x: toward[0], y: toward[1], z: toward[2] },
            spread: toward[3],
            entry: V3 { x: entry[0], y: entry[1], z: entry[2] },
            inside: entry[3],
        }
    }

    /// The records of it.
    #[inline(always)]
    pub fn records(&self) -> [[L; 4]; 2] {
        let Self { direction, spread, entry, inside } = self;
        [[direction.x, direction.y, direction.z, *spread], [entry.x, entry.y, entry.z, *inside]]
    }

    /// Either, lane by lane.
    #[inline(always)]
    pub fn select(mask: L::Mask, if_true: Self, if_false: Self) -> Self {
        Self {
            direction: V3::select(mask, if_true.direction, if_false.direction),
            spread: mask.select(if_true.spread, if_false.spread),
            entry: V3::select(mask, if_true.entry, if_false.entry),
            inside: mask.select(if_true.inside, if_false.inside),
        }
    }

    /// How rough a mirror is that scatters light as much:
    ///
    /// ```text
    /// (Σ α²)^¼
    /// ```
    #[inline(always)]
    pub fn roughness(&self) -> L {
        sqrt(sqrt(self.spread))
    }

    /// The same behind a pane, where `clear` says that there is one.
    ///
    /// ```text
    /// spread' = min(spread + α², 1),   α = (roughness · s)²
    /// s = 1 of a thin pane, min(2 · refraction − 2, 1) of a body
    /// ```
    ///
    /// Light turns where it enters a body and where it leaves it (see `kernel::refraction`). The lobe is as
    /// wide as that of what is mirrored, and narrower where there is little refraction, as in the Khronos sample
    /// renderer. A body ends at the next surface of one: bodies in bodies are not told apart.
    #[inline(always)]
    pub fn through(&self, clear: L::Mask, pane: &Pane<L>) -> Self {
        let one = pane.roughness.broadcast(1.0);
        let bends = clear & pane.refraction.gt(one);
        let scatter = bends.select((pane.refraction * 2.0 - 2.0).min(one), one);
        let width = pane.roughness * scatter;
        let square = flush(width * width);
        let spread = (self.spread + flush(square * square)).min(one);
        let mut next = Self { spread: clear.select(spread, self.spread), ..*self };
        if !bends.any() {
            return next;
        }
        let inverse = recip(pane.refraction);
        let incident = normalize(self.direction);
        let leaves = self.inside.gt(one.broadcast(0.0));
        let into = refracted(incident, pane.normal, inverse);
        let exit = exit_normal(self.entry, pane.normal, inverse);
        let out = refracted(incident, exit, pane.refraction);
        next.direction = V3::select(bends, V3::select(leaves, out, into), self.direction);
        next.entry = V3::select(bends, pane.normal, self.entry);
        next.inside = bends.select(one - self.inside, self.inside);
        next
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::MaterialRecord;
    use bytemuck::Zeroable;

    fn at(v: [f32; 3]) -> V3<f32> {
        V3::splat((), v)
    }

    fn pane(normal: [f32; 3], roughness: f32, refraction: f32) -> Pane<f32> {
        Pane { normal: at(normal), roughness, refraction }
    }

    const AHEAD: [f32; 3] = [0.0, 0.0, -1.0];

    #[test]
    fn lobes_add_up() {
        let rough = pane([0.0, 0.0, 1.0], 0.5, 1.0);
        let once = Beyond::new(at(AHEAD)).through(true, &rough);
        assert!((once.roughness() - 0.5).abs() < 1e-5 && once.direction.lane(0) == AHEAD);
        let twice = once.through(true, &rough);
        assert!((twice.roughness() - (2.0_f32 * 0.0625).powf(0.25)).abs() < 1e-5);
        let matte = twice.through(true, &pane([0.0, 0.0, 1.0], 1.0, 1.0));
        assert!((matte.roughness() - 1.0).abs() < 1e-5);
        // What is no pane changes nothing.
        assert_eq!(once.through(false, &rough).records(), once.records());
        // Little refraction scatters little: half of the width, a quarter of α.
        let body = Beyond::new(at(AHEAD)).through(true, &pane([0.0, 0.0, 1.0], 0.5, 1.25));
        assert!((body.roughness() - 0.25).abs() < 1e-5);
    }

    #[test]
    fn a_body_turns_light_at_both_of_its_sides() {
        let (sin, cos) = 0.5_f32.sin_cos();
        let (front, back) = (pane([sin, 0.0, cos], 0.0, 1.5), pane([-sin, 0.0, cos], 0.0, 1.5));
        let inside = Beyond::new(at(AHEAD)).through(true, &front);
        let out = inside.through(true, &back);
        let angle = f64::from(-out.direction.x).atan2(f64::from(-out.direction.z));
        let exact = 2.0 * (0.5 - (0.5_f64.sin() / 1.5).asin());
        assert!((angle - exact).abs() < 1e-4, "{angle} {exact}");
        // A ball behind the first one turns it again.
        let again = out.through(true, &front);
        assert!(again.records()[1][3] == 1.0 && again.direction.lane(0) != out.direction.lane(0));
    }

    #[test]
    fn records_keep_it() {
        let extensions = MaterialRecord::TRANSMITS | MaterialRecord::DEFLECTS;
        let frame = Frame { layers: 3, extensions, ..Frame::zeroed() };
        let inside = Beyond::new(at(AHEAD)).through(true, &pane([0.6, 0.0, 0.8], 0.5, 1.5));
        let loaded = Beyond::load(&frame, at([1.0, 0.0, 0.0]), inside.records());
        assert_eq!(loaded.records(), inside.records());
        let plain = Frame { extensions: MaterialRecord::TRANSMITS, ..frame };
        assert_eq!((frame.records(), plain.records()), (4, 2));
        assert_eq!(Beyond::load(&plain, at(AHEAD), inside.records()).direction.lane(0), AHEAD);
    }
}

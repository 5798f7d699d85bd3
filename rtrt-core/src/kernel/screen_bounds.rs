//! Bounds on the screen: the blocks of a view that an instance may cover.

use crate::kernel::view::cell;
use crate::layout::{Instance, View, ViewKind};
use crate::num::recip;
use bytemuck::{Pod, Zeroable};

/// The rectangle of blocks that an instance's box covers in one view.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct ScreenBounds {
    /// First column.
    pub x0: u32,
    /// First row.
    pub y0: u32,
    /// The column after the last; not above `x0` for an instance that is not in the view.
    pub x1: u32,
    /// The row after the last.
    pub y1: u32,
    /// Bits of a depth that no hit on the instance is in front of; 0 for lights.
    pub key: u32,
}
const _: () = assert!(size_of::<ScreenBounds>() == 20);

impl ScreenBounds {
    /// Nothing.
    pub const NONE: Self = Self { x0: 0, y0: 0, x1: 0, y1: 0, key: 0 };
}

/// How much a cover is wider than its (widened) box, in blocks: more than the roundings of
/// a ray's own direction and of a column or row below 2¹¹.
const MARGIN: f32 = 1.0 / 256.0;

/// Relative slack of a depth: more than the roundings that lead to a key and to a `t`.
const SLACK: f32 = 1.0 / 65536.0;

/// The smallest and the largest of a linear function over a box.
#[derive(Clone, Copy)]
struct Range {
    low: f32,
    high: f32,
}

/// A box, as seen from a view's center.
#[derive(Clone, Copy)]
struct Extent {
    low: [f32; 3],
    high: [f32; 3],
}

/// The range of `row · p` over the box.
#[inline(always)]
fn range(row: &[f32; 3], around: &Extent) -> Range {
    let mut sum = Range { low: 0.0, high: 0.0 };
    let mut axis = 0;
    while axis < 3 {
        let a = row[axis] * around.low[axis];
        let b = row[axis] * around.high[axis];
        sum.low += if a < b { a } else { b };
        sum.high += if a < b { b } else { a };
        axis += 1;
    }
    sum
}

/// The blocks of `view` that the box of `instance` covers, and its key. The box is widened
/// by the rounding errors of tracing in a frame of this magnitude.
///
/// It is also widened by the view's margin. A ray from a surface `p` to the point `c + r` of an
/// area light around `c` is, at the share `s` of its way, `s · r` off the line from `p` to `c`; so
/// what it meets there is met, so widened, by that line, and is in the list of the block that `p`
/// lies in. For a sun, `r` is what the whole scene's size makes of the directions' difference.
///
/// Where the whole box is in front of the view, its eight corners are projected. Where it
/// crosses the view's plane, each column `k` is kept unless the box is outside of one of
/// its two planes, `X − kW` and `X − (k + 1)W`; likewise the rows. Neither divides by a
/// `W` near 0, and both keep at least every block that a ray meets the box in.
#[inline(always)]
pub fn screen_bounds(view: &View, instance: &Instance, magnitude: f32) -> ScreenBounds {
    if view.one_list == 1 && view.kind != ViewKind::Off as u32 {
        return ScreenBounds { x0: 0, y0: 0, x1: 1, y1: 1, key: 0 };
    }
    let (low, high) = instance.padded_aabb(magnitude);
    let (c, m) = (&view.center, view.margin);
    let around = Extent {
        low: [low[0] - c[0] - m, low[1] - c[1] - m, low[2] - c[2] - m],
        high: [high[0] - c[0] + m, high[1] - c[1] + m, high[2] - c[2] + m],
    };
    if view.kind == ViewKind::Off as u32 || out_of_reach(view, &around) {
        return ScreenBounds::NONE;
    }
    let w = range(&view.w, &around);
    let w = Range { low: w.low + view.w_offset, high: w.high + view.w_offset };
    let depth = range(&view.depth, &around);
    let is_camera = view.kind == ViewKind::Camera as u32;
    if w.high <= 0.0 || (is_camera && depth.high <= 0.0) {
        return ScreenBounds::NONE;
    }
    let [x0, x1] = columns(&view.x, view.width, view, &around, w);
    let [y0, y1] = columns(&view.y, view.height, view, &around, w);
    let key = depth.low - (depth.high - depth.low + depth.high) * SLACK;
    let key = if is_camera && key > 0.0 { key.to_bits() } else { 0 };
    if x1 <= x0 || y1 <= y0 { ScreenBounds::NONE } else { ScreenBounds { x0, y0, x1, y1, key } }
}

/// The first column and the one after the last; with the row `y` and the height, rows.
#[inline(always)]
fn columns(axis: &[f32; 3], count: u32, view: &View, around: &Extent, w: Range) -> [u32; 2] {
    if w.low * 1024.0 > w.high {
        let (mut low, mut high) = (f32::MAX, -f32::MAX);
        let mut corner = 0_u32;
        while corner < 8 {
            let c = projected(axis, view, around, corner);
            low = if c < low { c } else { low };
            high = if c > high { c } else { high };
            corner += 1;
        }
        low -= MARGIN;
        high += MARGIN;
        if high < 0.0 || low >= count as f32 {
            return [0, 0];
        }
        return [cell(low, count).0, cell(high, count).0 + 1];
    }
    let mut first = 0;
    while first < count && outside(axis, first, view, around) {
        first += 1;
    }
    let mut last = count;
    while last > first && outside(axis, last - 1, view, around) {
        last -= 1;
    }
    [first, last]
}

/// Column of one corner of the box; its bits choose low or high per axis.
#[inline(always)]
fn projected(axis: &[f32; 3], view: &View, around: &Extent, corner: u32) -> f32 {
    let (mut x, mut w) = (0.0, view.w_offset);
    let mut i = 0;
    while i < 3 {
        let offset = if corner >> i & 1 == 1 { around.high[i] } else { around.low[i] };
        x += axis[i] * offset;
        w += view.w[i] * offset;
        i += 1;
    }
    x * recip(w)
}

/// Whether the box is on the far side of the plane at one edge of the column.
#[inline(always)]
fn outside(axis: &[f32; 3], column: u32, view: &View, around: &Extent) -> bool {
    let plane = |edge: f32| {
        let row = [axis[0] - edge * view.w[0], axis[1] - edge * view.w[1], axis[2] - edge * view.w[2]];
        let inside = range(&row, around);
        Range { low: inside.low - edge * view.w_offset, high: inside.high - edge * view.w_offset }
    };
    plane(column as f32 - MARGIN).high < 0.0 || plane(column as f32 + 1.0 + MARGIN).low > 0.0
}

/// Whether the whole box is beyond the light's reach.
#[inline(always)]
fn out_of_reach(view: &View, around: &Extent) -> bool {
    let mut squared = 0.0;
    let mut i = 0;
    while i < 3 {
        let below = around.low[i];
        let above = -around.high[i];
        let gap = if below > above { below } else { above };
        squared += if gap > 0.0 { gap * gap } else { 0.0 };
        i += 1;
    }
    squared > view.reach_squared
}

/// Relative slack of the sphere test, far above its roundings.
const WIDER: f32 = 1.0 + 1.0 / 1024.0;

/// Whether a ray of the block at `column` and `row` can meet the instance's bounding sphere.
///
/// The block's rays stay within `spread + spread_w · W` of its middle ray. A sphere is out
/// of their way when the middle ray passes it at a greater distance than that, at the
/// sphere's far end, plus the radius:
///
/// ```text
/// |(c − o) × d|² > (radius + spread + spread_w · (W(c) + radius · |w|))² · |d|²
/// ```
///
/// The paper tests the sphere for each ray; here one test serves a block.
#[inline(always)]
pub(crate) fn sphere_in_block(
    view: &View,
    instance: &Instance,
    magnitude: f32,
    column: u32,
    row: u32,
) -> bool {
    if view.one_list == 1 {
        return true;
    }
    let radius = instance.radius + 2.0 * instance.slack * magnitude + view.margin;
    let (a, b) = (column as f32 + 0.5, row as f32 + 0.5);
    let at =
        |base: &[f32; 3], by_a: &[f32; 3], by_b: &[f32; 3], i: usize| base[i] + a * by_a[i] + b * by_b[i];
    let start = |i: usize| view.center[i] + at(&view.start, &view.start_x, &view.start_y, i);
    let along = |i: usize| at(&view.along, &view.along_x, &view.along_y, i);
    let c = [instance.center[0] - start(0), instance.center[1] - start(1), instance.center[2] - start(2)];
    let d = [along(0), along(1), along(2)];
    let x = [c[1] * d[2] - c[2] * d[1], c[2] * d[0] - c[0] * d[2], c[0] * d[1] - c[1] * d[0]];
    let dot = |p: &[f32; 3], q: &[f32; 3]| p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
    let to_center = [
        instance.center[0] - view.center[0],
        instance.center[1] - view.center[1],
        instance.center[2] - view.center[2],
    ];
    let far_end = dot(&view.w, &to_center) + radius;
    let far_end = if far_end > 0.0 { far_end } else { 0.0 };
    let reach = (radius + view.spread + view.spread_w * far_end) * WIDER;
    dot(&x, &x) <= reach * reach * dot(&d, &d) * WIDER
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    /// A camera at (0, 0, 5) that looks along −z, with a picture of 8 by 8 blocks whose edges are at 45
    /// degrees: a point lies in column 4 + 4 x/d and row 4 − 4 y/d, d in front of it.
    fn camera() -> View {
        View {
            kind: ViewKind::Camera as u32,
            center: [0.0, 0.0, 5.0],
            width: 8,
            height: 8,
            depth: [0.0, 0.0, -1.0],
            w: [0.0, 0.0, -1.0],
            x: [4.0, 0.0, -4.0],
            y: [0.0, -4.0, -4.0],
            along: [-1.0, 1.0, -1.0],
            along_x: [0.25, 0.0, 0.0],
            along_y: [0.0, -0.25, 0.0],
            spread_w: 0.18,
            reach_squared: f32::MAX,
            ..View::zeroed()
        }
    }

    fn instance(low: [f32; 3], high: [f32; 3]) -> Instance {
        let center = [0, 1, 2].map(|i| (low[i] + high[i]) * 0.5);
        let half = [0, 1, 2].map(|i| (high[i] - low[i]) * 0.5);
        let radius = libm::sqrtf(half.iter().map(|h| h * h).sum());
        Instance { low, high, center, radius, ..Instance::zeroed() }
    }

    /// The rectangle of a box.
    fn rectangle(view: &View, low: [f32; 3], high: [f32; 3]) -> [u32; 4] {
        let bounds = screen_bounds(view, &instance(low, high), 0.0);
        [bounds.x0, bounds.y0, bounds.x1, bounds.y1]
    }

    #[test]
    fn a_box_covers_the_blocks_that_it_is_projected_to() {
        // At a distance of 8: columns 4.5 to 5.5, rows 2.25 to 3.5.
        let flat = |view: View| rectangle(&view, [1.0, 1.0, -3.0], [3.0, 3.5, -3.0]);
        assert_eq!(flat(camera()), [4, 2, 6, 4]);
        // The nearer side of a box is larger: up to column 4 + 4 · 3/4.
        assert_eq!(rectangle(&camera(), [1.0, 1.0, -3.0], [3.0, 3.5, 1.0]), [4, 0, 8, 4]);
        // Behind the camera, beside the picture, around the camera.
        assert_eq!(rectangle(&camera(), [-1.0, -1.0, 6.0], [1.0, 1.0, 8.0]), [0; 4]);
        assert_eq!(rectangle(&camera(), [30.0, 0.0, -3.0], [31.0, 1.0, -2.0]), [0; 4]);
        assert_eq!(rectangle(&camera(), [-1.0, -1.0, 4.0], [1.0, 1.0, 6.0]), [0, 0, 8, 8]);
        assert_eq!(flat(View { kind: ViewKind::Off as u32, ..camera() }), [0; 4]);
        assert_eq!(flat(View { one_list: 1, ..camera() }), [0, 0, 1, 1]);
    }

    #[test]
    fn a_key_is_a_little_nearer_than_the_nearest_point() {
        let of = |view: &View| screen_bounds(view, &instance([0.0, 0.0, -3.0], [1.0, 1.0, -1.0]), 0.0).key;
        let key = f32::from_bits(of(&camera()));
        assert!(key < 6.0 && key > 6.0 * 0.999, "{key}");
        assert_eq!(of(&View { kind: ViewKind::Point as u32, ..camera() }), 0);
    }

    #[test]
    fn a_light_covers_nothing_beyond_its_reach() {
        let light =
            |reach: f32| View { kind: ViewKind::Point as u32, reach_squared: reach * reach, ..camera() };
        // (1, 1) aside and 6 in front: √38 away.
        let bounds = |reach: f32| rectangle(&light(reach), [1.0, 1.0, -3.0], [3.0, 3.0, -1.0]);
        assert_eq!(bounds(6.1), [0; 4]);
        assert_ne!(bounds(6.2), [0; 4]);
    }

    #[test]
    fn every_block_that_a_point_of_the_box_lies_in_is_covered() {
        let mut state = 1_u32;
        let mut next = |low: f32, high: f32| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            low + (state >> 8) as f32 / (1 << 24) as f32 * (high - low)
        };
        let view = camera();
        for _ in 0..5000 {
            let low = [next(-6.0, 5.0), next(-6.0, 5.0), next(-8.0, 5.0)];
            let high = low.map(|c| c + next(0.0, 3.0));
            let (bounds, instance) = (screen_bounds(&view, &instance(low, high), 0.0), instance(low, high));
            for _ in 0..8 {
                let p = [0, 1, 2].map(|i| next(low[i], high[i]));
                let d = 5.0 - p[2];
                let (column, row) = (4.0 + 4.0 * p[0] / d, 4.0 - 4.0 * p[1] / d);
                if d <= 0.01 || !(0.0..8.0).contains(&column) || !(0.0..8.0).contains(&row) {
                    continue;
                }
                let (column, row) = (column as u32, row as u32);
                let ScreenBounds { x0, y0, x1, y1, .. } = bounds;
                assert!((x0..x1).contains(&column) && (y0..y1).contains(&row), "{p:?} {bounds:?}");
                assert!(sphere_in_block(&view, &instance, 0.0, column, row), "{p:?}");
            }
        }
    }

    #[test]
    fn a_sphere_is_out_of_the_way_of_blocks_far_beside_it() {
        let ball = instance([-0.1, -0.1, -3.1], [0.1, 0.1, -2.9]);
        let met = |column, row| sphere_in_block(&camera(), &ball, 0.0, column, row);
        assert!(met(3, 3) && met(4, 4) && !met(0, 3) && !met(4, 7) && !met(7, 7));
        assert!(sphere_in_block(&View { one_list: 1, ..camera() }, &ball, 0.0, 7, 7));
    }
}

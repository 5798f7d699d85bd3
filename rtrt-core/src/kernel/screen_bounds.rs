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

//! Hybrid frames: the closest surfaces of the camera's rays, from a rasterized picture of numbers.
//!
//! The paper's conclusion: rasterized deferred buffers, with traced shadows and light. The rasterizer
//! draws the number of the nearest instance and triangle into each pixel. The ray of the pixel is then
//! tested against that one triangle, by the kernel that traces. So a hit has the bits that
//! [`visibility`](crate::stage::visibility) gives for the same triangle, and all later stages are as in
//! a traced frame. Which triangle it is may differ at its edges, and where two are almost equally near:
//! hybrid frames are outside the promise of equal bits.
//!
//! # What is traced after all
//!
//! A ray is traced by [`peel`](crate::stage::peel) if it misses the drawn triangle (rasterizers round
//! corners to a fraction of a pixel), hits a back face that is culled, or if the pixel shows a masked
//! triangle or the blocks of a sphere. Of a square of 20,000 triangles, each half a pixel, that is 0.3 %
//! of the rays on lavapipe.
//!
//! # The picture
//!
//! - A sub-ray is a pixel of a larger picture, since all rays lie on one grid. A picture larger than a
//!   texture is drawn in windows of blocks ([`project`](crate::kernel::project)).
//! - Depth is reversed, near/w, with an infinite far plane. The near plane is at 2⁻⁴⁰ of the frame's
//!   magnitude; 2⁻²² cut off a floor millions of units wide in front of the camera. With parallel rays
//!   depth is linear, and surfaces less than 2⁻²² of the magnitude apart may change places.
//! - A sphere is drawn as the rectangle of blocks that it covers, at its nearest depth. Refused: boxes,
//!   because the camera may be inside one; the sphere's equation in the fragment shader, because it
//!   disables the early depth test.

use crate::grid::{BLOCK, RayIndex};
use crate::kernel::project::{ClipWindow, Projected};
use crate::kernel::ray::point;
use crate::kernel::screen_bounds::ScreenBounds;
use crate::kernel::transparency::alpha_mode;
use crate::kernel::triangle::{Triangle, intersect};
use crate::lane::V3;
use crate::layout::{AlphaKind, Frame, Hit, Instance, NONE, View};
use crate::stage::visibility::rays;

/// The meshes of a scene, as they are drawn.
#[derive(Clone, Copy)]
pub struct Meshes<'a> {
    /// Objects, placed in the world.
    pub instances: &'a [Instance],
    /// See [`Geometry::mesh_data`](crate::kernel::geometry::Geometry::mesh_data).
    pub mesh_data: &'a [u32],
    /// Vertex positions, object space.
    pub positions: &'a [[f32; 3]],
}

/// What is drawn: one more than the instance, and the triangle, or [`NONE`] where rays are to be
/// traced; 0 for nothing.
pub type Drawn = [u32; 2];

/// A ray that is still to be traced.
pub(crate) const UNTRACED: Hit = Hit { t: 0.0, instance: 0, triangle: 0, u: 0.0, v: 0.0 };

/// Whether a ray is still to be traced.
#[inline(always)]
pub fn is_untraced(hit: &Hit) -> bool {
    hit.t <= 0.0
}

/// Vertex `number` of an instance, three a triangle: its place in the window's picture, and what is
/// drawn.
///
/// A sphere, of which there are no triangles, is the rectangle of blocks that it covers, as near as
/// anything of it; it has as many vertices as the two triangles that it counts as.
#[inline(always)]
pub fn vertex(
    frame: &Frame,
    view: &View,
    window: &ClipWindow,
    screen_bounds: &[ScreenBounds],
    meshes: &Meshes<'_>,
    instance: u32,
    number: u32,
) -> ([f32; 4], Drawn) {
    let placed = &meshes.instances[instance as usize];
    let triangle = number / 3;
    let seen = if placed.is_sphere() {
        let cover = &screen_bounds[(Frame::CAMERA * frame.instances + instance) as usize];
        let corner = if triangle == 0 { number } else { 6 - number };
        rectangle(frame, view, cover, corner)
    } else {
        let vertex = placed.first_vertex + meshes.mesh_data[(placed.first_index + number) as usize];
        Projected::point(view, to_world(placed, meshes.positions[vertex as usize]))
    };
    let is_traced = placed.is_sphere() || alpha_mode(placed, meshes.mesh_data) == AlphaKind::Mask as u32;
    let drawn = [instance + 1, if is_traced { NONE } else { triangle }];
    (seen.clip(view, window, frame.magnitude), drawn)
}

/// The blocks that something covers: first column and row, the column and row after the last.
#[inline(always)]
fn blocks(frame: &Frame, view: &View, cover: &ScreenBounds) -> [u32; 4] {
    if view.one_list == 1 {
        // All blocks share one list, and are one to a cover.
        return [0, 0, frame.grid().blocks_x(), frame.grid().blocks_y()];
    }
    [cover.x0, cover.y0, cover.x1, cover.y1]
}

/// Whether anything of an instance can be in the picture of the window.
#[inline(always)]
pub fn is_in(frame: &Frame, view: &View, window: &ClipWindow, cover: &ScreenBounds) -> bool {
    let [x0, y0, x1, y1] = blocks(frame, view, cover);
    let (right, bottom) = (window.column + window.columns, window.row + window.rows);
    x0 < right && window.column < x1 && y0 < bottom && window.row < y1
}

/// A corner of what a cover covers: 0 has the first column and row, 1 the first row only, 2 the
/// first column only, and 3 neither.
#[inline(always)]
fn rectangle(frame: &Frame, view: &View, cover: &ScreenBounds, corner: u32) -> Projected {
    let [x0, y0, x1, y1] = blocks(frame, view, cover);
    let column = if corner & 1 == 0 { x0 } else { x1 };
    let row = if corner & 2 == 0 { y0 } else { y1 };
    Projected::corner(view, frame.magnitude, [column, row], f32::from_bits(cover.key))
}

/// A point of an instance, in world space.
#[inline(always)]
fn to_world(instance: &Instance, position: [f32; 3]) -> V3<f32> {
    let position = V3::splat((), position);
    if instance.is_identity == 1 { position } else { point(&instance.to_world, position) }
}

/// How many numbers a row of a picture has, in which all blocks of a row of the frame's are drawn: an
/// even number of blocks, because rows that are copied are multiples of 256 bytes.
#[inline(always)]
pub fn pitch(frame: &Frame) -> u32 {
    frame.grid().blocks_x().next_multiple_of(2) * BLOCK
}

/// Which number of the picture is that of a ray: row by row, the first of them that of the
/// dispatch's first block.
#[inline(always)]
pub fn pixel(frame: &Frame, ray: RayIndex) -> u32 {
    let grid = frame.grid();
    let ([x, y], [_, first]) = (grid.ray(ray), grid.ray(RayIndex(frame.first_ray)));
    (y - first) * pitch(frame) + x
}

/// The record of a ray through a pixel in which this is drawn; a ray outside the frame hits nothing.
#[inline(always)]
pub fn pick(frame: &Frame, camera: &View, meshes: &Meshes<'_>, ray: RayIndex, drawn: Drawn) -> Hit {
    let [instance, triangle] = drawn;
    if instance == 0 || !frame.grid().contains(frame.grid().ray(ray)) {
        return Hit::MISS;
    }
    if triangle == NONE {
        return UNTRACED;
    }
    let instance = instance - 1;
    let placed = &meshes.instances[instance as usize];
    let ray = rays::<f32, 1>((), frame, camera, ray)[0];
    let ray = if placed.is_identity == 1 { ray } else { ray.to_object(placed) };
    let [a, b, c] = placed.corners(meshes.mesh_data, triangle);
    let corner = |vertex: u32| meshes.positions[vertex as usize];
    let shape = Triangle::new(corner(a), corner(b), corner(c));
    let seen = shape.relative_to(ray.origin);
    let found = intersect(&ray, &seen, f32::MAX);
    let is_between = found.t > frame.near && found.t <= frame.far;
    if found.mask && is_between && (placed.double_sided == 1 || seen.front(found.t)) {
        Hit { t: found.t, instance, triangle, u: found.u, v: found.v }
    } else {
        UNTRACED
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::geometry::Geometry;
    use crate::scene::{Material, Scene};
    use crate::stage::fixture::{Prepared, add_square, closest, square_at};
    use bytemuck::Zeroable;

    #[test]
    fn rows_of_the_picture_have_an_even_number_of_blocks() {
        // Three blocks across.
        let frame = Frame { width: 40, height: 40, side: 1, ..Frame::zeroed() };
        assert_eq!(pitch(&frame), 64);
        let grid = frame.grid();
        assert_eq!(pixel(&frame, grid.index([37, 18])), 18 * 64 + 37);
        // Of a dispatch that begins with the second row of blocks.
        let band = Frame { first_ray: grid.index([0, 16]).0, ..frame };
        assert_eq!(pixel(&band, grid.index([37, 18])), 2 * 64 + 37);
    }

    #[test]
    fn an_instance_is_drawn_in_the_windows_that_it_covers() {
        let frame = Frame { width: 256, height: 256, side: 1, ..Frame::zeroed() };
        let window = ClipWindow { column: 4, row: 8, columns: 4, rows: 4 };
        let is_in = |x0, y0, x1, y1| {
            is_in(&frame, &View::zeroed(), &window, &ScreenBounds { x0, y0, x1, y1, key: 0 })
        };
        assert!(is_in(0, 0, 5, 9) && is_in(7, 11, 16, 16) && is_in(5, 9, 6, 10));
        assert!(!is_in(0, 0, 4, 16) && !is_in(8, 0, 16, 16) && !is_in(0, 0, 16, 8) && !is_in(0, 12, 16, 16));
    }

    #[test]
    fn a_ray_has_the_hit_of_the_triangle_that_is_drawn() {
        let mut scene = Scene::new();
        add_square(&mut scene, Material::default(), square_at(4.0, [0.0, 0.0, 1.0]));
        let prepared = Prepared::new(scene, |request| request);
        let context = prepared.context();
        let Geometry { instances, mesh_data, positions, .. } = context.geometry;
        let meshes = Meshes { instances, mesh_data, positions };
        let pick = |place, drawn| {
            let ray = context.frame.grid().index(place);
            pick(context.frame, context.camera(), &meshes, ray, drawn)
        };
        let [traced] = closest::<f32, 1>(&prepared, context.frame.grid().index([9, 8]));
        let traced = traced.rows().hit(0);
        assert_eq!(pick([9, 8], [1, traced.triangle]), traced);
        assert_eq!(pick([9, 8], [0, 0]), Hit::MISS);
        // The square's other triangle, and what only a search can find.
        assert!(
            is_untraced(&pick([9, 8], [1, 1 - traced.triangle])) && is_untraced(&pick([9, 8], [1, NONE]))
        );
        assert!(!is_untraced(&traced) && !is_untraced(&Hit::MISS));
    }
}

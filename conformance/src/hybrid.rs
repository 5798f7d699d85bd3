//! How far hybrid frames, whose closest surfaces are drawn, are from those that are traced.

use rtrt_core::backend::{Deferred, Picture, Request};
use rtrt_core::grid::Grid;
use rtrt_core::layout::{Hit, NONE};

/// How far apart two surfaces are, as a share of their distance, of which a rasterizer may take either.
const NEAR: f32 = 1.0 / 65_536.0;
/// The least barycentric coordinate of a hit on an edge: some roundings.
const EDGE: f32 = 1e-6;

/// What is different in a frame that is drawn.
#[derive(Debug, Default)]
pub struct Differences {
    /// Rays in the frame.
    pub rays: usize,
    /// Those that meet something.
    pub met: usize,
    /// Those that meet another triangle, or something and nothing.
    pub other: usize,
    /// Of these, those that meet two triangles at nearly the same distance.
    pub near: usize,
    /// Of the rest, those that are not beside a ray that meets something else when all is traced. At the border of
    /// the picture, where rays lack neighbors, an edge of the triangle that is met counts as well.
    pub strange: usize,
    /// Those that meet the same triangle, but not with the same bits.
    pub uneven: usize,
    /// Numbers of the pixels that differ.
    pub pixels: Vec<u32>,
    /// The largest difference of a channel, of 255 steps.
    pub largest: u8,
    /// The mean difference of all channels of all pixels, in steps.
    pub mean: f64,
}

impl Differences {
    /// Compares two pictures of the request, with their deferred buffers; none where a picture has none.
    pub fn of(request: &Request<'_>, traced: &Picture, drawn: &Picture) -> Option<Self> {
        let [width, height] = request.size;
        let grid = Grid { width, height, side: request.samples.isqrt() };
        let mut found = Self::of_hits(grid, traced.deferred.as_ref()?, drawn.deferred.as_ref()?);
        let mut sum = 0;
        for (number, (a, b)) in (0..).zip(traced.pixels.iter().zip(&drawn.pixels)) {
            if a != b {
                found.pixels.push(number);
            }
            for (a, b) in a.to_le_bytes().into_iter().zip(b.to_le_bytes()) {
                found.largest = found.largest.max(a.abs_diff(b));
                sum += u64::from(a.abs_diff(b));
            }
        }
        found.mean = sum as f64 / (4 * traced.pixels.len()).max(1) as f64;
        Some(found)
    }

    fn of_hits(grid: Grid, traced: &Deferred, drawn: &Deferred) -> Self {
        let mut found = Self::default();
        let [width, height] = [grid.width * grid.side, grid.height * grid.side];
        let at = |[x, y]: [u32; 2]| &traced.hits[grid.index([x, y]).0 as usize];
        for y in 0..height {
            for x in 0..width {
                let (a, b) = (at([x, y]), &drawn.hits[grid.index([x, y]).0 as usize]);
                found.rays += 1;
                found.met += usize::from(b.instance != NONE);
                if !is_same(a, b) {
                    found.other += 1;
                    let mut around = (y.max(1) - 1..(y + 2).min(height))
                        .flat_map(|y| (x.max(1) - 1..(x + 2).min(width)).map(move |x| [x, y]));
                    let is_near = (a.t - b.t).abs() <= a.t * NEAR;
                    found.near += usize::from(is_near);
                    let is_border = x == 0 || y == 0 || x + 1 == width || y + 1 == height;
                    let is_edge = is_border && (is_on_edge(a) || is_on_edge(b));
                    let is_alike = around.all(|place| is_same(a, at(place)));
                    found.strange += usize::from(!is_near && !is_edge && is_alike);
                } else if a != b {
                    found.uneven += 1;
                }
            }
        }
        found
    }
}

/// Whether an edge of the triangle that is met is a few roundings away.
fn is_on_edge(hit: &Hit) -> bool {
    hit.instance != NONE && hit.u.min(hit.v).min(1.0 - hit.u - hit.v) <= EDGE
}

fn is_same(a: &Hit, b: &Hit) -> bool {
    (a.instance, a.triangle) == (b.instance, b.triangle)
}

//! Debug views of a frame. They are computed from the deferred buffers, so all backends give the same
//! views.

use crate::layers::Layers;
use rtrt_core::backend::{Picture, Request};
use rtrt_core::kernel::lists::BlockLists;
use rtrt_core::kernel::view::camera_ray;
use rtrt_core::layout::{Frame, NONE};
use rtrt_core::num::srgb_encode;
use rtrt_core::scene::{Scene, Setup, SetupError};
use rtrt_core::stage::context::Context;
use rtrt_core::stage::inspect::{Inspection, inspect};

/// A property of a frame as colors.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum DebugView {
    /// Base colors.
    Albedo,
    /// World space normals: x is red, y green, z blue, from −1 (dark) to 1.
    Normal,
    /// Depth, from white (nearest) to dark gray (farthest).
    Depth,
    /// A color for each object, in shades for its triangles.
    Ids,
    /// The mean transmittance to the lights.
    Shadow,
    /// The fractional parts of texture coordinates: u is red, v green.
    Uv,
    /// Figure 1a of the paper: black for an empty list of the block, blue for a ray that misses all bounding
    /// spheres of the list, white for one that misses all meshes, else the picture.
    Blocks,
    /// The length of the list of the pixel's block.
    Heat,
    /// The number of boxes and triangles that the pixel's first ray is tested with.
    Tests,
}

impl DebugView {
    /// All views, with their names.
    pub const ALL: [(&'static str, Self); 9] = [
        ("albedo", Self::Albedo),
        ("normal", Self::Normal),
        ("depth", Self::Depth),
        ("ids", Self::Ids),
        ("shadow", Self::Shadow),
        ("uv", Self::Uv),
        ("blocks", Self::Blocks),
        ("heat", Self::Heat),
        ("tests", Self::Tests),
    ];

    /// What the colors mean.
    pub fn meaning(self) -> &'static str {
        match self {
            Self::Albedo => "base colors",
            Self::Normal => "red is x, green y, blue z, from -1 (dark) to 1",
            Self::Depth => "light is near, dark is far",
            Self::Ids => "a color for each object, in shades for its triangles",
            Self::Shadow => "white is lit by all lights, black by none",
            Self::Uv => "red is u, green is v, without whole numbers",
            Self::Blocks => "black: empty list; blue: misses all spheres; white: misses all meshes",
            Self::Heat => "entries in the list of the block",
            Self::Tests => "boxes and triangles that a ray is tested with",
        }
    }
}

/// A debug view of a frame.
#[derive(Debug, Clone, PartialEq)]
pub struct DebugImage {
    /// As in [`Picture::pixels`].
    pub pixels: Vec<u32>,
    /// The meaning of the colors, if it depends on the frame.
    pub legend: Option<String>,
}

/// The color of pixels without a surface, in views with black as a value.
const NOTHING: [f32; 3] = [0.03, 0.03, 0.12];

/// A view of a picture of the scene for this request; none without its deferred buffers.
///
/// # Errors
/// The request is invalid.
pub fn show(
    view: DebugView,
    scene: &Scene,
    request: &Request<'_>,
    picture: &Picture,
) -> Result<Option<DebugImage>, SetupError> {
    let Some(layers) = Layers::new(scene, request, picture) else { return Ok(None) };
    let mut legend = None;
    let is_hit = |i: usize| layers.object[i] != NONE;
    let all = 0..layers.object.len();
    let map = |color: &dyn Fn(usize) -> [f32; 3]| all.clone().map(|i| pack(color(i))).collect();
    let pixels = match view {
        DebugView::Albedo => map(&|i| layers.albedo[i].map(srgb_encode)),
        DebugView::Normal => {
            map(&|i| if is_hit(i) { layers.normal[i].map(|n| n * 0.5 + 0.5) } else { NOTHING })
        }
        DebugView::Depth => {
            let depths = || layers.depth.iter().copied().filter(|depth| depth.is_finite());
            let (near, far) = (depths().fold(f32::MAX, f32::min), depths().fold(0.0, f32::max));
            legend = Some(format!("white is {near}, dark gray {far} away"));
            let scale = 0.9 / (far - near).max(f32::MIN_POSITIVE);
            map(&|i| if is_hit(i) { [1.0 - (layers.depth[i] - near) * scale; 3] } else { NOTHING })
        }
        DebugView::Ids => {
            map(&|i| if is_hit(i) { id(layers.object[i], layers.triangle[i]) } else { [0.0; 3] })
        }
        DebugView::Shadow => map(&|i| if is_hit(i) { [layers.shadow[i]; 3] } else { NOTHING }),
        DebugView::Uv => map(&|i| {
            let [u, v] = layers.uv[i].map(|c| c - c.floor());
            if is_hit(i) { [u, v, 0.0] } else { NOTHING }
        }),
        DebugView::Blocks => {
            let colors = inspected(scene, request, picture)?;
            colors.zip(&picture.pixels).map(|(found, &pixel)| block(&found).map_or(pixel, pack)).collect()
        }
        DebugView::Heat => {
            let counts: Vec<u32> = inspected(scene, request, picture)?.map(|found| found.entries).collect();
            legend = Some(format!("white is {}", counted(most(&counts), ["entry", "entries"])));
            heat_map(&counts)
        }
        DebugView::Tests => {
            let counts: Vec<u32> =
                inspected(scene, request, picture)?.map(|found| found.boxes + found.triangles).collect();
            let most = counted(most(&counts), ["test", "tests"]);
            legend = Some(format!("white is {most} of boxes and triangles"));
            heat_map(&counts)
        }
    };
    Ok(Some(DebugImage { pixels, legend }))
}

/// The cost of the first sub-ray of each pixel.
fn inspected(
    scene: &Scene,
    request: &Request<'_>,
    picture: &Picture,
) -> Result<impl Iterator<Item = Inspection>, SetupError> {
    let mut setup = Setup::default();
    setup.prepare(scene, request)?;
    let frame = setup.frame;
    let (grid, camera) = (frame.grid(), setup.views[Frame::CAMERA as usize]);
    let words = picture.deferred.as_ref().map_or(&[][..], |deferred| &deferred.lists);
    let lists = BlockLists { data: words, blocks: frame.blocks };
    let geometry = setup.geometry(scene);
    let context = Context { frame: &frame, views: &setup.views, lists, geometry };
    let inspect = |number| {
        let [x, y] = grid.pixel(number).map(|place| place * grid.side);
        let ray = camera_ray(&camera, x as f32, y as f32);
        inspect(&context, camera.list(grid.block(grid.index([x, y]))), &ray)
    };
    Ok((0..frame.width * frame.height).map(inspect).collect::<Vec<_>>().into_iter())
}

/// The color of a ray in figure 1a; none for a ray with a hit.
fn block(found: &Inspection) -> Option<[f32; 3]> {
    match found {
        Inspection { hit, .. } if hit.instance != NONE => None,
        Inspection { entries: 0, .. } => Some([0.0; 3]),
        Inspection { sphere: false, .. } => Some([0.0, 0.0, 1.0]),
        _ => Some([1.0; 3]),
    }
}

/// The counts as colors: black, blue, red, yellow, and white for the highest.
fn heat_map(counts: &[u32]) -> Vec<u32> {
    let scale = 1.0 / most(counts).max(1) as f32;
    counts.iter().map(|&count| pack(heat(count as f32 * scale))).collect()
}

/// `1 entry`, `2 entries`.
fn counted(count: u32, [one, many]: [&str; 2]) -> String {
    format!("{count} {}", if count == 1 { one } else { many })
}

fn most(counts: &[u32]) -> u32 {
    counts.iter().copied().max().unwrap_or(0)
}

/// The color of a share of 0 ..= 1: black, blue, red, yellow, white.
pub fn heat(share: f32) -> [f32; 3] {
    const STEPS: [[f32; 3]; 5] =
        [[0.0, 0.0, 0.0], [0.1, 0.1, 0.8], [0.85, 0.1, 0.2], [1.0, 0.85, 0.1], [1.0, 1.0, 1.0]];
    let place = share.clamp(0.0, 1.0) * (STEPS.len() - 1) as f32;
    let step = (place as usize).min(STEPS.len() - 2);
    let (from, to, weight) = (STEPS[step], STEPS[step + 1], place - step as f32);
    [0, 1, 2].map(|channel| from[channel] + (to[channel] - from[channel]) * weight)
}

/// The color of a triangle: its instance's color in one of four shades.
pub fn id(object: u32, triangle: u32) -> [f32; 3] {
    let shade = 0.7 + (hash(triangle) & 3) as f32 * 0.1;
    let bits = hash(object);
    [bits, bits >> 8, bits >> 16].map(|bits| (0.2 + (bits & 255) as f32 * (0.8 / 255.0)) * shade)
}

/// Pseudo-random bits (Wellons, "hash32", 2018).
fn hash(x: u32) -> u32 {
    let x = (x.wrapping_add(1) ^ x.wrapping_add(1) >> 16).wrapping_mul(0x7feb_352d);
    let x = (x ^ x >> 15).wrapping_mul(0x846c_a68b);
    x ^ x >> 16
}

/// A color of 0 ..= 1 as a pixel.
fn pack(color: [f32; 3]) -> u32 {
    let [r, g, b] = color.map(|value| (value.clamp(0.0, 1.0) * 255.0 + 0.5) as u8);
    u32::from_le_bytes([r, g, b, 255])
}

#[cfg(all(test, feature = "import"))]
mod tests {
    use super::*;
    use rtrt_core::backend::Backend;
    use rtrt_cpu::{Cpu, Options};

    #[test]
    fn inspection_finds_the_hits_of_the_frame() {
        let loaded = crate::demo::matchbox(&rtrt_core::scene::Sequential).unwrap();
        let mut cpu = Cpu::new(Options { lanes: None, threads: None }).unwrap();
        for samples in [1, 4] {
            let request = Request::new(&loaded.camera, [97, 55]).samples(samples).deferred(true);
            let mut picture = Picture::default();
            cpu.render(&loaded.scene, &request, &mut picture).unwrap();
            let layers = Layers::new(&loaded.scene, &request, &picture).unwrap();
            let mut skipped = 0;
            for (i, found) in inspected(&loaded.scene, &request, &picture).unwrap().enumerate() {
                let hit = found.hit;
                let t = if hit.instance == NONE { f32::INFINITY } else { hit.t };
                assert_eq!((hit.instance, hit.triangle), (layers.object[i], layers.triangle[i]));
                assert_eq!(
                    ([t, hit.u, hit.v]),
                    [layers.depth[i], layers.barycentrics[i][0], layers.barycentrics[i][1]]
                );
                assert!(found.tested <= found.entries && found.tested <= found.boxes);
                assert!(found.sphere || hit.instance == NONE);
                skipped += found.entries - found.tested;
            }
            assert!(skipped > 0, "no list is left before its end");
            let views = DebugView::ALL
                .map(|(_, view)| show(view, &loaded.scene, &request, &picture).unwrap().unwrap());
            for (i, view) in views.iter().enumerate() {
                assert!(
                    view.pixels.len() == 97 * 55 && view.pixels.iter().any(|p| *p != view.pixels[0]),
                    "{i}"
                );
                assert!(views[..i].iter().all(|other| other.pixels != view.pixels), "{i}");
            }
        }
    }

    #[test]
    fn higher_counts_have_brighter_colors() {
        assert_eq!((heat(0.0), heat(1.0)), ([0.0; 3], [1.0; 3]));
        let brightness = |share: f32| heat(share).iter().sum::<f32>();
        assert!((0..100).all(|n| brightness(n as f32 / 100.0) < brightness((n + 1) as f32 / 100.0)));
    }
}

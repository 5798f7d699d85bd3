//! The deferred buffers of a frame as layers of pixels, for compositing and inspection.

use rtrt_core::backend::{Deferred, Picture, Request};
use rtrt_core::grid::Grid;
use rtrt_core::kernel::texture::Maps;
use rtrt_core::kernel::transmittance::color;
use rtrt_core::lane::{V3, Word};
use rtrt_core::layout::{Backdrop, NONE, Surface};
use rtrt_core::num::{exp2, srgb_encode};
use rtrt_core::scene::Scene;
use rtrt_core::stage::resolve::{average, displayed};
use rtrt_core::stage::shade::base;
use rtrt_core::stage::surface::Surfaces;

/// Properties of each pixel, row by row from the upper left.
///
/// `color`, `albedo` and `shadow` are averages over a pixel's sub-rays. The others come from its first, upper
/// left sub-ray: an average of ids, or of normals on both sides of an edge, belongs to no surface.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Layers {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Linear RGB, neither exposed nor tone mapped, times alpha, and alpha: 0 where a background of one color or
    /// nothing shows.
    pub color: Vec<[f32; 4]>,
    /// The background's color, linear RGB; black without one.
    pub background: [f32; 3],
    /// Whether pixels show what is behind the picture.
    pub is_transparent: bool,
    /// Depth along the view, world units; infinite without a hit.
    pub depth: Vec<f32>,
    /// Unit normals towards the viewer, world space; 0 without a hit.
    pub normal: Vec<[f32; 3]>,
    /// Base color, linear RGB: material, texture and vertex color, without light.
    pub albedo: Vec<[f32; 3]>,
    /// Objects, or [`NONE`].
    pub object: Vec<u32>,
    /// Triangles of the object's mesh, in the order of its tree's leaves, or [`NONE`].
    pub triangle: Vec<u32>,
    /// The same triangles as the source numbers them ([`Scene::source_triangle`]), or [`NONE`].
    pub source: Vec<u32>,
    /// The numbers of materials ([`Scene::materials`]), or [`NONE`].
    pub material: Vec<u32>,
    /// Where the surfaces are, world space; 0 without a hit. It is where rays from them start: off by some roundings and,
    /// on a mesh with smooth normals, on the curved surface that these mean.
    pub position: Vec<[f32; 3]>,
    /// Barycentric weights of the triangle's second and third corner.
    pub barycentrics: Vec<[f32; 2]>,
    /// Texture coordinates.
    pub uv: Vec<[f32; 2]>,
    /// The mean transmittance from the surface to the scene's lights; 0 for a light behind the surface. 0 without
    /// a hit.
    pub shadow: Vec<f32>,
}

impl Layers {
    /// The layers of a picture of the scene with `samples` sub-rays per pixel; none without its deferred
    /// buffers.
    pub fn new(scene: &Scene, picture: &Picture, samples: u32) -> Option<Self> {
        let deferred = picture.deferred.as_ref()?;
        let grid = Grid { width: picture.width, height: picture.height, side: samples.isqrt() };
        let maps = Maps { materials: scene.materials(), texels: scene.texels() };
        let lights = scene.lights().len().max(1) as f32;
        let (background, is_transparent) = (scene.background.to_array(), scene.backdrop == Backdrop::Nothing);
        let mut layers = Self {
            width: picture.width,
            height: picture.height,
            background,
            is_transparent,
            ..Self::default()
        };
        for pixel in (0..grid.width * grid.height).map(|number| grid.pixel(number)) {
            let index = grid.index(pixel.map(|place| place * grid.side)).0 as usize;
            let (hit, surface) = (&deferred.hits[index], &deferred.surfaces[index]);
            layers.color.push(average(grid, pixel, &|ray| deferred.colors[ray.0 as usize]));
            layers.depth.push(if hit.instance == NONE { f32::INFINITY } else { hit.t });
            layers.normal.push(surface.normal);
            layers.object.push(hit.instance);
            layers.triangle.push(hit.triangle);
            let instance = scene.instance_index(hit.instance);
            let source = instance.and_then(|instance| scene.source_triangle(instance, hit.triangle));
            layers.source.push(source.unwrap_or(NONE));
            // 0 is no hit, which becomes NONE.
            layers.material.push(surface.material.wrapping_sub(1));
            layers.position.push(surface.origin);
            layers.barycentrics.push([hit.u, hit.v]);
            layers.uv.push(surface.uv);
            let [r, g, b, lit] = average(grid, pixel, &|ray| {
                let [r, g, b] = albedo(&maps, &deferred.surfaces[ray.0 as usize]);
                [r, g, b, reached(deferred, ray.0 as usize)]
            });
            layers.albedo.push([r, g, b]);
            layers.shadow.push(lit / lights);
        }
        Some(layers)
    }

    /// The color with 16 bits per channel: exposed and tone mapped as the request says, in front of the
    /// background, sRGB, and straight (not premultiplied) alpha.
    pub fn encoded16(&self, request: &Request<'_>) -> Vec<[u16; 4]> {
        let round = |value: f32| (value * 65535.0 + 0.5) as u16;
        let encode = |value: f32| round(srgb_encode(value));
        let (exposure, operator) = (exp2(request.exposure), request.tone_map as u32);
        self.color
            .iter()
            .map(|&color| straight(color))
            .map(|[r, g, b, a]| {
                let V3 { x, y, z } = displayed::<f32>(exposure, operator, V3::splat((), [r, g, b]));
                if a >= 1.0 || self.is_transparent {
                    return [encode(x), encode(y), encode(z), round(a)];
                }
                let [r, g, b] = self.background.map(|channel| channel * (1.0 - a));
                [encode(x * a + r), encode(y * a + g), encode(z * a + b), u16::MAX]
            })
            .collect()
    }
}

/// The base color of a surface; black without a hit.
fn albedo(maps: &Maps<'_>, surface: &Surface) -> [f32; 3] {
    if surface.material == 0 {
        return [0.0; 3];
    }
    let base = base::<f32>(maps, &Surfaces::new(surface));
    [base.x, base.y, base.z]
}

/// The sum of the transmittances from the surface of a ray to the lights.
fn reached(deferred: &Deferred, ray: usize) -> f32 {
    let lights = deferred.transmittance_words as usize;
    if lights > 0 {
        let part = |&word: &u32| {
            let V3 { x, y, z } = color::<f32>(Word(word));
            (x + y + z) * (1.0 / 3.0)
        };
        return deferred.transmittance[ray * lights..][..lights].iter().map(part).sum();
    }
    let words = deferred.mask_words as usize;
    deferred.masks[ray * words..][..words].iter().map(|word| word.count_ones()).sum::<u32>() as f32
}

/// The straight color of a premultiplied one.
fn straight([r, g, b, a]: [f32; 4]) -> [f32; 4] {
    if a > 0.0 && a < 1.0 { [r / a, g / a, b / a, a] } else { [r, g, b, a] }
}

//! The deferred buffers of a frame as layers of pixels, for compositing and inspection.

use glam::DVec3;
use rtrt_core::backend::{Deferred, Picture, Request};
use rtrt_core::grid::{Grid, RayIndex};
use rtrt_core::kernel::ray::Ray;
use rtrt_core::kernel::texture::Maps;
use rtrt_core::kernel::transmittance::color;
use rtrt_core::kernel::view::camera_ray;
use rtrt_core::lane::{V3, Word};
use rtrt_core::layout::{Backdrop, Hit, NONE, Surface, View};
use rtrt_core::num::{exp2, srgb_encode};
use rtrt_core::scene::Scene;
use rtrt_core::stage::resolve::{average, displayed};
use rtrt_core::stage::shade::base;
use rtrt_core::stage::share::shaded;
use rtrt_core::stage::surface::Surfaces;

/// The most rays that may have deferred buffers: 7 GB at about 110 bytes each. No backend refuses more, if there is memory.
pub const MOST_RAYS: u64 = 1 << 26;

/// Properties of each pixel, row by row from the upper left.
///
/// `color`, `normal`, `albedo` and `shadow` are averages over a pixel's sub-rays, weighted alike, as denoisers expect them of
/// color, normal and albedo. The others come from its first, upper left sub-ray: an average of ids, or of depths on both
/// sides of an edge, belongs to no surface. With one sub-ray, all are those of the middle of the pixel.
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
    /// Normals towards the viewer, world space; 0 without a hit. Each sub-ray's has length 1, so that of a pixel is shorter
    /// where they differ.
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
    /// Where the surfaces are, world space; 0 without a hit: the points of the sub-rays at `depth`.
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
    /// The layers of a picture of the scene for this request; none without its deferred buffers.
    pub fn new(scene: &Scene, request: &Request<'_>, picture: &Picture) -> Option<Self> {
        let pixels = Pixels::new(scene, request, picture)?;
        Some(Self {
            width: picture.width,
            height: picture.height,
            background: scene.background.to_array(),
            is_transparent: scene.backdrop == Backdrop::Nothing,
            color: pixels.all(Pixels::color),
            depth: pixels.all(Pixels::depth),
            normal: pixels.all(Pixels::normal),
            albedo: pixels.all(Pixels::albedo),
            object: pixels.all(Pixels::object),
            triangle: pixels.all(Pixels::triangle),
            source: pixels.all(Pixels::source),
            material: pixels.all(Pixels::material),
            position: pixels.all(Pixels::position),
            barycentrics: pixels.all(Pixels::barycentrics),
            uv: pixels.all(Pixels::uv),
            shadow: pixels.all(Pixels::shadow),
        })
    }

    /// The layers with positions that are not relative to this origin (of an imported scene, say).
    /// Far from it single precision rounds them; depth and pose are more precise.
    #[must_use]
    pub fn moved(mut self, origin: DVec3) -> Self {
        for (position, _) in self.position.iter_mut().zip(&self.object).filter(|(_, object)| **object != NONE)
        {
            *position = (origin + DVec3::from(position.map(f64::from))).as_vec3().to_array();
        }
        self
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

/// A picture with its deferred buffers, read pixel by pixel: for programs that need some of the [`Layers`], in memory of
/// their own. Pixels are numbered row by row from the upper left.
#[derive(Clone, Copy)]
pub struct Pixels<'a> {
    scene: &'a Scene,
    deferred: &'a Deferred,
    grid: Grid,
    view: View,
    maps: Maps<'a>,
    lights: f32,
}

impl<'a> Pixels<'a> {
    /// The pixels of a picture of the scene for this request; none without its deferred buffers.
    pub fn new(scene: &'a Scene, request: &Request<'_>, picture: &'a Picture) -> Option<Self> {
        let grid = Grid { width: picture.width, height: picture.height, side: request.samples.isqrt() };
        Some(Self {
            scene,
            deferred: picture.deferred.as_ref()?,
            grid,
            view: request.camera.view(grid).ok()?,
            maps: scene.maps(),
            lights: scene.lights().len().max(1) as f32,
        })
    }

    fn all<T>(&self, read: impl Fn(&Self, u32) -> T) -> Vec<T> {
        (0..self.grid.width * self.grid.height).map(|number| read(self, number)).collect()
    }

    /// Column and row of the first sub-ray, counted in sub-rays.
    fn place(&self, number: u32) -> [u32; 2] {
        self.grid.pixel(number).map(|place| place * self.grid.side)
    }

    /// The place of the first sub-ray in the buffers.
    fn first(&self, number: u32) -> usize {
        self.grid.index(self.place(number)).0 as usize
    }

    /// The place of the sub-ray that was shaded for a sub-ray.
    fn shaded(&self, RayIndex(ray): RayIndex) -> usize {
        shaded(ray, &self.deferred.hits[ray as usize]) as usize
    }

    /// The mean over the sub-rays of a pixel.
    fn mean(&self, number: u32, read: impl Fn(usize) -> [f32; 3]) -> [f32; 3] {
        let [x, y, z, _] = average(self.grid.side, self.grid.first_ray(number), |ray| {
            let [x, y, z] = read(self.shaded(ray));
            [x, y, z, 0.0]
        });
        [x, y, z]
    }

    fn hit(&self, number: u32) -> &Hit {
        &self.deferred.hits[self.first(number)]
    }

    fn surface(&self, number: u32) -> &Surface {
        &self.deferred.surfaces[self.first(number)]
    }

    /// [`Layers::color`].
    pub fn color(&self, number: u32) -> [f32; 4] {
        average(self.grid.side, self.grid.first_ray(number), |ray| self.deferred.colors[self.shaded(ray)])
    }

    /// [`Layers::depth`].
    pub fn depth(&self, number: u32) -> f32 {
        let hit = self.hit(number);
        if hit.instance == NONE { f32::INFINITY } else { hit.t }
    }

    /// [`Layers::normal`].
    pub fn normal(&self, number: u32) -> [f32; 3] {
        self.mean(number, |ray| self.deferred.surfaces[ray].normal)
    }

    /// [`Layers::albedo`].
    pub fn albedo(&self, number: u32) -> [f32; 3] {
        self.mean(number, |ray| albedo(&self.maps, &self.deferred.surfaces[ray]))
    }

    /// [`Layers::object`].
    pub fn object(&self, number: u32) -> u32 {
        self.hit(number).instance
    }

    /// [`Layers::triangle`].
    pub fn triangle(&self, number: u32) -> u32 {
        self.hit(number).triangle
    }

    /// [`Layers::source`].
    pub fn source(&self, number: u32) -> u32 {
        let hit = self.hit(number);
        let instance = self.scene.instance_index(hit.instance);
        instance.and_then(|instance| self.scene.source_triangle(instance, hit.triangle)).unwrap_or(NONE)
    }

    /// [`Layers::material`].
    pub fn material(&self, number: u32) -> u32 {
        // 0 is no hit, which becomes NONE.
        self.surface(number).material.wrapping_sub(1)
    }

    /// [`Layers::position`].
    pub fn position(&self, number: u32) -> [f32; 3] {
        let hit = self.hit(number);
        if hit.instance == NONE {
            return [0.0; 3];
        }
        let [x, y] = self.place(number).map(|place| place as f32);
        let Ray { origin, direction, .. } = camera_ray::<f32>(&self.view, x, y);
        let [origin, direction] = [origin, direction].map(|v| DVec3::from(v.lane(0).map(f64::from)));
        (origin + direction * f64::from(hit.t)).as_vec3().to_array()
    }

    /// [`Layers::barycentrics`].
    pub fn barycentrics(&self, number: u32) -> [f32; 2] {
        let hit = self.hit(number);
        [hit.u, hit.v]
    }

    /// [`Layers::uv`].
    pub fn uv(&self, number: u32) -> [f32; 2] {
        self.surface(number).uv
    }

    /// [`Layers::shadow`].
    pub fn shadow(&self, number: u32) -> f32 {
        let [sum, ..] = self.mean(number, |ray| [reached(self.deferred, ray), 0.0, 0.0]);
        sum / self.lights
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

#[cfg(all(test, feature = "import"))]
mod tests {
    use super::*;
    use crate::pose::pixel;
    use glam::{Mat4, Vec3};
    use rtrt_core::backend::{Backend, Shading};
    use rtrt_core::layout::Attribute;
    use rtrt_core::scene::{Bvh, Camera, Light, Material, Mesh, Projection, Sequential};
    use rtrt_cpu::{Cpu, Options};

    /// A triangle in the plane z = 0 whose normals lean outward as those of a ball do, and a ball behind it.
    fn scene() -> Scene {
        let corners = [[-4.0, -3.0, 0.0], [4.0, -3.0, 0.0], [0.0, 4.0, 0.0]];
        let leaning = |[x, y, _]: [f32; 3]| Attribute {
            normal: [x * 0.2, y * 0.2, 1.0],
            uv: [0.0; 2],
            color: Attribute::WHITE,
        };
        let mesh = Mesh::new(corners.to_vec(), corners.map(leaning).to_vec(), vec![0, 1, 2]).unwrap();
        let mut scene = Scene::new();
        let paint = scene.add_material(Material::new([0.8; 3])).unwrap();
        let mesh = scene.add_mesh(&mesh, &Bvh::build(&mesh, &Sequential)).unwrap();
        scene.add_instance(mesh, paint, Mat4::IDENTITY).unwrap();
        let place = Mat4::from_translation(Vec3::new(5.0, 0.0, -3.0)) * Mat4::from_scale(Vec3::splat(3.0));
        scene.add_sphere(paint, place).unwrap();
        scene
    }

    #[test]
    fn positions_are_on_the_surfaces_and_normals_are_means() {
        let scene = scene();
        for projection in [Projection::Perspective { fov_y: 0.8 }, Projection::Orthographic { height: 9.0 }] {
            let camera = Camera { eye: Vec3::new(3.0, 1.0, 12.0), look_at: Vec3::X, up: Vec3::Y, projection };
            let request = Request::new(&camera, [40, 30]).samples(4).deferred(true);
            let mut picture = Picture::default();
            let mut cpu = Cpu::new(Options { lanes: Some(1), threads: Some(1) }).unwrap();
            cpu.render(&scene, &request, &mut picture).unwrap();
            let pixels = Pixels::new(&scene, &request, &picture).unwrap();
            let (mut lifted, mut shorter, mut seen) = (0.0_f32, 0, [0; 2]);
            for number in (0..40 * 30).filter(|number| pixels.object(*number) != NONE) {
                let object = pixels.object(number) as usize;
                seen[object] += 1;
                let position = DVec3::from(pixels.position(number).map(f64::from));
                let off = match object {
                    0 => position.z,
                    _ => (position - DVec3::new(5.0, 0.0, -3.0)).length() - 3.0,
                };
                assert!(off.abs() < 1e-5, "{object}: {position}");
                // The middle of the first of four sub-rays is a quarter of the pixel away from its corner.
                let [x, y] = pixel(&camera, [40, 30], position).unwrap();
                let [column, row] = pixels.grid.pixel(number).map(|place| f64::from(place) + 0.25);
                assert!((x - column).abs() < 1e-3 && (y - row).abs() < 1e-3, "{x} {y}: {column} {row}");
                if object == 0 {
                    lifted = lifted.max(pixels.surface(number).origin[2]);
                }
                let length = DVec3::from(pixels.normal(number).map(f64::from)).length();
                assert!(length < 1.0 + 1e-6);
                shorter += usize::from(length < 0.9);
            }
            // Rays from the triangle do not start on it.
            assert!(lifted > 0.1 && seen[0] > 50 && seen[1] > 50, "{lifted} {seen:?}");
            assert!((10..200).contains(&shorter), "{shorter}");
        }
    }

    #[test]
    fn a_shared_color_counts_for_each_of_its_sub_rays() {
        let mut scene = scene();
        scene.add_light(Light::point([2.0, 4.0, 8.0]));
        let projection = Projection::Perspective { fov_y: 0.8 };
        let camera = Camera { eye: Vec3::new(3.0, 1.0, 12.0), look_at: Vec3::X, up: Vec3::Y, projection };
        let request = Request::new(&camera, [40, 30]).samples(4).shading(Shading::Pixel).deferred(true);
        let mut picture = Picture::default();
        Cpu::new(Options::default()).unwrap().render(&scene, &request, &mut picture).unwrap();
        let pixels = Pixels::new(&scene, &request, &picture).unwrap();
        let mut covered = 0;
        for (number, &pixel) in (0..).zip(&picture.pixels) {
            let [r, g, b, alpha] = pixels.color(number);
            if alpha < 1.0 {
                continue;
            }
            covered += 1;
            let bytes = [r, g, b].map(|c| (srgb_encode(c) * 255.0 + 0.5) as u8);
            assert_eq!(bytes[..], pixel.to_le_bytes()[..3], "{number}");
            let normal = DVec3::from(pixels.normal(number).map(f64::from));
            assert!(normal.length() > 0.5, "{number}: {normal}");
        }
        assert!(covered > 300, "{covered}");
    }
}

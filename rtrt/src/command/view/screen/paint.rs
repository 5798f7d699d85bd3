//! The triangles of the user interface, drawn without a device.

use egui::epaint::{ClippedPrimitive, ImageData, ImageDelta, Mesh, Primitive, Vertex};
use egui::{Color32, Rect, TextureId};
use std::collections::HashMap;

/// Parts of a pixel in which corners are placed.
const PARTS: f32 = 256.0;
/// The largest coordinate of a corner, pixels: products of parts of it fit into 64 bits.
const MOST: f32 = 1e6;

/// The textures of the user interface.
#[derive(Default)]
pub struct Painter {
    textures: HashMap<TextureId, Texture>,
}

/// A texture: texels row by row.
struct Texture {
    size: [usize; 2],
    texels: Vec<Color32>,
}

/// Pixels of a window, row by row: red in bits 16 to 23, green below, blue lowest.
pub struct Canvas<'a> {
    pub pixels: &'a mut [u32],
    pub size: [u32; 2],
}

impl Painter {
    /// Changes a texture, or a part of it.
    pub fn update(&mut self, id: TextureId, delta: &ImageDelta) {
        let ImageData::Color(image) = &delta.image;
        let Some([left, top]) = delta.pos else {
            self.textures.insert(id, Texture { size: image.size, texels: image.pixels.clone() });
            return;
        };
        let Some(texture) = self.textures.get_mut(&id) else { return };
        let [width, height] = image.size;
        if left + width > texture.size[0] || top + height > texture.size[1] {
            return;
        }
        for (y, row) in image.pixels.chunks_exact(width.max(1)).enumerate() {
            let first = (top + y) * texture.size[0] + left;
            texture.texels[first..first + width].copy_from_slice(row);
        }
    }

    /// Forgets a texture.
    pub fn free(&mut self, id: TextureId) {
        self.textures.remove(&id);
    }

    /// Draws meshes. Their coordinates are in units of so many pixels.
    pub fn paint(&self, jobs: &[ClippedPrimitive], scale: f32, canvas: &mut Canvas<'_>) {
        for ClippedPrimitive { clip_rect, primitive } in jobs {
            let Primitive::Mesh(mesh) = primitive else { continue };
            if let Some(texture) = self.textures.get(&mesh.texture_id) {
                paint_mesh(mesh, texture, clip(*clip_rect, scale, canvas.size), scale, canvas);
            }
        }
    }
}

/// The pixels of a rectangle: from `[left, top]` up to, without, `[right, bottom]`.
fn clip(rect: Rect, scale: f32, size: [u32; 2]) -> [[i64; 2]; 2] {
    let most = size.map(i64::from);
    let round = |point: egui::Pos2| {
        let [x, y] = [point.x, point.y].map(|c| (c * scale).round() as i64);
        [x.clamp(0, most[0]), y.clamp(0, most[1])]
    };
    let (low, high) = (round(rect.min), round(rect.max));
    // An empty rectangle may have its corners the other way around.
    [low, [0, 1].map(|axis| high[axis].max(low[axis]))]
}

fn paint_mesh(mesh: &Mesh, texture: &Texture, clip: [[i64; 2]; 2], scale: f32, canvas: &mut Canvas<'_>) {
    for corners in mesh.indices.chunks_exact(3) {
        let corner = |which: usize| mesh.vertices.get(corners[which] as usize);
        if let (Some(a), Some(b), Some(c)) = (corner(0), corner(1), corner(2)) {
            paint_triangle([a, b, c], texture, clip, scale, canvas);
        }
    }
}

/// Draws a triangle: the pixels whose centers it covers. A center on an edge belongs to one of the triangles beside it,
/// so that what is translucent is drawn once.
fn paint_triangle(
    corners: [&Vertex; 3],
    texture: &Texture,
    clip: [[i64; 2]; 2],
    scale: f32,
    canvas: &mut Canvas<'_>,
) {
    let place = |vertex: &Vertex| {
        [vertex.pos.x, vertex.pos.y].map(|c| ((c * scale).clamp(-MOST, MOST) * PARTS) as i64)
    };
    let [a, mut b, mut c] = corners;
    let [p, mut q, mut r] = [place(a), place(b), place(c)];
    let mut area = cross(p, q, r);
    if area < 0 {
        ((q, r), (b, c)) = ((r, q), (c, b));
        area = -area;
    }
    if area == 0 {
        return;
    }
    let parts = PARTS as i64;
    let [low, high] = [0, 1].map(|end| {
        [0, 1].map(|axis| {
            let all = [p[axis], q[axis], r[axis]];
            let edge = if end == 0 { all.iter().min() } else { all.iter().max() };
            let pixel = edge.map_or(0, |edge| edge.div_euclid(parts));
            (pixel + end as i64).clamp(clip[0][axis], clip[1][axis])
        })
    });
    let is_plain = a.color == b.color && b.color == c.color && a.uv == b.uv && b.uv == c.uv;
    let plain = is_plain.then(|| texture.tinted(a.uv, a.color));
    for y in low[1]..high[1] {
        let row = &mut canvas.pixels[(y * i64::from(canvas.size[0])) as usize..];
        let mut was_inside = false;
        for x in low[0]..high[0] {
            let center = [x * parts + parts / 2, y * parts + parts / 2];
            let [u, v, w] = [inside(q, r, center), inside(r, p, center), inside(p, q, center)];
            let (Some(u), Some(v), Some(w)) = (u, v, w) else {
                if was_inside {
                    break;
                }
                continue;
            };
            was_inside = true;
            let source = plain.unwrap_or_else(|| {
                let [u, v, w] = [u, v, w].map(|part| part as f32 / area as f32);
                let uv = (a.uv.to_vec2() * u + b.uv.to_vec2() * v + c.uv.to_vec2() * w).to_pos2();
                let color = [0, 1, 2, 3].map(|channel| {
                    let [a, b, c] = [a, b, c].map(|vertex| f32::from(vertex.color.to_array()[channel]));
                    (a * u + b * v + c * w).round() as u8
                });
                let [red, green, blue, alpha] = color;
                texture.tinted(uv, Color32::from_rgba_premultiplied(red, green, blue, alpha))
            });
            let pixel = &mut row[x as usize];
            *pixel = over(source, *pixel);
        }
    }
}

/// Twice the area of a triangle; more than 0 if its corners go clockwise on the screen.
fn cross(a: [i64; 2], b: [i64; 2], c: [i64; 2]) -> i64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// The part of the triangle between an edge and a point, if the point lies on its inner side, or on it where the edge is
/// at the top or on the left.
fn inside(from: [i64; 2], to: [i64; 2], point: [i64; 2]) -> Option<i64> {
    let part = cross(from, to, point);
    let is_top_or_left = to[1] < from[1] || (to[1] == from[1] && to[0] > from[0]);
    (part > 0 || part == 0 && is_top_or_left).then_some(part)
}

impl Texture {
    /// The nearest texel, times a color.
    fn tinted(&self, uv: egui::Pos2, color: Color32) -> Color32 {
        let [width, height] = self.size;
        let at = |c: f32, count: usize| ((c * count as f32) as usize).min(count.saturating_sub(1));
        let texel = self.texels.get(at(uv.y, height) * width + at(uv.x, width));
        let (texel, color) = (texel.map_or([0; 4], Color32::to_array), color.to_array());
        let [r, g, b, a] = [0, 1, 2, 3].map(|c| product(u32::from(texel[c]), u32::from(color[c])) as u8);
        Color32::from_rgba_premultiplied(r, g, b, a)
    }
}

/// A premultiplied color over a pixel.
fn over(source: Color32, pixel: u32) -> u32 {
    let [r, g, b, alpha] = source.to_array().map(u32::from);
    let through = |place: u32| product(pixel >> place & 0xff, 255 - alpha);
    let [r, g, b] = [r + through(16), g + through(8), b + through(0)].map(|c| c.min(255));
    r << 16 | g << 8 | b
}

/// The product of two shares of 255, rounded.
fn product(a: u32, b: u32) -> u32 {
    (a * b + 127) / 255
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::{ColorImage, pos2};
    use std::sync::Arc;

    /// A canvas of 8 x 8 white pixels, with a mesh drawn on it at twice its size.
    fn drawn(mesh: Mesh, clip: Rect) -> Vec<u32> {
        let mut painter = Painter::default();
        let image = ColorImage::new([2, 1], vec![Color32::WHITE, Color32::TRANSPARENT]);
        painter.update(
            TextureId::default(),
            &ImageDelta { image: ImageData::Color(Arc::new(image)), options: Default::default(), pos: None },
        );
        let mut pixels = vec![0xff_ffff; 64];
        let job = ClippedPrimitive { clip_rect: clip, primitive: Primitive::Mesh(mesh) };
        painter.paint(&[job], 2.0, &mut Canvas { pixels: &mut pixels, size: [8, 8] });
        pixels
    }

    fn rectangle(low: [f32; 2], high: [f32; 2], uv: [f32; 2], color: Color32) -> Mesh {
        let mut mesh = Mesh::default();
        let rect = Rect::from_min_max(low.into(), high.into());
        mesh.add_rect_with_uv(rect, Rect::from_min_max(pos2(uv[0], 0.0), pos2(uv[1], 1.0)), color);
        mesh
    }

    #[test]
    fn two_translucent_triangles_cover_each_pixel_once() {
        let half_black = Color32::from_rgba_premultiplied(0, 0, 0, 128);
        let seen = drawn(rectangle([1.0, 0.5], [3.0, 3.0], [0.0, 0.0], half_black), Rect::EVERYTHING);
        for (number, pixel) in seen.iter().enumerate() {
            let (x, y) = (number % 8, number / 8);
            let is_covered = (2..6).contains(&x) && (1..6).contains(&y);
            assert_eq!(*pixel, if is_covered { 0x7f_7f7f } else { 0xff_ffff }, "{x} {y}");
        }
    }

    #[test]
    fn what_is_clipped_or_transparent_is_not_drawn() {
        let clip = Rect::from_min_max(pos2(0.0, 0.0), pos2(4.0, 1.0));
        let seen = drawn(rectangle([0.0, 0.0], [4.0, 4.0], [0.0, 1.0], Color32::RED), clip);
        let red = |number: &usize| seen[*number] == 0xff_0000;
        assert_eq!((0..64).filter(red).collect::<Vec<_>>(), [0, 1, 2, 3, 8, 9, 10, 11]);
        let white = seen.iter().filter(|pixel| **pixel == 0xff_ffff).count();
        assert_eq!(white, 64 - 8);
    }

    #[test]
    fn colors_are_interpolated_between_corners() {
        let mut mesh = rectangle([0.0, 0.0], [4.0, 4.0], [0.0, 0.0], Color32::BLACK);
        for vertex in &mut mesh.vertices {
            vertex.color = if vertex.pos.x > 0.0 { Color32::WHITE } else { Color32::BLACK };
        }
        let seen = drawn(mesh, Rect::EVERYTHING);
        let row: Vec<u32> = seen[..8].iter().map(|pixel| pixel & 0xff).collect();
        assert_eq!(row, [16, 48, 80, 112, 143, 175, 207, 239]);
    }

    #[test]
    fn odd_meshes_are_no_error() {
        let mut mesh = rectangle([-1e9, f32::NAN], [1e9, 1e9], [f32::NAN, 7.0], Color32::RED);
        mesh.indices.push(77);
        drawn(mesh, Rect::NOTHING);
    }
}

//! Pixels into a texture of an application's.

use crate::error::Error;
use rtrt_core::layout::Frame;

/// Whether a frame can be rendered into the texture.
pub fn check(texture: &wgpu::Texture, frame: &Frame) -> Result<(), Error> {
    let wrong = |is: String, needed: String| Err(Error::Texture { is, needed });
    let (size, needed) = (texture.size(), [frame.width, frame.height, 1]);
    if [size.width, size.height, size.depth_or_array_layers] != needed {
        return wrong(format!("the size {size:?}"), format!("{needed:?}"));
    }
    let format = texture.format();
    if format.remove_srgb_suffix() != wgpu::TextureFormat::Rgba8Unorm {
        return wrong(format!("the format {format:?}"), "Rgba8Unorm or Rgba8UnormSrgb".into());
    }
    if !texture.usage().contains(wgpu::TextureUsages::COPY_DST) || texture.sample_count() != 1 {
        let is = format!("the usage {:?} and {} samples", texture.usage(), texture.sample_count());
        return wrong(is, "COPY_DST and 1 sample".into());
    }
    Ok(())
}

/// Appends the copy of whole rows of pixels to where they are in a texture, the `first` of them
/// from behind those `skipped` in the buffer: all at once where rows are aligned as copies want
/// it, else one by one.
pub fn copy(
    commands: &mut wgpu::CommandEncoder,
    pixels: &wgpu::Buffer,
    skipped: u32,
    width: u32,
    [first, count]: [u32; 2],
    texture: &wgpu::Texture,
) {
    let (row_bytes, rows) = (4 * width, count / width);
    let at_once = if row_bytes.is_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT) { rows } else { 1 };
    for row in (0..rows).step_by(at_once.max(1) as usize) {
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 4 * u64::from(skipped) + u64::from(row * row_bytes),
            bytes_per_row: (at_once > 1).then_some(row_bytes),
            rows_per_image: None,
        };
        let origin = wgpu::Origin3d { x: 0, y: first / width + row, z: 0 };
        let to = wgpu::TexelCopyTextureInfo { origin, ..texture.as_image_copy() };
        let extent = wgpu::Extent3d { width, height: at_once, depth_or_array_layers: 1 };
        commands.copy_buffer_to_texture(wgpu::TexelCopyBufferInfo { buffer: pixels, layout }, to, extent);
    }
}

#[cfg(test)]
mod tests {
    use crate::{Gpu, Options};
    use rtrt_core::backend::{Backend, Picture, Request, Shadows};
    use rtrt_core::scene::{Camera, Light, Panorama, Projection, Scene};
    use wgpu::BufferUsages;

    /// The bytes of a texture.
    fn texels(gpu: &Gpu, texture: &wgpu::Texture) -> Vec<u8> {
        let device = &gpu.renderer.device;
        let padded = (4 * texture.width()).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let bytes = u64::from(padded * texture.height());
        let usage = BufferUsages::MAP_READ | BufferUsages::COPY_DST;
        let buffer = device.buffer("texels", bytes, usage).unwrap();
        let mut commands = device.device.create_command_encoder(&Default::default());
        let layout =
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(padded), rows_per_image: None };
        let to = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
        commands.copy_texture_to_buffer(texture.as_image_copy(), to, texture.size());
        let mut rows = vec![];
        device.queue.submit([commands.finish()]);
        let read = device.read(&buffer, bytes, |mapped| {
            let row = 4 * texture.width() as usize;
            mapped.chunks(padded as usize).for_each(|padded| rows.extend_from_slice(&padded[..row]));
        });
        pollster::block_on(read).unwrap();
        rows
    }

    #[test]
    fn a_texture_gets_the_picture_whatever_its_rows_and_bands() {
        // Bands of soft shadows begin before the pixels that are kept.
        let soft = [([128, 50], Some(1), Shadows::Soft), ([75, 50], Some(1), Shadows::Soft)];
        let hard = [([128, 50], None), ([128, 50], Some(1)), ([75, 50], None), ([75, 50], Some(1))];
        let hard = hard.map(|(size, band_bytes)| (size, band_bytes, Shadows::Hard));
        for (size, band_bytes, shadows) in hard.into_iter().chain(soft) {
            let mut gpu = match Gpu::new(Options { band_bytes, ..Options::default() }) {
                Ok(gpu) => gpu,
                Err(error) if std::env::var_os("RTRT_REQUIRE_GPU").is_some() => panic!("{error}"),
                Err(error) => return println!("skipped: {error}"),
            };
            let camera = Camera {
                eye: [0.0, 0.0, 3.0].into(),
                look_at: [0.0; 3].into(),
                up: [0.0, 1.0, 0.0].into(),
                projection: Projection::Perspective { fov_y: 1.0 },
            };
            let request = Request::new(&camera, size).samples(4).shadows(shadows).deferred(true);
            // The picture is the sky, a gradient.
            let mut scene = Scene::new();
            let rgb = (0..64).map(|i| [i as f32 / 64.0, (i % 8) as f32 / 8.0, 0.5]).collect();
            scene.set_environment(&Panorama { width: 8, height: 8, rgb }).unwrap();
            let direction = [1.0, -1.0, 0.5];
            scene.add_light(Light::sun(direction).radius(0.02));
            let mut picture = Picture::default();
            gpu.render(&scene, &request, &mut picture).unwrap();
            let texture = gpu.renderer.device.device.create_texture(&wgpu::TextureDescriptor {
                label: None,
                size: wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: wgpu::TextureFormat::Rgba8Unorm,
                usage: wgpu::TextureUsages::COPY_DST | wgpu::TextureUsages::COPY_SRC,
                view_formats: &[],
            });
            let times = gpu.render_into(&texture, &scene, &request).unwrap();
            assert!(times.iter().sum::<f64>() > 0.0);
            assert_eq!(texels(&gpu, &texture), *picture.bytes());
            assert!(picture.pixels.iter().any(|pixel| *pixel != picture.pixels[0]));
        }
    }
}

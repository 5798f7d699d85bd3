//! Hybrid frames on a GPU: the draw calls, and the passes that read their picture.
//!
//! What is drawn and why is in [`rtrt_core::stage::raster`]. On this side:
//!
//! - Vertices are read by number from the buffers that rays are traced in: no vertex buffers, no copy,
//!   and a mesh that moves has moved here too. An index buffer was refused: its vertices would be shared
//!   between triangles, and a fragment then knows its triangle's number only by an optional feature.
//! - Each instance is a draw call. The host runs the kernel of `prepare` and skips instances that cover
//!   nothing.
//! - The picture is copied into a buffer, so kernels read no images and the lint allows none.

use crate::barriers::ZERO_GROUP;
use crate::buffers::Buffers;
use crate::device::Device;
use crate::entry::{FRAGMENT, VERTEX, VERTEX_SLOTS, vertex_accesses};
use crate::error::Error;
use crate::pipeline::{bind_group, bind_group_layout, pipeline_layout};
use crate::slot::Slot;
use crate::timer::Timer;
use rtrt_core::grid::{BLOCK, BLOCK_RAYS};
use rtrt_core::kernel::project::ClipWindow;
use rtrt_core::kernel::screen_bounds::ScreenBounds;
use rtrt_core::layout::{Frame, View};
use rtrt_core::scene::{Scene, Setup};
use rtrt_core::schedule::Stage;
use rtrt_core::stage;
use rtrt_core::stage::raster::{Drawn, is_in, pitch};
use wgpu::{BufferUsages, ShaderStages, TextureFormat};

/// An instance and a triangle.
const NUMBERS: TextureFormat = TextureFormat::Rg32Uint;
const DEPTH: TextureFormat = TextureFormat::Depth32Float;

/// Bytes from one window to the next: what every device can bind.
const STEP: u64 = 256;

/// What draws.
pub(crate) struct Raster {
    draw: wgpu::RenderPipeline,
    layout: wgpu::BindGroupLayout,
    /// The numbers of the windows.
    uniforms: Option<wgpu::Buffer>,
    windows: Vec<ClipWindow>,
    target: Option<[wgpu::Texture; 2]>,
    /// Vertices of each instance, and its bounds on the screen.
    instances: Vec<(u32, ScreenBounds)>,
    camera: Option<View>,
}

impl Raster {
    /// Compiles the render pipelines.
    pub fn new(device: &Device) -> Self {
        let layout = bind_group_layout(&device.device, VERTEX, ShaderStages::VERTEX, vertex_accesses());
        let draw = device.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(VERTEX),
            layout: Some(&pipeline_layout(&device.device, VERTEX, &layout, device.zero.as_ref())),
            vertex: wgpu::VertexState {
                module: &device.module(VERTEX),
                entry_point: Some(VERTEX),
                compilation_options: Default::default(),
                buffers: &[],
            },
            primitive: Default::default(),
            depth_stencil: Some(wgpu::DepthStencilState {
                format: DEPTH,
                depth_write_enabled: Some(true),
                // Of two as near, the first: as the closest hit is the one of the lower number.
                depth_compare: Some(wgpu::CompareFunction::Greater),
                stencil: Default::default(),
                bias: Default::default(),
            }),
            multisample: Default::default(),
            fragment: Some(wgpu::FragmentState {
                module: &device.module(FRAGMENT),
                entry_point: Some(FRAGMENT),
                compilation_options: Default::default(),
                targets: &[Some(NUMBERS.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        Self {
            draw,
            layout,
            uniforms: None,
            windows: Vec::new(),
            target: None,
            instances: Vec::new(),
            camera: None,
        }
    }

    /// Begins a frame: computes the bounds of each instance on the screen.
    pub fn begin(&mut self, scene: &Scene, setup: &Setup) {
        let instances = setup.instances(scene);
        let cover = |index: u32| stage::prepare::prepare(&setup.frame, &setup.views, instances, index);
        self.instances.clear();
        self.instances
            .extend((0..).zip(instances).map(|(index, instance)| (3 * instance.triangles, cover(index))));
        self.camera = setup.views.get(Frame::CAMERA as usize).copied();
    }

    /// Makes room for the pictures of a band.
    pub fn reserve(&mut self, device: &Device, frame: &Frame) -> Result<(), Error> {
        let side = device.device.limits().max_texture_dimension_2d / BLOCK;
        self.windows.clear();
        self.windows.extend(windows(frame, side));
        let bytes = self.windows.len() as u64 * STEP;
        if self.uniforms.as_ref().is_none_or(|buffer| buffer.size() < bytes) {
            let usage = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
            self.uniforms = Some(device.buffer("windows", bytes, usage)?);
        }
        let most =
            |length: fn(&ClipWindow) -> u32| self.windows.iter().map(length).max().unwrap_or(1) * BLOCK;
        let [width, height] = [most(|window| window.columns), most(|window| window.rows)];
        let is_large =
            |target: &[wgpu::Texture; 2]| target[0].width() >= width && target[0].height() >= height;
        if !self.target.as_ref().is_some_and(is_large) {
            self.target = None;
            self.target = Some([NUMBERS, DEPTH].map(|format| {
                device.device.create_texture(&wgpu::TextureDescriptor {
                    label: Some("drawn"),
                    size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
                    mip_level_count: 1,
                    sample_count: 1,
                    dimension: wgpu::TextureDimension::D2,
                    format,
                    usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
                    view_formats: &[],
                })
            }));
        }
        if let Some(uniforms) = &self.uniforms {
            for (number, window) in (0..).zip(&self.windows) {
                device.queue.write_buffer(uniforms, number * STEP, bytemuck::bytes_of(window));
            }
        }
        Ok(())
    }

    /// Appends the drawing of a band to the commands: window after window, copied to where the rays
    /// look for it. It begins the stage.
    pub fn encode(
        &self,
        device: &Device,
        commands: &mut wgpu::CommandEncoder,
        timer: &Timer,
        frame: &Frame,
        buffers: &Buffers,
    ) {
        let (Some([numbers, depth]), Some(uniforms), Some(camera), Some(drawn)) =
            (&self.target, &self.uniforms, &self.camera, buffers.get(Slot::Drawn))
        else {
            return;
        };
        let [numbers_view, depth_view] =
            [numbers, depth].map(|texture| texture.create_view(&Default::default()));
        let first_row = self.windows.first().map_or(0, |window| window.row);
        for (at, window) in self.windows.iter().enumerate() {
            let mut pass = commands.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some(VERTEX),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: &numbers_view,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations {
                        load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                        store: wgpu::StoreOp::Store,
                    },
                })],
                depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                    view: &depth_view,
                    depth_ops: Some(wgpu::Operations {
                        load: wgpu::LoadOp::Clear(0.0),
                        store: wgpu::StoreOp::Discard,
                    }),
                    stencil_ops: None,
                }),
                timestamp_writes: timer.writes_of_drawing(Stage::Visibility, at == 0),
                occlusion_query_set: None,
                multiview_mask: None,
            });
            let window_at = wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                buffer: uniforms,
                offset: at as u64 * STEP,
                size: wgpu::BufferSize::new(size_of::<ClipWindow>() as u64),
            });
            let bound = |slot: &Slot| buffers.get(*slot).map(wgpu::Buffer::as_entire_binding);
            let (of_frame, others) = VERTEX_SLOTS.split_at(1);
            let resources =
                of_frame.iter().filter_map(bound).chain([window_at]).chain(others.iter().filter_map(bound));
            pass.set_pipeline(&self.draw);
            pass.set_bind_group(0, &bind_group(&device.device, &self.layout, resources), &[]);
            if let Some(zero) = &device.zero {
                pass.set_bind_group(ZERO_GROUP, &zero.group, &[]);
            }
            let [width, height] = [window.columns, window.rows].map(|blocks| blocks * BLOCK);
            pass.set_viewport(0.0, 0.0, width as f32, height as f32, 0.0, 1.0);
            pass.set_scissor_rect(0, 0, width, height);
            for (index, (vertices, _)) in (0..)
                .zip(&self.instances)
                .filter(|(_, (vertices, cover))| *vertices > 0 && is_in(frame, camera, window, cover))
            {
                pass.draw(0..*vertices, index..index + 1);
            }
            drop(pass);
            let row = u64::from(pitch(frame)) * size_of::<Drawn>() as u64;
            let (x, y) = (window.column * BLOCK, (window.row - first_row) * BLOCK);
            commands.copy_texture_to_buffer(
                numbers.as_image_copy(),
                wgpu::TexelCopyBufferInfo {
                    buffer: drawn,
                    layout: wgpu::TexelCopyBufferLayout {
                        offset: u64::from(y) * row + u64::from(x) * size_of::<Drawn>() as u64,
                        bytes_per_row: Some(row as u32),
                        rows_per_image: None,
                    },
                },
                wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            );
        }
    }
}

/// The blocks of a band in rectangles of at most so many on a side.
fn windows(frame: &Frame, side: u32) -> impl Iterator<Item = ClipWindow> + use<> {
    let columns = frame.grid().blocks_x();
    let [first, rows] = [frame.first_ray, frame.rays].map(|rays| rays / (columns * BLOCK_RAYS));
    let step = side.max(1) as usize;
    (first..first + rows).step_by(step).flat_map(move |row| {
        (0..columns).step_by(step).map(move |column| ClipWindow {
            column,
            row,
            columns: side.min(columns - column),
            rows: side.min(first + rows - row),
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    #[test]
    fn windows_are_all_blocks_of_a_band_once() {
        let frame = Frame { width: 100, height: 90, side: 1, ..Frame::zeroed() };
        let band = Frame { first_ray: 7 * BLOCK_RAYS, rays: 4 * 7 * BLOCK_RAYS, ..frame };
        let mut drawn = [[0; 7]; 6];
        for window in windows(&band, 3) {
            assert!(window.columns <= 3 && window.rows <= 3);
            for row in window.row..window.row + window.rows {
                for column in window.column..window.column + window.columns {
                    drawn[row as usize][column as usize] += 1;
                }
            }
        }
        assert_eq!(drawn, [[0; 7], [1; 7], [1; 7], [1; 7], [1; 7], [0; 7]]);
        let whole = ClipWindow { column: 0, row: 1, columns: 7, rows: 4 };
        assert_eq!(windows(&band, 1024).collect::<Vec<_>>(), [whole]);
    }
}

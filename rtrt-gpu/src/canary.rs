//! The canary: checks that a device computes the CPU's numbers before it is trusted.

use crate::device::{Device, watched};
use crate::entry::{Access, KERNELS, PROBE, groups};
use crate::error::Error;
use rtrt_core::kernel::canary::{Fixture, NAMES, OUTPUTS, canary, first_difference};
use rtrt_core::layout::{
    Attribute, Frame, Hit, Instance, MaterialRecord, Node, PROBES, Surface, View, probe,
};

/// Compares the device's answers with the CPU's.
pub(crate) async fn check(device: &Device) -> Result<(), Error> {
    let words = words();
    let answers = watched(&device.device, kernels(device, &words)).await?;
    let Some((case, output)) = first_difference(&words, &answers) else { return Ok(()) };
    Err(Error::Canary {
        adapter: device.name.clone(),
        what: NAMES[output],
        case,
        cpu: canary::<f32>((), &words, &Fixture::default().given(), case as u32)[output].0,
        gpu: answers[case][output],
    })
}

/// The kernels' answers to every run of words.
pub(crate) async fn kernels(device: &Device, words: &[u32]) -> Result<Vec<[u32; OUTPUTS]>, Error> {
    let bytes = (words.len() * size_of::<[u32; OUTPUTS]>()) as u64;
    let fixture = Fixture::default();
    let given = fixture.given();
    let inputs = [
        bytemuck::bytes_of(given.frame),
        bytemuck::cast_slice(words),
        bytemuck::cast_slice(given.views),
        bytemuck::cast_slice(given.instances),
        bytemuck::cast_slice(given.maps.materials),
        bytemuck::cast_slice(given.maps.texels),
    ];
    let answers = run(device, KERNELS, &inputs, bytes, groups([words.len() as u32, 1])).await?;
    Ok(bytemuck::pod_collect_to_vec(&answers))
}

/// Where the device finds fields: [`rtrt_core::layout::probe`] of elements that are filled
/// with [`pattern`].
pub(crate) async fn layout(device: &Device) -> Result<[u32; PROBES], Error> {
    fn pair<T: bytemuck::Pod>() -> Vec<u8> {
        bytemuck::bytes_of(&pattern::<[T; 2]>()).to_vec()
    }
    let frame = bytemuck::bytes_of(&pattern::<Frame>()).to_vec();
    let buffers = [
        frame,
        pair::<View>(),
        pair::<Instance>(),
        pair::<Node>(),
        pair::<Attribute>(),
        pair::<MaterialRecord>(),
        pair::<Surface>(),
        pair::<Hit>(),
    ];
    let inputs: Vec<&[u8]> = buffers.iter().map(Vec::as_slice).collect();
    let found = run(device, PROBE, &inputs, 4 * PROBES as u64, [1, 1, 1]).await?;
    let mut words = [0; PROBES];
    words.copy_from_slice(&bytemuck::pod_collect_to_vec::<u8, u32>(&found));
    Ok(words)
}

/// What [`layout`] must give.
pub(crate) fn expected_layout() -> [u32; PROBES] {
    probe(
        &pattern(),
        &pattern::<[View; 2]>(),
        &pattern::<[Instance; 2]>(),
        &pattern::<[Node; 2]>(),
        &pattern::<[Attribute; 2]>(),
        &pattern::<[MaterialRecord; 2]>(),
        &pattern::<[Surface; 2]>(),
        &pattern::<[Hit; 2]>(),
    )
}

/// A value whose words tell where they are: word `i` is `1.0`'s bits plus `i`.
fn pattern<T: bytemuck::Pod>() -> T {
    let words: Vec<u32> = (0..size_of::<T>() as u32 / 4).map(|i| 1.0_f32.to_bits() + i).collect();
    bytemuck::pod_read_unaligned(bytemuck::cast_slice(&words))
}

/// Runs an entry point once: `inputs` are bound from 0 on, then the output, which is read
/// back.
async fn run(
    device: &Device,
    (entry, accesses): (&str, &[Access]),
    inputs: &[&[u8]],
    output_bytes: u64,
    groups: [u32; 3],
) -> Result<Vec<u8>, Error> {
    let pipeline = device.pipeline(entry, accesses.iter().copied());
    let mut buffers = Vec::new();
    for (access, input) in accesses.iter().zip(inputs) {
        let usage = if *access == Access::Uniform {
            wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST
        } else {
            wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST
        };
        let buffer = device.buffer("canary", input.len() as u64, usage)?;
        device.queue.write_buffer(&buffer, 0, input);
        buffers.push(buffer);
    }
    let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
    buffers.push(device.buffer("canary", output_bytes, usage)?);
    let mut commands = device.device.create_command_encoder(&Default::default());
    {
        let mut pass = commands.begin_compute_pass(&Default::default());
        pipeline.dispatch(&mut pass, &pipeline.group(&device.device, buffers.iter()), groups);
    }
    device.queue.submit([commands.finish()]);
    device.fetch(&buffers[inputs.len()], output_bytes).await
}

/// Edge values, then numbers of everyday size: some thousand cases.
fn words() -> Vec<u32> {
    let edges = [
        0.0,
        1.0,
        0.5,
        2.0,
        3.0,
        0.003_130_8,
        0.040_45,
        core::f32::consts::SQRT_2,
        core::f32::consts::FRAC_1_SQRT_2,
        126.5,
        127.0,
        1e-38,
        1e-40,
        1e-28,
        1e28,
        1e38,
        4_194_303.5,
        f32::EPSILON,
        f32::MIN_POSITIVE,
        f32::MAX,
        f32::INFINITY,
        f32::NAN,
    ];
    let mut words: Vec<u32> = edges.iter().flat_map(|x| [x.to_bits(), (-x).to_bits()]).collect();
    let mut state = 1_u32;
    while words.len() < 4096 {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        // Both signs, exponents from 2⁻⁷ to 2⁸.
        let exponent = 120 + (state >> 5 & 15);
        words.push(state & 0x8000_0000 | exponent << 23 | state >> 8 & 0x7f_ffff);
    }
    words
}

//! How long each stage takes, and how long the host works for a frame.

use crate::device::Device;
use crate::error::Error;
use rtrt_core::schedule::Stage;
use web_time::Instant;
use wgpu::{BufferUsages, Features};

/// Two times a stage: before and after.
const TIMES: u32 = 2 * Stage::COUNT as u32;

/// Takes the time of stages: on the device, or, where it has no clock, by waiting for each
/// stage.
pub(crate) enum Timer {
    /// The device writes down when a stage begins and ends.
    Device {
        /// Where it writes.
        queries: wgpu::QuerySet,
        /// Where the numbers are copied to.
        times: wgpu::Buffer,
        /// Milliseconds in one unit.
        unit_ms: f64,
    },
    /// The host waits.
    Host,
}

impl Timer {
    /// The best that the device has.
    pub fn new(device: &Device) -> Result<Self, Error> {
        if !device.device.features().contains(Features::TIMESTAMP_QUERY) {
            return Ok(Self::Host);
        }
        let queries = device.device.create_query_set(&wgpu::QuerySetDescriptor {
            label: None,
            ty: wgpu::QueryType::Timestamp,
            count: TIMES,
        });
        let usage = BufferUsages::QUERY_RESOLVE | BufferUsages::COPY_SRC;
        let times = device.buffer("times", u64::from(8 * TIMES), usage)?;
        let unit_ms = f64::from(device.queue.get_timestamp_period()) * 1e-6;
        Ok(Self::Device { queries, times, unit_ms })
    }

    /// What one of a stage's passes has to write, the first and the last of them their part.
    pub fn writes(
        &self,
        stage: Stage,
        is_first: bool,
        is_last: bool,
    ) -> Option<wgpu::ComputePassTimestampWrites<'_>> {
        let Self::Device { queries, .. } = self else { return None };
        if !is_first && !is_last {
            return None;
        }
        Some(wgpu::ComputePassTimestampWrites {
            query_set: queries,
            beginning_of_pass_write_index: is_first.then_some(2 * stage as u32),
            end_of_pass_write_index: is_last.then_some(2 * stage as u32 + 1),
        })
    }

    /// What a pass that draws has to write: it is never the last of its stage.
    pub fn writes_of_drawing(
        &self,
        stage: Stage,
        is_first: bool,
    ) -> Option<wgpu::RenderPassTimestampWrites<'_>> {
        let writes = self.writes(stage, is_first, false)?;
        Some(wgpu::RenderPassTimestampWrites {
            query_set: writes.query_set,
            beginning_of_pass_write_index: writes.beginning_of_pass_write_index,
            end_of_pass_write_index: None,
        })
    }

    /// Ends a stage: without a clock on the device, hands it the commands and waits.
    pub async fn end_stage(
        &self,
        device: &Device,
        commands: &mut wgpu::CommandEncoder,
        clock: &mut HostClock,
        stage: Stage,
        stages_ms: &mut [f64],
    ) -> Result<(), Error> {
        if matches!(self, Self::Host) {
            let next = device.device.create_command_encoder(&Default::default());
            let start = Instant::now();
            device.queue.submit([std::mem::replace(commands, next).finish()]);
            clock.pause();
            device.finished().await?;
            clock.resume();
            stages_ms[stage as usize] += start.elapsed().as_secs_f64() * 1e3;
        }
        Ok(())
    }

    /// Copies the times to `to`.
    pub fn copy(&self, commands: &mut wgpu::CommandEncoder, to: &wgpu::Buffer, offset: u64) {
        if let Self::Device { queries, times, .. } = self {
            commands.resolve_query_set(queries, 0..TIMES, times, 0);
            commands.copy_buffer_to_buffer(times, 0, to, offset, u64::from(8 * TIMES));
        }
    }

    /// Adds the times that were copied to the stages' milliseconds.
    pub fn add(&self, copied: &[u8], first_stage: Stage, stages_ms: &mut [f64]) {
        let Self::Device { unit_ms, .. } = self else { return };
        let time = |index: usize| bytemuck::pod_read_unaligned::<u64>(&copied[8 * index..8 * index + 8]);
        for (stage, ms) in stages_ms.iter_mut().enumerate().skip(first_stage as usize) {
            // A clock that steps back is no clock.
            *ms += time(2 * stage + 1).saturating_sub(time(2 * stage)) as f64 * unit_ms;
        }
    }
}

/// Takes the time in which the host works for a frame.
pub(crate) struct HostClock {
    since: Instant,
    /// Milliseconds up to the last pause.
    pub ms: f64,
}

impl HostClock {
    /// It works from now on.
    pub fn start() -> Self {
        Self { since: Instant::now(), ms: 0.0 }
    }

    /// It waits from now on.
    pub fn pause(&mut self) {
        self.ms += self.since.elapsed().as_secs_f64() * 1e3;
    }

    /// It works again.
    pub fn resume(&mut self) {
        self.since = Instant::now();
    }
}

//! Rays of other programs, on a device.

use crate::Gpu;
use crate::array::Array;
use crate::device::{Device, watched};
use crate::entry::{QUERY_CLOSEST, QUERY_OCCLUDED, groups};
use crate::error::Error;
use crate::pipeline::Pipeline;
use crate::wait::Waiting;
use bytemuck::Pod;
use rtrt_core::layout::{Hit as HitRecord, QueryFrame, RayRecord};
use rtrt_core::query::{Changed, DeviceChanges, DeviceWorld, Hit, QueryError, Ray};
use rtrt_core::scene::{Join, Scene};
use std::mem::take;
use wgpu::BufferUsages;

/// Rays that one dispatch of slices asks.
const BATCH: usize = 1 << 20;

/// A scene on a device, as it was when [`Gpu::world`] or [`World::update`] was called last. It answers rays.
///
/// Answers have the bits of [`rtrt_core::query::World`]. The whole scene is copied, and a tree over its
/// instances is built; an update copies what has changed since.
///
/// ```no_run
/// use rtrt_core::query::Ray;
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let scene = rtrt_core::scene::Scene::new();
/// let gpu = rtrt_gpu::Gpu::new(rtrt_gpu::Options::default())?;
/// let mut world = gpu.world(&scene, &rtrt_core::scene::Sequential)?;
/// let rays = vec![Ray::new([0.0; 3], [0.0, 0.0, -1.0]); 1000];
/// let mut hits = vec![Ok(None); 1000];
/// world.closest(&rays, &mut hits)?;
/// // Something moves.
/// world.update(&scene, &rtrt_core::scene::Sequential)?;
/// world.closest(&rays, &mut hits)?;
/// # Ok(())
/// # }
/// ```
pub struct World {
    device: Device,
    world: DeviceWorld,
    /// The instances, nodes, mesh data, positions, texels and masks.
    arrays: [Array; 6],
    queries: Queries,
}

/// What asks rays.
#[derive(Clone, PartialEq)]
pub(crate) struct Queries {
    closest: Pipeline,
    occluded: Pipeline,
}

impl Queries {
    fn new(device: &Device) -> Self {
        let pipeline = |(name, accesses): (&str, &[_])| device.pipeline(name, accesses.iter().copied());
        Self { closest: pipeline(QUERY_CLOSEST), occluded: pipeline(QUERY_OCCLUDED) }
    }
}

impl Gpu {
    /// Copies a scene to the device, for rays. Workers of `join` build the tree over its instances.
    ///
    /// # Errors
    /// A buffer would be larger than the device allows, or the device failed.
    #[cfg(not(target_arch = "wasm32"))]
    pub fn world(&self, scene: &Scene, join: &impl Join) -> Result<World, Error> {
        pollster::block_on(self.world_async(scene, join))
    }

    /// [`Gpu::world`] without blocking.
    ///
    /// # Errors
    /// As there.
    pub async fn world_async(&self, scene: &Scene, join: &impl Join) -> Result<World, Error> {
        let device = self.renderer.device.clone();
        let queries = match self.queries.get() {
            Some(queries) => queries,
            None => {
                let compiled = watched(&device.device, async { Ok(Queries::new(&device)) }).await?;
                self.queries.get_or_init(|| compiled)
            }
        };
        let queries = queries.clone();
        let mut world = watched(&device.device, async {
            let arrays = [
                Array::new(&device, "instances", 0)?,
                Array::new(&device, "nodes", 0)?,
                Array::new(&device, "mesh data", 0)?,
                Array::new(&device, "positions", 0)?,
                Array::new(&device, "texels", 0)?,
                Array::new(&device, "masks", 0)?,
            ];
            Ok(World { device: device.clone(), world: DeviceWorld::default(), arrays, queries })
        })
        .await?;
        world.update_async(scene, join).await?;
        Ok(world)
    }
}

impl World {
    /// Follows to the scene as it is now, which may be another one: answers are then those of a new world of it.
    ///
    /// | since the last call | what is computed and copied |
    /// |---|---|
    /// | instances were moved, hidden, shown or removed, or got other masks | those, and the boxes of the tree above them |
    /// | many of them | all instances; the tree is built again, by workers of `join`, if it has become bad |
    /// | a mesh was added, removed, or has another shape | all meshes and all instances |
    /// | an instance was added | all instances and the tree |
    /// | a material was added or set | all instances |
    /// | a texture was added | all texels |
    ///
    /// It does not wait for the device. Commands of [`World::encode_closest`] and [`World::encode_occluded`] are to be
    /// submitted before it: those that are submitted later would mix both scenes.
    ///
    /// # Errors
    /// A buffer would be larger than the device allows, or the device failed. The world is then empty, and rays hit
    /// nothing, until a call succeeds.
    #[cfg(not(target_arch = "wasm32"))]
    pub fn update(&mut self, scene: &Scene, join: &impl Join) -> Result<(), Error> {
        pollster::block_on(self.update_async(scene, join))
    }

    /// [`World::update`] without blocking. The world is empty as well if the future is dropped before it is ready.
    ///
    /// # Errors
    /// As there.
    pub async fn update_async(&mut self, scene: &Scene, join: &impl Join) -> Result<(), Error> {
        // Until all is copied, the world is that of no scene. Its root is the first node of all, which is an empty leaf in
        // every scene.
        let mut world = take(&mut self.world);
        let device = self.device.device.clone();
        watched(&device, async {
            let changes = world.update(scene, join);
            self.renew(scene, &world, &changes)
        })
        .await?;
        self.world = world;
        Ok(())
    }

    /// Copies what has changed.
    fn renew(&mut self, scene: &Scene, world: &DeviceWorld, changes: &DeviceChanges) -> Result<(), Error> {
        let [instances, nodes, mesh_data, positions, texels, masks] = &mut self.arrays;
        let DeviceChanges { geometry, texels: texels_changed, instances: moved, tree } = changes;
        instances.renew(&self.device, &[(scene.instances(), moved)])?;
        nodes.renew(&self.device, &[(scene.nodes(), geometry), (world.tree(), tree)])?;
        mesh_data.renew(&self.device, &[(scene.mesh_data(), geometry)])?;
        positions.renew(&self.device, &[(scene.positions(), geometry)])?;
        texels.renew(&self.device, &[(scene.texels(), texels_changed)])?;
        masks.renew(&self.device, &[(&world.masks[..], moved)])
    }

    /// The closest hit of each ray, by [`rtrt_core::query::World::closest`]; a ray that is refused has an error of its
    /// own. What is beyond the shorter slice is left alone.
    ///
    /// # Errors
    /// The device failed.
    #[cfg(not(target_arch = "wasm32"))]
    pub fn closest(&self, rays: &[Ray], hits: &mut [Result<Option<Hit>, QueryError>]) -> Result<(), Error> {
        pollster::block_on(self.closest_waiting(rays, hits, Waiting::Blocks))
    }

    /// [`World::closest`] without blocking.
    ///
    /// # Errors
    /// As there.
    pub async fn closest_async(
        &self,
        rays: &[Ray],
        hits: &mut [Result<Option<Hit>, QueryError>],
    ) -> Result<(), Error> {
        self.closest_waiting(rays, hits, Waiting::Free).await
    }

    async fn closest_waiting(
        &self,
        rays: &[Ray],
        hits: &mut [Result<Option<Hit>, QueryError>],
        waiting: Waiting,
    ) -> Result<(), Error> {
        let answer = |ray: &Ray, found: &HitRecord| self.world.hit(ray, found);
        self.ask(waiting, rays, hits, answer, |rays, hits, count, commands| {
            self.encode_closest(commands, rays, hits, count)
        })
        .await
    }

    /// Whether each ray hits anything, by [`rtrt_core::query::World::occluded`], as [`World::closest`].
    ///
    /// # Errors
    /// The device failed.
    #[cfg(not(target_arch = "wasm32"))]
    pub fn occluded(&self, rays: &[Ray], occluded: &mut [Result<bool, QueryError>]) -> Result<(), Error> {
        pollster::block_on(self.occluded_waiting(rays, occluded, Waiting::Blocks))
    }

    /// [`World::occluded`] without blocking.
    ///
    /// # Errors
    /// As there.
    pub async fn occluded_async(
        &self,
        rays: &[Ray],
        occluded: &mut [Result<bool, QueryError>],
    ) -> Result<(), Error> {
        self.occluded_waiting(rays, occluded, Waiting::Free).await
    }

    async fn occluded_waiting(
        &self,
        rays: &[Ray],
        occluded: &mut [Result<bool, QueryError>],
        waiting: Waiting,
    ) -> Result<(), Error> {
        self.ask(
            waiting,
            rays,
            occluded,
            |_, found: &u32| *found != 0,
            |rays, words, count, commands| self.encode_occluded(commands, rays, words, count),
        )
        .await
    }

    /// Adds to an application's commands: the closest hits of the first `count` rays of a buffer go to another buffer.
    /// For programs whose rays are made and used on the device.
    ///
    /// `rays` holds [`RayRecord`]s ([`World::record`] makes them on the host), `hits` gets
    /// [`rtrt_core::layout::Hit`]s. Both are of the device of the [`Gpu`], have [`BufferUsages::STORAGE`], and room for
    /// so many.
    ///
    /// # Errors
    /// A buffer is too short, or the device failed.
    pub fn encode_closest(
        &self,
        commands: &mut wgpu::CommandEncoder,
        rays: &wgpu::Buffer,
        hits: &wgpu::Buffer,
        count: u32,
    ) -> Result<(), Error> {
        self.encode(&self.queries.closest, commands, rays, (hits, size_of::<HitRecord>()), count)
    }

    /// [`World::encode_closest`] of whether rays hit anything: `words` gets a 1 or a 0 for each.
    ///
    /// # Errors
    /// As there.
    pub fn encode_occluded(
        &self,
        commands: &mut wgpu::CommandEncoder,
        rays: &wgpu::Buffer,
        words: &wgpu::Buffer,
        count: u32,
    ) -> Result<(), Error> {
        self.encode(&self.queries.occluded, commands, rays, (words, size_of::<u32>()), count)
    }

    /// A ray as buffers hold it.
    ///
    /// # Errors
    /// The ray has no start, direction or range: see [`QueryError`].
    pub fn record(&self, ray: &Ray) -> Result<RayRecord, QueryError> {
        self.world.record(ray)
    }

    /// A hit of a buffer, on the ray that was asked; `None` for a miss.
    pub fn hit(&self, ray: &Ray, found: &HitRecord) -> Option<Hit> {
        self.world.hit(ray, found)
    }

    fn encode(
        &self,
        pipeline: &Pipeline,
        commands: &mut wgpu::CommandEncoder,
        rays: &wgpu::Buffer,
        (answers, stride): (&wgpu::Buffer, usize),
        count: u32,
    ) -> Result<(), Error> {
        for (buffer, stride) in [(rays, size_of::<RayRecord>()), (answers, stride)] {
            let needed = u64::from(count) * stride as u64;
            if buffer.size() < needed {
                return Err(Error::BufferTooShort { needed, bytes: buffer.size() });
            }
        }
        if count == 0 {
            return Ok(());
        }
        let frame = QueryFrame { rays: count, ..self.world.frame };
        let usage = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
        let numbers = self.device.buffer("rays of a batch", size_of::<QueryFrame>() as u64, usage)?;
        self.device.queue.write_buffer(&numbers, 0, bytemuck::bytes_of(&frame));
        let scene = self.arrays.iter().map(|array| &array.buffer);
        let buffers = [&numbers].into_iter().chain(scene).chain([rays, answers]);
        let group = pipeline.group(&self.device.device, buffers);
        let mut pass = commands.begin_compute_pass(&Default::default());
        pipeline.dispatch(&mut pass, &group, groups([count, 1]));
        Ok(())
    }

    /// Asks slices of rays, batch after batch.
    async fn ask<R: Pod, T>(
        &self,
        waiting: Waiting,
        rays: &[Ray],
        answers: &mut [Result<T, QueryError>],
        answer: impl Fn(&Ray, &R) -> T,
        encode: impl Fn(&wgpu::Buffer, &wgpu::Buffer, u32, &mut wgpu::CommandEncoder) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let mut device = self.device.clone();
        device.waiting = waiting;
        let device = &device;
        let largest = size_of::<RayRecord>().max(size_of::<R>()) as u64;
        let batch = BATCH.min((device.limit / largest) as usize).max(1);
        watched(&device.device, async {
            for (rays, answers) in rays.chunks(batch).zip(answers.chunks_mut(batch)) {
                let count = rays.len().min(answers.len());
                let (rays, answers) = (&rays[..count], &mut answers[..count]);
                let asked: Vec<_> = rays.iter().map(|ray| self.record(ray)).collect();
                let records: Vec<_> =
                    asked.iter().map(|record| record.unwrap_or(bytemuck::Zeroable::zeroed())).collect();
                let mut given = Array::new(device, "rays", size_of_val(&records[..]) as u64)?;
                given.renew(device, &[(&records[..], &Changed::All)])?;
                let bytes = (count * size_of::<R>()) as u64;
                let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
                let taken = device.buffer("answers", bytes, usage)?;
                let mut commands = device.device.create_command_encoder(&Default::default());
                encode(&given.buffer, &taken, count as u32, &mut commands)?;
                device.queue.submit([commands.finish()]);
                let found = bytemuck::pod_collect_to_vec::<u8, R>(&device.fetch(&taken, bytes).await?);
                for (((ray, asked), found), to) in rays.iter().zip(asked).zip(&found).zip(answers) {
                    *to = asked.map(|_| answer(ray, found));
                }
            }
            Ok(())
        })
        .await
    }
}

#[cfg(all(test, not(target_arch = "wasm32")))]
mod tests {
    use super::*;
    use crate::Options;
    use rtrt_core::scene::Sequential;

    #[test]
    fn a_second_world_compiles_nothing() {
        let gpu = match Gpu::new(Options::default()) {
            Ok(gpu) => gpu,
            Err(error) if std::env::var_os("RTRT_REQUIRE_GPU").is_some() => panic!("{error}"),
            Err(error) => return println!("SKIPPED: {error}"),
        };
        let [first, second] = [0; 2].map(|_| gpu.world(&Scene::new(), &Sequential).unwrap());
        assert!(first.queries == second.queries);
    }
}

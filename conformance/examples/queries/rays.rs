//! The rays of the workloads.

use glam::Vec3;
use rtrt_core::query::{Hit, Ray, World};
use rtrt_core::scene::Scene;

const WIDTH: u32 = 640;
const HEIGHT: u32 = 360;

/// One ray a pixel.
pub fn camera_rays(eye: Vec3, look_at: Vec3, up: Vec3, fov_y: f32) -> Vec<Ray> {
    let along = (look_at - eye).normalize();
    let right = along.cross(up).normalize();
    let above = right.cross(along);
    let half = (fov_y * 0.5).tan();
    let pixel = |number: u32| {
        let (x, y) = ((number % WIDTH) as f32 + 0.5, (number / WIDTH) as f32 + 0.5);
        let [x, y] =
            [x - WIDTH as f32 * 0.5, HEIGHT as f32 * 0.5 - y].map(|c| c * half * 2.0 / HEIGHT as f32);
        Ray::new(eye, along + right * x + above * y)
    };
    (0..WIDTH * HEIGHT).map(pixel).collect()
}

/// Numbers that look random.
pub struct Random(pub u64);

impl Random {
    fn word(&mut self) -> u32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as u32
    }
    /// Within 0 .. 1.
    fn share(&mut self) -> f32 {
        (self.word() >> 7) as f32 / (1 << 24) as f32
    }
    /// A direction of length 1 on the side of a normal.
    pub fn around(&mut self, normal: Vec3) -> Vec3 {
        loop {
            let v = Vec3::new(self.share(), self.share(), self.share()) * 2.0 - 1.0;
            let squared = v.length_squared();
            if squared > 1e-3 && squared <= 1.0 {
                return v / squared.sqrt() * if v.dot(normal) < 0.0 { -1.0 } else { 1.0 };
            }
        }
    }
}

/// Points of surfaces.
pub struct Points<'a> {
    scene: &'a Scene,
    world: &'a World<'a>,
    /// The triangles of the instances up to each.
    sums: Vec<u64>,
}

impl<'a> Points<'a> {
    pub fn new(scene: &'a Scene, world: &'a World<'a>) -> Self {
        let mut sum = 0;
        let mut add = |triangles: u32| {
            sum += u64::from(triangles);
            sum
        };
        Self { scene, world, sums: scene.instances().iter().map(|i| add(i.triangles)).collect() }
    }

    /// A ray that leaves a random point of a random triangle, on its front.
    pub fn ray(&self, random: &mut Random) -> Ray {
        loop {
            let all = self.sums.last().copied().unwrap_or(1);
            let number = (u64::from(random.word()) << 31 | u64::from(random.word())) % all;
            let index = self.sums.partition_point(|&sum| sum <= number);
            let instance = &self.scene.instances()[index];
            let (u, v) = (random.share(), random.share());
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            let triangle = (number + u64::from(instance.triangles) - self.sums[index]) as u32;
            let Some(instance) = self.scene.instance_index(index as u32) else { continue };
            let Some(surface) = self.world.surface(&Hit { t: 0.0, instance, triangle, u, v }) else {
                continue;
            };
            let direction = random.around(surface.normal.into());
            let ray = Ray::new(surface.start(direction), direction);
            if self.world.closest(&ray).is_ok() {
                return ray;
            }
        }
    }
}

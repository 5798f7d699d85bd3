//! Meshes and scenes built in code.

use alloc::vec;
use alloc::vec::Vec;
use glam::{Mat4, Vec3};
use rtrt_core::layout::{Attribute, Wrap};
use rtrt_core::scene::{
    Bvh, Image, InstanceIndex, Light, Material, MaterialIndex, Mesh, MeshIndex, Scene, Sequential,
};

/// Numbers that look random; the same for the same seed.
#[derive(Debug, Clone)]
pub struct Random(pub u64);

impl Random {
    /// A number of 31 bits.
    pub fn bits(&mut self) -> u32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as u32
    }
    /// A number below `count`.
    pub fn below(&mut self, count: u32) -> u32 {
        self.bits() % count
    }
    /// A number within `low .. high`.
    pub fn within(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * (self.bits() >> 7) as f32 / (1 << 24) as f32
    }
    /// A vector with each component within `-size .. size`.
    pub fn vector(&mut self, size: f32) -> Vec3 {
        Vec3::new(self.within(-size, size), self.within(-size, size), self.within(-size, size))
    }
}

/// Triangles with their vertices.
#[derive(Debug, Clone, Default)]
pub struct Shape {
    positions: Vec<[f32; 3]>,
    attributes: Vec<Attribute>,
    indices: Vec<u32>,
}

impl Shape {
    /// A triangle without normals: its own is used.
    pub fn triangle(corners: [[f32; 3]; 3]) -> Self {
        let uv = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
        Self {
            positions: corners.to_vec(),
            attributes: uv.map(|uv| Attribute { normal: [0.0; 3], uv, color: Attribute::WHITE }).to_vec(),
            indices: vec![0, 1, 2],
        }
    }

    /// A parallelogram; texture coordinates go from 0 at `corner` to 1 along each side.
    pub fn quad(corner: [f32; 3], right: [f32; 3], up: [f32; 3]) -> Self {
        let [corner, right, up] = [corner, right, up].map(Vec3::from);
        let uv = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let normal = right.cross(up).normalize_or_zero().to_array();
        Self {
            positions: uv.map(|[u, v]| (corner + right * u + up * v).to_array()).to_vec(),
            attributes: uv.map(|uv| Attribute { normal, uv, color: Attribute::WHITE }).to_vec(),
            indices: vec![0, 1, 2, 0, 2, 3],
        }
    }

    /// A floor of `2 · size` on a side, at the height `y`, facing up.
    pub fn floor(size: f32, y: f32) -> Self {
        Self::quad([-size, y, size], [2.0 * size, 0.0, 0.0], [0.0, 0.0, -2.0 * size])
    }

    /// The cube within −1 ..= 1.
    pub fn cube() -> Self {
        let mut all = Self::default();
        for axis in 0..3 {
            for sign in [-1.0, 1.0] {
                let (mut corner, mut right, mut up) = ([-1.0; 3], [0.0; 3], [0.0; 3]);
                corner[axis] = sign;
                right[(axis + 1) % 3] = 2.0;
                up[(axis + 2) % 3] = 2.0;
                if sign < 0.0 {
                    (right, up) = (up, right);
                }
                all = all.and(Self::quad(corner, right, up));
            }
        }
        all
    }

    /// A ball of radius 1 with smooth normals: `steps` rings of `2 · steps` quads.
    pub fn ball(steps: u32) -> Self {
        let (rows, columns) = (steps + 1, 2 * steps + 1);
        let mut ball = Self::default();
        for row in 0..rows {
            for column in 0..columns {
                let (u, v) = (column as f32 / (2 * steps) as f32, row as f32 / steps as f32);
                let (around, down) = (u * core::f32::consts::TAU, v * core::f32::consts::PI);
                // libm, so that every host builds the same ball.
                let ring = libm::sinf(down);
                let p = [libm::cosf(around) * ring, libm::cosf(down), -libm::sinf(around) * ring];
                ball.positions.push(p);
                ball.attributes.push(Attribute { normal: p, uv: [u, v], color: Attribute::WHITE });
            }
        }
        for row in 0..steps {
            for column in 0..2 * steps {
                let a = row * columns + column;
                let c = a + columns;
                ball.indices.extend([a, c, c + 1, a, c + 1, a + 1]);
            }
        }
        ball
    }

    /// `count` triangles of about `size` on a side, scattered within −1 ..= 1, in colors.
    pub fn soup(random: &mut Random, count: u32, size: f32) -> Self {
        let mut soup = Self::default();
        for _ in 0..count {
            let at = random.vector(1.0);
            let corners = core::array::from_fn(|_| (at + random.vector(size)).to_array());
            soup = soup.and(Self::triangle(corners).painted(random));
        }
        soup
    }

    /// Both.
    pub fn and(mut self, other: Self) -> Self {
        let first = self.positions.len() as u32;
        self.positions.extend(other.positions);
        self.attributes.extend(other.attributes);
        self.indices.extend(other.indices.iter().map(|i| first + i));
        self
    }

    /// Moved and scaled; normals and texture coordinates stay.
    pub fn at(mut self, center: [f32; 3], scale: f32) -> Self {
        for p in &mut self.positions {
            *p = (Vec3::from(*p) * scale + Vec3::from(center)).to_array();
        }
        self
    }

    /// With its corners where `bend` takes them. Normals stay.
    pub fn bent(mut self, bend: impl Fn([f32; 3]) -> [f32; 3]) -> Self {
        for p in &mut self.positions {
            *p = bend(*p);
        }
        self
    }

    /// The mesh. Panics where a case has a mistake.
    pub fn mesh(self) -> Mesh {
        Mesh::new(self.positions, self.attributes, self.indices).expect("a case's mesh")
    }

    /// With a color of its own at each vertex.
    pub fn painted(mut self, random: &mut Random) -> Self {
        for attribute in &mut self.attributes {
            let bits = random.bits() << 1;
            attribute.color = [bits, bits.rotate_left(7) | 0xffff_0000];
        }
        self
    }

    /// The same with an alpha of its own too.
    pub fn painted_through(mut self, random: &mut Random) -> Self {
        for attribute in &mut self.attributes {
            let bits = random.bits() << 1;
            attribute.color = [bits, bits.rotate_left(7)];
        }
        self
    }

    /// With texture coordinates scaled, then moved.
    pub fn textured(mut self, scale: [f32; 2], offset: [f32; 2]) -> Self {
        for attribute in &mut self.attributes {
            let uv = attribute.uv;
            attribute.uv = [uv[0] * scale[0] + offset[0], uv[1] * scale[1] + offset[1]];
        }
        self
    }

    /// With other normals.
    pub fn shaded(mut self, normal: impl Fn([f32; 3]) -> [f32; 3]) -> Self {
        for attribute in &mut self.attributes {
            attribute.normal = normal(attribute.normal);
        }
        self
    }
}

/// A scene while it is built. Panics where a case has a mistake.
#[derive(Debug)]
pub struct Build {
    /// The scene.
    pub scene: Scene,
    /// A gray material.
    pub gray: MaterialIndex,
}

impl Default for Build {
    fn default() -> Self {
        let mut scene = Scene::new();
        let gray = scene.add_material(Material::new([0.6; 3]).roughness(0.7)).expect("a case's material");
        Self { scene, gray }
    }
}

impl Build {
    /// Adds a mesh.
    pub fn mesh(&mut self, shape: Shape) -> MeshIndex {
        self.mesh_of(shape, |mesh| mesh)
    }
    /// Adds a mesh that `more` has extended.
    pub fn mesh_of(&mut self, shape: Shape, more: impl Fn(Mesh) -> Mesh) -> MeshIndex {
        let mesh = more(shape.mesh());
        let tree = Bvh::build(&mesh, &Sequential);
        self.scene.add_mesh(&mesh, &tree).expect("room")
    }
    /// Places a mesh.
    pub fn instance(&mut self, mesh: MeshIndex, to_world: Mat4) -> InstanceIndex {
        self.scene.add_instance(mesh, self.gray, to_world).expect("a case's transform")
    }
    /// Adds a mesh and places it where it is.
    pub fn shape(mut self, shape: Shape) -> Self {
        let mesh = self.mesh(shape);
        self.instance(mesh, Mat4::IDENTITY);
        self
    }
    /// The same in a material of its own.
    pub fn shape_of(mut self, shape: Shape, material: Material) -> Self {
        let material = self.scene.add_material(material).expect("a case's material");
        let mesh = self.mesh(shape);
        self.scene.add_instance(mesh, material, Mat4::IDENTITY).expect("a case's instance");
        self
    }
    /// Adds a light.
    pub fn light(mut self, light: Light) -> Self {
        self.scene.add_light(light);
        self
    }
}

/// A floor up to the horizon with a texture of this side, which repeats: near and far, all of its
/// levels are looked up.
pub fn paved(side: u32) -> Scene {
    let mut random = Random(7);
    let mut build = Build::default();
    let rgba = (0..side * side * 4).map(|_| random.bits() as u8).collect();
    let texture =
        build.scene.add_texture(&Image { width: side, height: side, rgba }, [Wrap::Repeat; 2]).expect("room");
    let floor = Shape::floor(500.0, -2.0).textured([40.0, 40.0], [0.0; 2]);
    build
        .shape_of(floor, Material::new([0.9; 3]).roughness(0.5).base_color_map(texture))
        .light(Light::sun([0.3, -1.0, -0.4]))
        .scene
}

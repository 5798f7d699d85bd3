//! A ground that shows shadows and nothing else.

use glam::Mat4;
use rtrt_core::scene::{Attribute, Bvh, InstanceIndex, Material, Mesh, Scene, SceneError, Sequential};

/// The half width of the ground, diagonals of the scene.
const WIDTH: f32 = 2.0;
/// How far the ground lies under the scene, diagonals: surfaces at the bottom of the scene are in front of it.
const GAP: f32 = 1.0 / 8192.0;

/// Adds a plane under the scene that shows shadows and nothing else, two diagonals of the scene in each
/// direction; `None` for a scene without instances.
///
/// # Errors
/// The scene is full, or too far from the origin.
pub fn add_ground(scene: &mut Scene) -> Result<Option<InstanceIndex>, SceneError> {
    let Some((low, high)) = scene.extent() else { return Ok(None) };
    let diagonal = (high - low).length();
    let (middle, half) = ((low + high) * 0.5, WIDTH * diagonal);
    let corner = |x: f32, z: f32| [middle.x + x * half, low.y - GAP * diagonal, middle.z + z * half];
    let positions = vec![corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0), corner(-1.0, -1.0)];
    let attribute = Attribute { normal: [0.0, 1.0, 0.0], uv: [0.0; 2], color: Attribute::WHITE };
    let outside = SceneError::Coordinate { value: half };
    let mesh = Mesh::new(positions, vec![attribute; 4], vec![0, 1, 2, 0, 2, 3]).map_err(|_| outside)?;
    let mesh = scene.add_mesh(&mesh, &Bvh::build(&mesh, &Sequential))?;
    let material = scene.add_material(Material::shadow_catcher())?;
    scene.add_instance(mesh, material, Mat4::IDENTITY).map(Some)
}

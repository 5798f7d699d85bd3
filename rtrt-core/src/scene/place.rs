//! The range of a mesh in the scene's arrays, and the instance that places the mesh in the world.

use crate::layout::{Instance, Kind, MaterialRecord, NONE};
use crate::num::{FLOOR, flush};
use crate::scene::bvh::Bounds;
use crate::scene::camera::single;
use crate::scene::{Bvh, COORDINATE_LIMIT, SceneError};
use bytemuck::Zeroable;
use glam::{DMat3, DMat4, DVec3, DVec4, Mat4, Vec4};

/// The range of a mesh in the scene's arrays.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stored {
    pub root: u32,
    pub kind: Kind,
    pub first_vertex: u32,
    pub first_index: u32,
    pub first_tangent: u32,
    pub first_second_uv: u32,
    pub first_source: usize,
    pub nodes: u32,
    pub vertices: u32,
    /// For each set of texture coordinates, the start of the vertices of transparency records in the mesh
    /// data; 0 if no instance needs them.
    pub transparencies: [u32; 2],
    pub triangles: u32,
    /// Counts the shapes that the mesh has got.
    pub shape_version: u32,
    /// Counts what has had this number.
    pub generation: u32,
    pub bounds: Bounds,
    pub center: DVec3,
    pub radius: f64,
}

impl Stored {
    /// A mesh of [`Shapes`](crate::query::Shapes), whose instances have its number for a root.
    pub fn of_shape(number: u32, tree: &Bvh, positions: &[[f32; 3]]) -> Self {
        let bounds = Bounds::around(&tree.nodes[0]);
        let (center, radius) = sphere(positions, &bounds);
        Self {
            root: number,
            kind: Kind::Mesh,
            first_vertex: 0,
            first_index: 0,
            first_tangent: 0,
            first_second_uv: 0,
            first_source: 0,
            nodes: tree.nodes.len() as u32,
            vertices: positions.len() as u32,
            transparencies: [0; 2],
            triangles: tree.triangles.len() as u32,
            shape_version: 0,
            generation: 0,
            bounds,
            center,
            radius,
        }
    }
}

/// Rounding error of everything that culls with world bounds, relative to the largest
/// coordinate in a frame: 2⁻¹⁶, some hundred roundings. Multiplied by how much an instance's
/// transform, there and back, can magnify errors.
const SLACK: f64 = 1.0 / 65536.0;

/// What an instance takes from its material.
#[derive(Debug, Clone, Copy)]
pub(crate) struct InstanceMaterial {
    material: u32,
    transparency: u32,
    double_sided: u32,
}

impl InstanceMaterial {
    /// That of an instance without a material.
    pub const NONE: Self = Self { material: 0, transparency: 0, double_sided: 1 };

    /// The material with this number in the scene, without a transparency record.
    pub fn new(number: u32, material: &MaterialRecord) -> Self {
        Self { material: number, transparency: 0, double_sided: material.double_sided }
    }

    /// The values of an instance.
    pub fn of(instance: &Instance) -> Self {
        Self {
            material: instance.material,
            transparency: instance.transparency,
            double_sided: instance.double_sided,
        }
    }
}

/// Center and radius of the sphere around positions, in the middle of their bounds.
pub(super) fn sphere(positions: &[[f32; 3]], bounds: &Bounds) -> (DVec3, f64) {
    let [low, high] = [bounds.low, bounds.high].map(|corner| DVec3::from(corner.map(f64::from)));
    let center = (low + high) * 0.5;
    let squared = positions.iter().map(|p| (DVec3::from(p.map(f64::from)) - center).length_squared());
    (center, libm::sqrt(squared.fold(0.0, f64::max)))
}

/// The transform that an instance was placed with, without denormals.
pub(super) fn matrix(instance: &Instance) -> Mat4 {
    from_rows(&instance.to_world).as_mat4()
}

/// The instance of a mesh placed in the world.
pub(crate) fn place(
    mesh: &Stored,
    instance_material: InstanceMaterial,
    to_world: Mat4,
) -> Result<Instance, SceneError> {
    let mut placed = Instance::zeroed();
    place_in(&mut placed, mesh, instance_material, to_world)?;
    Ok(placed)
}

/// Makes this the instance of a mesh placed in the world, computed in `f64`. It stays as it is where that cannot be.
pub(crate) fn place_in(
    instance: &mut Instance,
    mesh: &Stored,
    instance_material: InstanceMaterial,
    to_world: Mat4,
) -> Result<(), SceneError> {
    // Placing an instance again by its stored transform gives the same instance.
    let to_world = flushed(&to_world);
    let m = to_world.as_dmat4();
    let affine = to_world.row(3) == Vec4::W;
    let inverse = DMat3::from_mat4(m).inverse();
    let to_object = DMat4 { w_axis: m.w_axis, ..DMat4::from_mat3(inverse) }.as_mat4();
    if !affine || !to_object.is_finite() {
        return Err(SceneError::Transform);
    }
    let mut corners = around(&m, &mesh.bounds);
    if mesh.triangles == 0 {
        let p = single(m.w_axis.truncate());
        corners = Bounds { low: p, high: p };
    }
    for value in [corners.low, corners.high].into_iter().flatten() {
        // Not a number is not within it either.
        let is_within = value.abs() <= COORDINATE_LIMIT;
        if !is_within {
            return Err(SceneError::Coordinate { value });
        }
    }
    let center = m.transform_point3(mesh.center);
    let stretch = [m.x_axis, m.y_axis, m.z_axis].iter().map(|axis| axis.length_squared()).sum::<f64>();
    let radius = (mesh.radius * libm::sqrt(stretch)).min(half_diagonal(&corners).max(0.0));
    *instance = Instance {
        to_object: rows(&flushed(&to_object)),
        to_world: rows(&to_world),
        low: corners.low,
        root: mesh.root,
        start: mesh.root,
        opened_from: NONE,
        high: corners.high,
        first_vertex: mesh.first_vertex,
        center: single(center),
        radius: flush(radius as f32),
        first_index: mesh.first_index,
        triangles: mesh.triangles,
        material: instance_material.material,
        is_identity: u32::from(to_world == Mat4::IDENTITY),
        slack: (SLACK * condition(&m, &inverse)) as f32,
        first_tangent: mesh.first_tangent,
        first_second_uv: mesh.first_second_uv,
        transparency: instance_material.transparency,
        kind: mesh.kind as u32,
        double_sided: instance_material.double_sided,
    };
    Ok(())
}

/// The instance with the bounds of one of its parts: `bounds` in object space, placed by `matrix`, the
/// transform of the instance.
pub(super) fn part(instance: &Instance, matrix: &DMat4, bounds: &Bounds) -> Instance {
    let corners = around(matrix, bounds);
    let [low, high] = [bounds.low, bounds.high].map(|corner| DVec3::from(corner.map(f64::from)));
    Instance {
        low: corners.low,
        high: corners.high,
        center: single(matrix.transform_point3((low + high) * 0.5)),
        radius: flush(half_diagonal(&corners) as f32),
        ..*instance
    }
}

/// The bounds of a box that is placed in the world: those of its eight corners, since a rounded sum is at an end where each of
/// its terms is.
pub(crate) fn around(m: &DMat4, bounds: &Bounds) -> Bounds {
    let (mut low, mut high) = (DVec3::ZERO, DVec3::ZERO);
    for (i, axis) in [m.x_axis, m.y_axis, m.z_axis].into_iter().enumerate() {
        let axis = axis.truncate();
        let (a, b) = (axis * f64::from(bounds.low[i]), axis * f64::from(bounds.high[i]));
        (low, high) = (low + a.min(b), high + a.max(b));
    }
    let moved = m.w_axis.truncate();
    Bounds { low: single(low + moved), high: single(high + moved) }
}

/// From the middle of a box to its corners.
fn half_diagonal(bounds: &Bounds) -> f64 {
    (DVec3::from(bounds.high.map(f64::from)) - DVec3::from(bounds.low.map(f64::from))).length() * 0.5
}

/// The matrix with these upper three rows.
pub(crate) fn from_rows(rows: &[[f32; 4]; 3]) -> DMat4 {
    let row = |row: &[f32; 4]| DVec4::from(row.map(f64::from));
    DMat4::from_cols(row(&rows[0]), row(&rows[1]), row(&rows[2]), DVec4::W).transpose()
}

/// The upper three rows.
fn rows(m: &Mat4) -> [[f32; 4]; 3] {
    let Mat4 { x_axis, y_axis, z_axis, .. } = m.transpose();
    [x_axis, y_axis, z_axis].map(|row| row.to_array())
}

/// [`flush`] of each number.
fn flushed(m: &Mat4) -> Mat4 {
    let [x, y, z, w] = [m.x_axis, m.y_axis, m.z_axis, m.w_axis]
        .map(|axis| Vec4::select(axis.abs().cmplt(Vec4::splat(FLOOR)), Vec4::ZERO, axis));
    Mat4::from_cols(x, y, z, w)
}

/// The factor by which errors grow on the way to object space and back: the largest row sum of
/// `|m| · |inverse|`, at least 1.
fn condition(m: &DMat4, inverse: &DMat3) -> f64 {
    let sums = inverse.x_axis.abs() + inverse.y_axis.abs() + inverse.z_axis.abs();
    let rows = m.x_axis.abs() * sums.x + m.y_axis.abs() * sums.y + m.z_axis.abs() * sums.z;
    rows.truncate().max_element().max(1.0)
}

#[cfg(test)]
mod tests {
    use crate::layout::Attribute;
    use crate::scene::{Bvh, COORDINATE_LIMIT, Light, Material, Mesh, Scene, SceneError, Sequential};
    use glam::{Mat4, Vec3, Vec4};

    #[test]
    fn transforms_that_place_nothing_are_refused() {
        let mut scene = Scene::new();
        let white = scene.add_material(Material::default()).unwrap();
        let mut place = |to_world| scene.add_sphere(white, to_world).map(|_| ());
        let perspective = Mat4 { w_axis: Vec4::splat(0.5), ..Mat4::IDENTITY };
        let not_a_number = Mat4::from_translation(Vec3::splat(f32::NAN));
        for flat in [Vec3::ZERO, Vec3::new(1.0, 0.0, 1.0), Vec3::new(1.0, 1.0, 1e-40)] {
            assert!(matches!(place(Mat4::from_scale(flat)), Err(SceneError::Transform)), "{flat}");
        }
        assert!(matches!(place(perspective), Err(SceneError::Transform)));
        assert!(place(not_a_number).is_err());
        let far = |x| Mat4::from_translation(Vec3::new(x, 0.0, 0.0));
        assert!(matches!(place(far(2.0 * COORDINATE_LIMIT)), Err(SceneError::Coordinate { .. })));
        assert!(place(far(0.5 * COORDINATE_LIMIT)).is_ok());
    }

    #[test]
    fn what_cannot_be_moved_and_all_after_it_stay_where_they_were() {
        let mut scene = Scene::new();
        let white = scene.add_material(Material::default()).unwrap();
        let at = |x| Mat4::from_translation(Vec3::new(x, 0.0, 0.0));
        let lamp = Light::point([9.0, 0.0, 0.0]).radius(0.5);
        scene.add_light(lamp);
        let shown = scene.show_light(0).unwrap().unwrap();
        let [a, b, c] = [0.0, 1.0, 2.0].map(|x| scene.add_sphere(white, at(x)).unwrap());
        let before = scene.instances().to_vec();
        let flat = Mat4::from_scale(Vec3::ZERO);
        assert!(scene.set_transforms([(a, at(5.0)), (b, flat), (c, at(6.0))]).is_err());
        let after = scene.instances();
        assert_eq!(after[a.number() as usize].center, [5.0, 0.0, 0.0]);
        for stayed in [shown, b, c] {
            let [old, new] = [&before, after].map(|all| bytemuck::bytes_of(&all[stayed.number() as usize]));
            assert_eq!(old, new);
        }
        // A sphere that shows a light goes on to be one.
        scene.set_transform(shown, at(7.0)).unwrap();
        let moved = &scene.instances()[shown.number() as usize];
        assert_eq!((moved.kind, moved.center), (before[shown.number() as usize].kind, [7.0, 0.0, 0.0]));
    }

    #[test]
    fn an_instance_whose_levels_cannot_be_moved_stays_with_them() {
        let mut scene = Scene::new();
        let white = scene.add_material(Material::default()).unwrap();
        let at = |x| Mat4::from_translation(Vec3::new(x, 0.0, 0.0));
        let sphere = scene.add_sphere(white, at(1.0)).unwrap();
        let mut far = |x: f32| {
            let attribute = Attribute { normal: [0.0; 3], uv: [0.0; 2], color: Attribute::WHITE };
            let corners = [[x, 0.0, 0.0], [x, 1.0, 0.0], [x, 0.0, 1.0]].to_vec();
            let mesh = Mesh::new(corners, [attribute; 3].to_vec(), [0, 1, 2].to_vec()).unwrap();
            scene.add_mesh(&mesh, &Bvh::build(&mesh, &Sequential)).unwrap()
        };
        let level = far(0.75 * COORDINATE_LIMIT);
        scene.set_levels(sphere, &[(4.0, level)]).unwrap();
        let before = scene.instances()[0];
        assert!(matches!(
            scene.set_transform(sphere, at(0.5 * COORDINATE_LIMIT)),
            Err(SceneError::Coordinate { .. })
        ));
        assert_eq!(bytemuck::bytes_of(&scene.instances()[0]), bytemuck::bytes_of(&before));
        assert!(scene.set_transform(sphere, at(-5.0)).is_ok());
    }
}

//! The views of a frame: fields that all share, and the views of lights.

use crate::kernel::area::hash;
use crate::layout::{Frame, View, ViewKind};
use crate::request::Shadows;
use crate::scene::bvh::Bounds;
use crate::scene::light::parallel;
use crate::scene::{Light, LightKind, Occluders, Scene, SetupError, Structure};
use crate::stage::ambient::DIRECTIONS;
use alloc::vec::Vec;
use glam::{DVec3, Vec3};

/// What a request asks of the views of lights.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Asked {
    pub shadows: Shadows,
    /// Whether there are views for light from all around, behind those of lights.
    pub has_ambient_rays: bool,
}

/// The key of the views of lights.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Lights {
    scene: u32,
    changes: u32,
    /// The bits of the scene's lower and upper corner.
    bounds: [[u32; 3]; 2],
    cells: u32,
    asked: Asked,
    structure: Structure,
    occluders: Occluders,
}

/// Builds the views: `camera`, and those of lights unless they are unchanged. Returns the number of blocks
/// of lights. They come before the camera's blocks, so their lists can be reused while the camera moves.
pub(super) fn light_views(
    views: &mut Vec<View>,
    made_of: &mut Option<Lights>,
    scene: &Scene,
    bounds: &Bounds,
    asked: Asked,
    camera: View,
) -> Result<u32, SetupError> {
    let (lights, structure) = (scene.lights(), scene.structure);
    let is_one_list = structure == Structure::None;
    let source = Lights {
        scene: scene.id(),
        changes: scene.light_changes(),
        bounds: [bounds.low, bounds.high].map(|corner| corner.map(f32::to_bits)),
        cells: if is_one_list { 1 } else { light_cells(scene.instances().len(), lights) },
        asked,
        structure,
        occluders: scene.occluders,
    };
    let blocks = |views: &[View]| views.iter().map(|v| v.width * v.height).sum::<u32>();
    if made_of.as_ref() == Some(&source) {
        views[Frame::CAMERA as usize] = camera;
        return Ok(blocks(&views[1..]));
    }
    *made_of = None;
    views.clear();
    views.push(camera);
    let mut first_block = 0;
    for (number, light) in (0..).zip(lights) {
        let jitter = match asked.shadows {
            Shadows::Area { jitter } => Some(jitter.map_or(0, |seed| key(seed, number))),
            _ => None,
        };
        let mut faces = light.views(bounds, source.cells, first_block, jitter)?;
        let bins = |view: &&mut View| light.casts_shadows && view.kind != ViewKind::Off as u32;
        faces.iter_mut().filter(bins).for_each(|view| mark(scene, view));
        first_block += blocks(&faces);
        views.extend(faces);
    }
    if asked.has_ambient_rays {
        let cells = source.cells.min(AMBIENT_CELLS);
        for along in ambient_directions() {
            let mut view = parallel(along, Vec3::ZERO, bounds, cells, first_block);
            view.one_list = u32::from(is_one_list);
            first_block += view.width * view.height;
            views.push(view);
        }
    }
    *made_of = Some(source);
    Ok(first_block)
}

/// The most blocks along one side of a view of light from all around, of which there are many.
const AMBIENT_CELLS: u32 = 32;

/// The ways of light from all around: evenly over the sphere, along a spiral (González, 2010). Every fourth is about as
/// even.
fn ambient_directions() -> impl Iterator<Item = DVec3> {
    let golden = core::f64::consts::PI * (3.0 - libm::sqrt(5.0));
    (0..DIRECTIONS).map(move |number| {
        let height = 1.0 - (2.0 * f64::from(number) + 1.0) / f64::from(DIRECTIONS);
        let ring = libm::sqrt(1.0 - height * height);
        let (sine, cosine) = libm::sincos(golden * f64::from(number));
        -DVec3::new(ring * cosine, height, ring * sine)
    })
}

/// Writes the scene's [`Structure`](crate::scene::Structure) and [`Occluders`] into a view.
pub(super) fn mark(scene: &Scene, view: &mut View) {
    view.one_list = u32::from(scene.structure == Structure::None);
    view.shadow_distance = match scene.occluders {
        Occluders::Near(distance) => distance.clamp(LEAST_DISTANCE, MOST_DISTANCE),
        Occluders::All => 0.0,
    };
}

/// The value that ray numbers are hashed with to jitter the points of a light; not 0.
fn key(seed: u32, light: u32) -> u32 {
    hash(hash(seed) ^ light) | 1
}

/// The least distance at which shadows end. 0 means that they never end; the square must not be
/// denormal.
const LEAST_DISTANCE: f32 = 1e-12;
/// The largest: its square is finite, and nothing is farther away.
const MOST_DISTANCE: f32 = 1e18;

/// The most blocks of all lights' views together, unless there are thousands of lights.
const LIGHT_BLOCKS: usize = 1 << 21;

/// Blocks along one side of a light's view: about twice the square root of the number of instances, so
/// that a block sees few of them. Thousands of instances get half as many, because a packet visits every
/// block that its shadow rays end in. Many lights get fewer, to bound the memory of the lists.
fn light_cells(instances: usize, lights: &[Light]) -> u32 {
    let side = libm::sqrt(instances as f64) as u32;
    let wanted = (2 * side).next_power_of_two().min(64).max(side.next_power_of_two());
    // A sun has one view, other lights those of a cube.
    let views = lights.iter().map(|light| if light.kind == LightKind::Sun { 1 } else { 6 }).sum::<usize>();
    let most = libm::sqrt((LIGHT_BLOCKS / views.max(1)) as f64) as u32;
    wanted.clamp(8, 1 << most.max(8).ilog2())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec;

    #[test]
    fn a_light_has_about_a_block_an_instance_and_all_have_bounded_memory() {
        let (sun, lamp) = (Light::sun([0.0, -1.0, 0.0]), Light::point([0.0; 3]));
        let cells = |instances, lights: &[Light]| light_cells(instances, lights);
        assert_eq!([1, 100, 1000].map(|instances| cells(instances, &[sun])), [8, 32, 64]);
        assert_eq!([10_000, 100_000, 1_000_000].map(|instances| cells(instances, &[sun])), [128, 512, 1024]);
        // A cube of blocks.
        assert_eq!(cells(1_000_000, &[lamp]), 512);
        for count in [2, 10, 100, 1000] {
            let side = cells(1_000_000, &vec![lamp; count]) as usize;
            assert!(6 * count * side * side <= LIGHT_BLOCKS, "{count} lamps have {side} blocks a side");
        }
        assert_eq!([cells(0, &[]), cells(1, &vec![lamp; 100_000])], [8, 8]);
    }
}

//! What a picture shows of each object: visible pixels, and boxes.

use crate::layers::Layers;
use rtrt_core::layout::NONE;
use rtrt_core::scene::Scene;
use std::collections::BTreeMap;

/// The visible pixels of an object, and its boxes.
#[derive(Debug, Clone, PartialEq)]
pub struct Seen {
    /// The number of the instance, as in [`Layers::object`].
    pub object: u32,
    /// Pixels whose first sub-ray hits it.
    pub pixels: u32,
    /// The smallest box around those pixels: left, top, and the first column and row beyond it.
    pub box_2d: [u32; 4],
    /// Lower and upper corner of a box around all of the object, world space.
    pub box_3d: [[f32; 3]; 2],
}

/// The objects of which at least a pixel is seen, in the order of their numbers.
pub fn seen(scene: &Scene, layers: &Layers) -> Vec<Seen> {
    let mut all: BTreeMap<u32, (u32, [u32; 4])> = BTreeMap::new();
    for (number, &object) in layers.object.iter().enumerate().filter(|(_, object)| **object != NONE) {
        let (x, y) = (number as u32 % layers.width, number as u32 / layers.width);
        let (pixels, [left, top, right, bottom]) = all.entry(object).or_insert((0, [x, y, x, y]));
        *pixels += 1;
        (*left, *right) = ((*left).min(x), (*right).max(x + 1));
        (*top, *bottom) = ((*top).min(y), (*bottom).max(y + 1));
    }
    let instance = |object: u32| scene.instances().get(object as usize);
    let seen = |(object, (pixels, box_2d))| {
        let box_3d = instance(object).map_or([[0.0; 3]; 2], |instance| [instance.low, instance.high]);
        Seen { object, pixels, box_2d, box_3d }
    };
    all.into_iter().map(seen).collect()
}

#[test]
fn pixels_and_boxes_are_those_of_each_object() {
    let object = vec![NONE, 1, 1, NONE, 1, 0];
    let layers = Layers { width: 3, height: 2, object, ..Layers::default() };
    let found = seen(&Scene::new(), &layers);
    let boxes: Vec<_> = found.iter().map(|seen| (seen.object, seen.pixels, seen.box_2d)).collect();
    assert_eq!(boxes, [(0, 1, [2, 1, 3, 2]), (1, 3, [1, 0, 3, 2])]);
}

//! Text that a frame shows, and where.

use super::input::{Point, Side};
use egui::{FullOutput, Rect, Shape, vec2};

/// How far beside a text its field is pointed at, units of the user interface.
const BESIDE: f32 = 20.0;

/// The texts of a frame, with their places in pixels, in the order in which they are drawn.
#[derive(Debug, Default)]
pub struct Seen {
    texts: Vec<(String, Rect)>,
    /// Pixels a unit.
    scale: f32,
}

impl Seen {
    /// What a frame shows, with so many pixels a unit. What is scrolled out of sight is not among it.
    pub fn of(over: &FullOutput, scale: f32) -> Self {
        let mut texts = Vec::new();
        for clipped in &over.shapes {
            collect(&clipped.shape, clipped.clip_rect, &mut texts);
        }
        Self { texts, scale }
    }

    /// The pixel at which a recording points. Of the same text twice, what is drawn last counts: it lies over the other.
    pub fn place(&self, point: &Point) -> Option<[f32; 2]> {
        let (_, at) = self.texts.iter().rfind(|(text, _)| *text == point.text)?;
        let place = match point.side {
            Side::On => at.center(),
            Side::Right => at.right_center() + vec2(BESIDE, 0.0),
            Side::Left => at.left_center() - vec2(BESIDE, 0.0),
        };
        Some([place.x, place.y].map(|c| c * self.scale))
    }
}

fn collect(shape: &Shape, clip: Rect, texts: &mut Vec<(String, Rect)>) {
    match shape {
        Shape::Text(text) => {
            let place = text.galley.rect.translate(text.pos.to_vec2());
            if clip.contains(place.center()) {
                texts.push((text.galley.text().to_owned(), place));
            }
        }
        Shape::Vec(all) => all.iter().for_each(|shape| collect(shape, clip, texts)),
        _ => {}
    }
}

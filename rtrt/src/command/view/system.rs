//! Events of the system as input events.

use super::input::{Button, Event, Modifiers};
use winit::event::{ElementState, KeyEvent, MouseButton, MouseScrollDelta, TouchPhase, WindowEvent};
use winit::keyboard::{Key, PhysicalKey};

/// Pixels of a touchpad per notch of a wheel.
const NOTCH: f64 = 40.0;

/// The input events of an event of the system. Sizes of the window are not among them.
pub fn translated(event: &WindowEvent, fingers: &mut Fingers) -> Vec<Event> {
    let input = match event {
        WindowEvent::Focused(has) => Event::Focus(*has),
        WindowEvent::DroppedFile(path) => Event::Drop(path.clone()),
        WindowEvent::ModifiersChanged(held) => {
            let held = held.state();
            let ctrl = held.control_key() || held.super_key();
            Event::Modifiers(Modifiers { ctrl, shift: held.shift_key(), alt: held.alt_key() })
        }
        WindowEvent::CursorMoved { position, .. } => Event::Move(position.x as f32, position.y as f32),
        WindowEvent::CursorLeft { .. } => Event::Leave,
        WindowEvent::MouseWheel { delta: MouseScrollDelta::LineDelta(aside, notches), .. } => {
            // Some systems turn a wheel with Shift aside.
            Event::Wheel(if *notches == 0.0 { *aside } else { *notches })
        }
        WindowEvent::MouseWheel { delta: MouseScrollDelta::PixelDelta(pixels), .. } => {
            Event::Wheel((pixels.y / NOTCH) as f32)
        }
        WindowEvent::MouseInput { state, button, .. } => {
            let button = match button {
                MouseButton::Left => Button::Left,
                MouseButton::Middle => Button::Middle,
                MouseButton::Right => Button::Right,
                _ => return Vec::new(),
            };
            Event::Button(button, *state == ElementState::Pressed)
        }
        WindowEvent::PinchGesture { delta, .. } => Event::Pinch((1.0 + *delta as f32).clamp(0.1, 10.0)),
        WindowEvent::Touch(touch) => {
            let place = [touch.location.x as f32, touch.location.y as f32];
            return fingers.moved(touch.id, touch.phase, place);
        }
        WindowEvent::KeyboardInput { event, .. } => return typed(event),
        _ => return Vec::new(),
    };
    vec![input]
}

/// The fingers on a screen.
#[derive(Debug, Default)]
pub struct Fingers {
    /// Their numbers and places, in the order in which they came.
    down: Vec<(u64, [f32; 2])>,
    /// Whether one finger drags.
    drags: bool,
    /// Whether there were two, so that the last one does not click.
    were_two: bool,
}

impl Fingers {
    /// The input events of a finger: one is the left button of a mouse, two shift and scale.
    fn moved(&mut self, finger: u64, phase: TouchPhase, place: [f32; 2]) -> Vec<Event> {
        let at = |[x, y]: [f32; 2]| Event::Move(x, y);
        let which = self.down.iter().position(|(known, _)| *known == finger);
        match (phase, which) {
            (TouchPhase::Started, None) => {
                self.down.push((finger, place));
                self.were_two = self.down.len() > 1;
                if std::mem::take(&mut self.drags) {
                    vec![Event::Button(Button::Left, false)]
                } else {
                    vec![]
                }
            }
            (TouchPhase::Moved, Some(which)) => {
                let before = self.spread();
                let from = std::mem::replace(&mut self.down[which].1, place);
                match (before, self.spread()) {
                    (Some((middle, apart)), Some((to, now))) => {
                        let factor = if apart > 1.0 { (now / apart).clamp(0.1, 10.0) } else { 1.0 };
                        vec![at(to), Event::Pan(to[0] - middle[0], to[1] - middle[1]), Event::Pinch(factor)]
                    }
                    _ if self.down.len() > 1 => vec![],
                    _ if std::mem::replace(&mut self.drags, true) => vec![at(place)],
                    _ => vec![at(from), Event::Button(Button::Left, true), at(place)],
                }
            }
            (TouchPhase::Ended | TouchPhase::Cancelled, Some(which)) => {
                let is_tap =
                    phase == TouchPhase::Ended && self.down.len() == 1 && !self.drags && !self.were_two;
                self.down.remove(which);
                let up = Event::Button(Button::Left, false);
                if is_tap {
                    return vec![at(place), Event::Button(Button::Left, true), up];
                }
                if std::mem::take(&mut self.drags) { vec![up] } else { vec![] }
            }
            _ => vec![],
        }
    }

    /// The middle between two fingers, and the distance between them.
    fn spread(&self) -> Option<([f32; 2], f32)> {
        let [(_, a), (_, b)] = self.down[..] else { return None };
        let [x, y] = [a[0] - b[0], a[1] - b[1]];
        Some(([(a[0] + b[0]) * 0.5, (a[1] + b[1]) * 0.5], (x * x + y * y).sqrt()))
    }
}

fn typed(event: &KeyEvent) -> Vec<Event> {
    let pressed = event.state == ElementState::Pressed;
    let key = key(event).map(|key| if pressed { Event::Press(key) } else { Event::Release(key) });
    let text = event.text.as_ref().filter(|text| pressed && !text.chars().any(char::is_control));
    key.into_iter().chain(text.map(|text| Event::Text(text.to_string()))).collect()
}

/// The key by its label; digits and letters of other scripts by their position.
fn key(event: &KeyEvent) -> Option<egui::Key> {
    let by_place = || match event.physical_key {
        PhysicalKey::Code(code) => {
            let name = format!("{code:?}");
            let letter = name.strip_prefix("Key");
            let digit = name.strip_prefix("Digit").or_else(|| name.strip_prefix("Numpad"));
            egui::Key::from_name(letter.or(digit).unwrap_or(&name))
        }
        PhysicalKey::Unidentified(_) => None,
    };
    let place = by_place();
    let is_digit =
        place.is_some_and(|key| key.name().len() == 1 && key.name().as_bytes()[0].is_ascii_digit());
    if is_digit {
        return place;
    }
    let by_print = match &event.logical_key {
        Key::Named(named) => egui::Key::from_name(&format!("{named:?}")),
        Key::Character(text) => egui::Key::from_name(&text.to_uppercase()),
        _ => None,
    };
    by_print.or(place)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_finger_drags_and_two_shift_and_scale() {
        let mut fingers = Fingers::default();
        let (down, up) = (Event::Button(Button::Left, true), Event::Button(Button::Left, false));
        assert_eq!(fingers.moved(7, TouchPhase::Started, [10.0, 10.0]), []);
        let drag = fingers.moved(7, TouchPhase::Moved, [20.0, 10.0]);
        assert_eq!(drag, [Event::Move(10.0, 10.0), down.clone(), Event::Move(20.0, 10.0)]);
        assert_eq!(fingers.moved(7, TouchPhase::Moved, [30.0, 10.0]), [Event::Move(30.0, 10.0)]);
        assert_eq!(fingers.moved(8, TouchPhase::Started, [30.0, 50.0]), std::slice::from_ref(&up));
        let both = fingers.moved(8, TouchPhase::Moved, [30.0, 90.0]);
        assert_eq!(both, [Event::Move(30.0, 50.0), Event::Pan(0.0, 20.0), Event::Pinch(2.0)]);
        assert_eq!(fingers.moved(8, TouchPhase::Ended, [30.0, 90.0]), []);
        assert_eq!(fingers.moved(7, TouchPhase::Ended, [30.0, 10.0]), []);
        // A tap is a click.
        assert_eq!(fingers.moved(9, TouchPhase::Started, [5.0, 6.0]), []);
        assert_eq!(fingers.moved(9, TouchPhase::Ended, [5.0, 6.0]), [Event::Move(5.0, 6.0), down, up]);
        assert_eq!(fingers.moved(9, TouchPhase::Ended, [5.0, 6.0]), []);
    }
}

//! Input events as events of the user interface.

use super::input::{Button, Event, Modifiers};
use egui::{Key, PointerButton, Pos2, RawInput, Rect, pos2, vec2};

/// What the user interface knows of keys and the mouse.
#[derive(Debug, Default)]
pub struct Interface {
    modifiers: Modifiers,
    /// The position of the pointer, in units of the user interface.
    pointer: Pos2,
}

impl Interface {
    /// The input of a frame: these events, in a window of this size in pixels with so many pixels a unit.
    pub fn input(
        &mut self,
        events: &[Event],
        (size, scale): ([u32; 2], f32),
        (time, seconds): (f64, f32),
    ) -> RawInput {
        let [width, height] = size.map(|side| side as f32 / scale);
        let mut input = RawInput {
            screen_rect: Some(Rect::from_min_size(pos2(0.0, 0.0), vec2(width, height))),
            time: Some(time),
            predicted_dt: seconds,
            events: events
                .iter()
                .flat_map(|event| [self.event(event, scale), self.shortcut(event)])
                .flatten()
                .collect(),
            ..RawInput::default()
        };
        for viewport in input.viewports.values_mut() {
            viewport.native_pixels_per_point = Some(scale);
        }
        input
    }

    /// What Ctrl and a letter do with text that is selected.
    fn shortcut(&self, event: &Event) -> Option<egui::Event> {
        match event {
            Event::Press(Key::C) if self.modifiers.ctrl => Some(egui::Event::Copy),
            Event::Press(Key::X) if self.modifiers.ctrl => Some(egui::Event::Cut),
            _ => None,
        }
    }

    /// The event for the overlay.
    fn event(&mut self, event: &Event, scale: f32) -> Option<egui::Event> {
        let key = |key: &egui::Key, pressed, modifiers| egui::Event::Key {
            key: *key,
            physical_key: None,
            pressed,
            repeat: false,
            modifiers,
        };
        let Modifiers { ctrl, shift, alt } = self.modifiers;
        let modifiers = egui::Modifiers { ctrl, shift, alt, command: ctrl, mac_cmd: false };
        Some(match event {
            Event::Size(..) | Event::Drop(_) | Event::Pinch(_) | Event::Pan(..) | Event::Point(_) => {
                return None;
            }
            Event::Press(pressed) => key(pressed, true, modifiers),
            Event::Release(released) => key(released, false, modifiers),
            Event::Modifiers(held) => {
                self.modifiers = *held;
                return None;
            }
            Event::Text(text) => egui::Event::Text(text.clone()),
            Event::Paste(text) => egui::Event::Paste(text.clone()),
            Event::Move(x, y) => {
                self.pointer = pos2(*x, *y) / scale;
                egui::Event::PointerMoved(self.pointer)
            }
            Event::Leave => egui::Event::PointerGone,
            Event::Button(button, pressed) => egui::Event::PointerButton {
                pos: self.pointer,
                button: match button {
                    Button::Left => PointerButton::Primary,
                    Button::Middle => PointerButton::Middle,
                    Button::Right => PointerButton::Secondary,
                },
                pressed: *pressed,
                modifiers,
            },
            Event::Wheel(notches) => egui::Event::MouseWheel {
                unit: egui::MouseWheelUnit::Line,
                delta: vec2(0.0, *notches),
                phase: egui::TouchPhase::Move,
                source: egui::MouseWheelSource::Unknown,
                modifiers,
            },
            Event::Focus(has) => egui::Event::WindowFocused(*has),
        })
    }
}

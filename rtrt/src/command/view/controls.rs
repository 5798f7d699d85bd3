//! The controls: keys and mouse.

use super::camera;
use super::input::{Button, Event, Modifiers};
use egui::Key;
use glam::DVec3;
use rtrt::debug::DebugView;
use rtrt_core::scene::Camera;
use std::collections::HashSet;
use std::path::PathBuf;

/// The keys and their functions.
pub const KEYS: [(&str, &str); 17] = [
    ("W A S D", "move; with Shift faster"),
    ("PageUp PageDown", "move up and down"),
    ("Q E", "tilt"),
    ("left button", "drag to orbit around the middle"),
    ("right button", "drag to look around"),
    ("middle button", "drag to shift the picture"),
    ("wheel", "focal length"),
    ("1 3 7 9", "view from the front, right, top, behind"),
    ("Enter", "reset the camera and the animation"),
    ("Space", "play and pause the animation"),
    ("B", "switch between CPU and GPU"),
    ("P", "panel: samples, shadows, exposure, environment, lights"),
    ("Z", "timing"),
    ("Ctrl 1 … 6", "albedo, normal, depth, ids, block heat map, shadow"),
    ("Ctrl 0", "back to the picture"),
    ("F12", "screenshot"),
    ("H  Esc", "these keys; close"),
];

/// The keys, as the help of the command lists them.
pub fn keys() -> String {
    let lines = KEYS.iter().map(|(keys, what)| format!("\n  {keys:<16}  {what}"));
    format!("Keys:{}", lines.collect::<String>())
}

/// The views of Ctrl with a digit, from 1 on.
const VIEWS: [DebugView; 6] = [
    DebugView::Albedo,
    DebugView::Normal,
    DebugView::Depth,
    DebugView::Ids,
    DebugView::Heat,
    DebugView::Shadow,
];

/// Radians per pixel of a drag.
const TURN: f64 = 0.005;
/// Radians per second.
const TILT: f64 = 0.8;
/// Radii of the scene per second.
const SPEED: f64 = 0.3;
/// The factor of Shift.
const FAST: f64 = 4.0;

/// An action other than a move of the camera.
#[derive(Debug, Clone, PartialEq)]
pub enum Action {
    Help,
    Timing,
    Panel,
    Backend,
    Screenshot,
    Reset,
    Play,
    Debug(Option<DebugView>),
    Open(PathBuf),
    Close,
}

/// The camera, with the values that its moves depend on.
#[derive(Debug, Clone, Copy)]
pub struct Rig {
    pub camera: Camera,
    /// Center and radius of the scene.
    pub scene: (DVec3, f64),
    /// Width and height of the picture, pixels.
    pub size: [u32; 2],
}

impl Rig {
    fn aspect(&self) -> f64 {
        f64::from(self.size[0]) / f64::from(self.size[1])
    }
}

/// Which events the overlay leaves to the camera.
#[derive(Debug, Clone, Copy)]
pub struct Free {
    pub keys: bool,
    pub pointer: bool,
}

/// The effect of a drag.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Drag {
    /// An orbit around the point at this distance in front of the camera.
    Orbit(f64),
    Look,
    /// A shift together with the points at this distance in front of the camera.
    Shift(f64),
}

/// The held keys and buttons.
#[derive(Debug, Default)]
pub struct Controls {
    keys: HashSet<Key>,
    modifiers: Modifiers,
    pointer: Option<[f32; 2]>,
    drag: Option<(Button, Drag)>,
}

impl Controls {
    /// Handles an event. It may move the camera or return an action.
    pub fn handle(&mut self, event: &Event, free: Free, rig: &mut Rig) -> Option<Action> {
        match event {
            Event::Press(key) if free.keys && !self.keys.contains(key) => {
                self.keys.insert(*key);
                return self.pressed(*key, rig);
            }
            Event::Release(key) => drop(self.keys.remove(key)),
            Event::Modifiers(modifiers) => self.modifiers = *modifiers,
            Event::Move(x, y) => self.dragged([*x, *y], rig),
            Event::Button(button, true) if free.pointer && self.drag.is_none() => {
                let distance = camera::pivot(&rig.camera, rig.scene);
                let drag = match button {
                    Button::Left => Drag::Orbit(distance),
                    Button::Right => Drag::Look,
                    Button::Middle => Drag::Shift(distance),
                };
                self.drag = Some((*button, drag));
            }
            Event::Button(button, false) => self.drag = self.drag.filter(|(held, _)| held != button),
            Event::Wheel(notches) if free.pointer => {
                rig.camera = camera::zoomed(&rig.camera, f64::from(*notches));
            }
            // Another window gets the release of a key.
            Event::Focus(false) => (self.keys, self.drag) = (HashSet::new(), None),
            Event::Drop(path) => return Some(Action::Open(path.clone())),
            _ => {}
        }
        None
    }

    fn pressed(&self, key: Key, rig: &mut Rig) -> Option<Action> {
        let digits = [Key::Num0, Key::Num1, Key::Num2, Key::Num3, Key::Num4, Key::Num5, Key::Num6];
        if self.modifiers.ctrl {
            let digit = digits.iter().position(|digit| *digit == key)?;
            return Some(Action::Debug(digit.checked_sub(1).map(|place| VIEWS[place])));
        }
        let mut look = |from, up| {
            rig.camera = camera::standard(&rig.camera, rig.scene, rig.aspect(), from, up);
            None
        };
        match key {
            Key::Num1 => look(DVec3::Z, DVec3::Y),
            Key::Num3 => look(DVec3::X, DVec3::Y),
            Key::Num7 => look(DVec3::Y, DVec3::NEG_Z),
            Key::Num9 => look(DVec3::NEG_Z, DVec3::Y),
            Key::H => Some(Action::Help),
            Key::Z => Some(Action::Timing),
            Key::P => Some(Action::Panel),
            Key::B => Some(Action::Backend),
            Key::F12 => Some(Action::Screenshot),
            Key::Enter => Some(Action::Reset),
            Key::Space => Some(Action::Play),
            Key::Escape => Some(Action::Close),
            _ => None,
        }
    }

    fn dragged(&mut self, to: [f32; 2], rig: &mut Rig) {
        let Some(from) = self.pointer.replace(to) else { return };
        let [x, y] = [0, 1].map(|axis| f64::from(to[axis]) - f64::from(from[axis]));
        let camera = &rig.camera;
        rig.camera = match self.drag {
            Some((_, Drag::Orbit(distance))) => camera::orbited(camera, distance, -x * TURN, -y * TURN),
            Some((_, Drag::Look)) => camera::turned(camera, -x * TURN, -y * TURN),
            Some((_, Drag::Shift(distance))) => {
                let pixel = camera::height_at(camera, distance) / f64::from(rig.size[1]);
                camera::moved(camera, [-x * pixel, y * pixel, 0.0])
            }
            None => return,
        };
    }

    /// Moves the camera by the held keys for so many seconds.
    pub fn advance(&self, seconds: f64, rig: &mut Rig) {
        if self.modifiers.ctrl {
            return;
        }
        let axis = |more, less| {
            f64::from(u8::from(self.keys.contains(&more))) - f64::from(u8::from(self.keys.contains(&less)))
        };
        let tilt = axis(Key::E, Key::Q);
        if tilt != 0.0 {
            rig.camera = camera::tilted(&rig.camera, tilt * TILT * seconds);
        }
        let way = [axis(Key::D, Key::A), axis(Key::PageUp, Key::PageDown), axis(Key::W, Key::S)];
        if way != [0.0; 3] {
            let fast = if self.modifiers.shift { FAST } else { 1.0 };
            let step = rig.scene.1 * SPEED * fast * seconds;
            rig.camera = camera::moved(&rig.camera, way.map(|axis| axis * step));
        }
    }

    /// Whether a key or a button is held.
    pub fn is_busy(&self) -> bool {
        !self.keys.is_empty() || self.drag.is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use rtrt_core::scene::Projection;

    const FREE: Free = Free { keys: true, pointer: true };
    const RIG: Rig = Rig {
        camera: Camera {
            eye: Vec3::new(0.0, 0.0, 5.0),
            look_at: Vec3::ZERO,
            up: Vec3::Y,
            projection: Projection::Perspective { fov_y: 1.0 },
        },
        scene: (DVec3::ZERO, 2.0),
        size: [640, 360],
    };

    /// The rig after these events and a second, and the actions.
    fn after(free: Free, events: &[Event]) -> (Rig, Vec<Action>) {
        let (mut rig, mut controls) = (RIG, Controls::default());
        let actions = events.iter().filter_map(|event| controls.handle(event, free, &mut rig)).collect();
        controls.advance(1.0, &mut rig);
        (rig, actions)
    }

    #[test]
    fn a_held_key_moves_until_it_is_released() {
        let (rig, _) = after(FREE, &[Event::Press(Key::W)]);
        assert!((rig.camera.eye.z - (5.0 - 0.6)).abs() < 1e-5);
        for end in [Event::Release(Key::W), Event::Focus(false)] {
            let (rig, _) = after(FREE, &[Event::Press(Key::W), end]);
            assert_eq!(rig.camera, RIG.camera);
        }
    }

    #[test]
    fn a_drag_orbits_around_the_middle_of_the_scene() {
        let drag = [Event::Move(10.0, 10.0), Event::Button(Button::Left, true), Event::Move(110.0, 10.0)];
        let (rig, _) = after(FREE, &drag);
        assert!(rig.camera.eye.x < -1.0 && (rig.camera.eye.length() - 5.0).abs() < 1e-4);
        let (rig, _) =
            after(FREE, &[&drag[..], &[Event::Button(Button::Left, false), Event::Move(0.0, 0.0)]].concat());
        assert!(rig.camera.eye.x < -1.0);
    }

    #[test]
    fn events_of_the_panel_do_not_move_the_camera() {
        let events = [
            Event::Press(Key::W),
            Event::Press(Key::B),
            Event::Wheel(1.0),
            Event::Move(0.0, 0.0),
            Event::Button(Button::Left, true),
            Event::Move(50.0, 50.0),
        ];
        let (rig, actions) = after(Free { keys: false, pointer: false }, &events);
        assert_eq!((rig.camera, actions), (RIG.camera, vec![]));
        assert_ne!(after(FREE, &events).0.camera, RIG.camera);
    }

    #[test]
    fn repetitions_of_a_held_key_are_ignored() {
        let (_, actions) = after(FREE, &[Event::Press(Key::B), Event::Press(Key::B)]);
        assert_eq!(actions, [Action::Backend]);
    }

    #[test]
    fn digits_choose_a_view_with_ctrl_and_a_side_without() {
        let ctrl = Event::Modifiers(Modifiers { ctrl: true, ..Modifiers::default() });
        let (rig, actions) = after(FREE, &[ctrl.clone(), Event::Press(Key::Num3), Event::Press(Key::Num0)]);
        assert_eq!(actions, [Action::Debug(Some(DebugView::Depth)), Action::Debug(None)]);
        assert_eq!(rig.camera, RIG.camera);
        let (rig, _) = after(FREE, &[Event::Press(Key::Num3)]);
        assert!(rig.camera.eye.x > 2.0 && rig.camera.eye.z.abs() < 1e-5);
    }
}

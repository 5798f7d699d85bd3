//! The controls: keys and mouse.

use super::camera;
use super::input::{Button, Event, Modifiers};
use super::motion::{self, Mode};
use egui::Key;
use glam::DVec3;
use rtrt::debug::DebugView;
use rtrt_core::scene::Camera;
use std::collections::HashSet;
use std::path::PathBuf;

/// The keys and their functions.
pub const KEYS: [(&str, &str); 28] = [
    ("left button", "drag to orbit around the pivot; click to select"),
    ("double click", "put the pivot on the surface"),
    ("right button", "drag to look around"),
    ("middle button", "drag to shift the picture"),
    ("wheel  pinch", "go nearer, up to a surface; with Shift to what is under the pointer"),
    ("Ctrl wheel", "focal length"),
    ("two fingers", "drag to shift the picture"),
    ("W A S D", "move; with Shift faster"),
    ("PageUp PageDown", "move up and down"),
    ("Q E", "tilt"),
    ("F", "show all of what is selected, or of the scene"),
    ("T", "turntable, trackball or fly"),
    ("O  5", "parallel rays, or rays from one point"),
    ("1 3 7 9", "view from the front, right, top, behind"),
    ("X  G", "axes; grid"),
    ("Enter", "reset the camera and the animation"),
    ("Space", "play and pause the animation"),
    (",  .", "a frame back, a frame on"),
    ("Left Right", "previous and next file of the folder"),
    ("Delete", "hide what is selected; Backspace shows all again"),
    ("L", "list of objects"),
    ("P", "panel: picture, camera, light, time, files"),
    ("B", "switch between CPU and GPU"),
    ("Z", "timing"),
    ("Ctrl 1 … 6", "albedo, normal, depth, ids, block heat map, shadow"),
    ("Ctrl 0", "back to the picture"),
    ("F11  F12", "full screen; screenshot"),
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

/// Keys of steps, which the system repeats while they are held.
const STEPS: [Key; 4] = [Key::Comma, Key::Period, Key::ArrowLeft, Key::ArrowRight];
/// Radians per pixel of a drag.
const TURN: f64 = 0.005;
/// Radians per second.
const TILT: f64 = 0.8;
/// Radii of the scene per second.
const SPEED: f64 = 0.3;
/// The factor of Shift.
const FAST: f64 = 4.0;

/// The longest time between two clicks of a double click, seconds.
pub const DOUBLE: f64 = 0.4;
/// The angle of view of a camera that had parallel rays, radians.
const FOV_Y: f32 = 0.8;
/// A drag begins this far from where a button was pressed, pixels.
const STILL: f32 = 4.0;
/// The least distance that a notch of the wheel counts with, radii of the scene.
const LEAST: f64 = 0.02;
/// The distance that an orbit and the wheel keep from walls, radii of the scene.
const MARGIN: f64 = 0.002;
/// The time of a frame of an animation, seconds.
const FRAME: f64 = 1.0 / 24.0;

/// An action other than a move of the camera.
#[derive(Debug, Clone, PartialEq)]
pub enum Action {
    Help,
    Timing,
    Panel,
    Objects,
    Axes,
    Grid,
    Backend,
    Screenshot,
    Reset,
    Play,
    /// A step of the animation, seconds.
    Step(f64),
    Debug(Option<DebugView>),
    /// Selects what the picture shows at this place, pixels.
    Select([f32; 2]),
    /// A view of all of what is selected.
    Frame,
    Hide,
    ShowAll,
    FullScreen,
    Open(PathBuf),
    /// Another file of the folder: so many behind this one.
    File(i32),
    Say(String),
    Close,
}

/// The camera, with what its moves depend on.
pub struct Rig<'a> {
    pub camera: Camera,
    /// The corners of the scene's box.
    pub extent: (DVec3, DVec3),
    /// Width and height of the picture, pixels.
    pub size: [u32; 2],
    /// The distance of the nearest surface from a point along a direction, in lengths of it.
    pub surface: &'a mut dyn FnMut(DVec3, DVec3) -> Option<f64>,
}

impl Rig<'_> {
    fn aspect(&self) -> f64 {
        f64::from(self.size[0]) / f64::from(self.size[1])
    }

    /// Center and radius of the scene.
    pub fn ball(&self) -> (DVec3, f64) {
        let (low, high) = self.extent;
        let radius = ((high - low) * 0.5).length();
        ((low + high) * 0.5, if radius > 0.0 { radius } else { 1.0 })
    }

    /// Whether the camera is inside of the scene's box.
    fn is_inside(&self) -> bool {
        let eye = self.camera.eye.as_dvec3();
        eye.cmpge(self.extent.0).all() && eye.cmple(self.extent.1).all()
    }

    /// The surface at a place in the picture.
    fn seen(&mut self, [x, y]: [f64; 2]) -> Option<DVec3> {
        let (origin, direction) = motion::ray(&self.camera, self.size, [x, y])?;
        (self.surface)(origin, direction).map(|distance| origin + direction * distance)
    }

    fn middle(&self) -> [f64; 2] {
        self.size.map(|side| f64::from(side) * 0.5)
    }

    /// The point at a place in the picture, as deep as another one.
    fn level(&self, place: [f64; 2], depth: f64) -> DVec3 {
        let ray = motion::ray(&self.camera, self.size, place);
        ray.map_or(DVec3::ZERO, |(origin, direction)| origin + direction * depth)
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
    /// An orbit around a point; whether walls stop it.
    Orbit(DVec3, bool),
    /// The same, without a horizon.
    Roll(DVec3, bool),
    Look,
    /// A shift together with the points at this distance in front of the camera.
    Shift(f64),
}

/// A held button.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Held {
    button: Button,
    drag: Drag,
    from: [f32; 2],
    /// Whether it is a drag, and no click.
    is_drag: bool,
}

/// The held keys and buttons, and how a drag moves the camera.
#[derive(Debug, Default)]
pub struct Controls {
    keys: HashSet<Key>,
    modifiers: Modifiers,
    pointer: Option<[f32; 2]>,
    held: Option<Held>,
    pub mode: Mode,
    /// The point around which the camera turns; none for one in the middle of the picture.
    pub pivot: Option<DVec3>,
    /// The time, seconds, and that of the last click with its place.
    time: f64,
    clicked: Option<(f64, [f32; 2])>,
}

impl Controls {
    /// Handles an event. It may move the camera or return an action.
    pub fn handle(&mut self, event: &Event, free: Free, rig: &mut Rig<'_>) -> Option<Action> {
        match event {
            Event::Press(key) if free.keys && (self.keys.insert(*key) || STEPS.contains(key)) => {
                return self.pressed(*key, rig);
            }
            Event::Release(key) => drop(self.keys.remove(key)),
            Event::Modifiers(modifiers) => self.modifiers = *modifiers,
            Event::Move(x, y) => self.dragged([*x, *y], rig),
            Event::Button(button, true) if free.pointer && self.held.is_none() => {
                self.held = Some(self.begin(*button, rig));
            }
            Event::Button(button, false) => {
                let held = self.held.take_if(|held| held.button == *button);
                if held.is_some_and(|held| !held.is_drag && held.button == Button::Left) {
                    return self.click(rig);
                }
            }
            Event::Wheel(notches) if free.pointer => return self.wheel(f64::from(*notches), rig),
            Event::Pinch(factor) if free.pointer => {
                let notches = libm::log(f64::from(*factor).max(1e-3)) / libm::log(motion::NOTCH);
                let target = self.under_pointer(rig);
                return self.dolly(target, notches, rig);
            }
            Event::Pan(x, y) if free.pointer => {
                let depth = self.depth(rig);
                rig.camera = shifted(rig, depth, [f64::from(*x), f64::from(*y)]);
            }
            // Another window gets the release of a key.
            Event::Focus(false) => (self.keys, self.held) = (HashSet::new(), None),
            Event::Drop(path) => return Some(Action::Open(path.clone())),
            _ => {}
        }
        None
    }

    /// The point around which the camera turns now: the pivot if it is in front of the camera; else, inside of the scene,
    /// the surface in the middle of the picture; else the point in the middle that is as far away as the scene's center.
    fn center(&self, rig: &mut Rig<'_>) -> DVec3 {
        let middle = rig.middle();
        if let Some(pivot) = self.pivot
            && camera::depth(&rig.camera, pivot) > 0.0
        {
            return pivot;
        }
        let seen = if rig.is_inside() { rig.seen(middle) } else { None };
        seen.unwrap_or_else(|| rig.level(middle, camera::pivot(&rig.camera, rig.ball())))
    }

    /// How deep the pivot is in the picture.
    fn depth(&self, rig: &mut Rig<'_>) -> f64 {
        let center = self.center(rig);
        camera::depth(&rig.camera, center)
    }

    /// The surface under the pointer, or the point there that is as deep as the pivot.
    fn under_pointer(&self, rig: &mut Rig<'_>) -> DVec3 {
        let place = self.pointer.map_or(rig.middle(), |place| place.map(f64::from));
        rig.seen(place).unwrap_or_else(|| {
            let depth = self.depth(rig);
            rig.level(place, depth)
        })
    }

    fn begin(&self, button: Button, rig: &mut Rig<'_>) -> Held {
        let walls = rig.is_inside();
        let drag = match (button, self.mode) {
            (Button::Left, Mode::Turntable) => Drag::Orbit(self.center(rig), walls),
            (Button::Left, Mode::Trackball) => Drag::Roll(self.center(rig), walls),
            (Button::Middle, _) => Drag::Shift(self.depth(rig)),
            (Button::Right, _) | (Button::Left, Mode::Fly) => Drag::Look,
        };
        Held { button, drag, from: self.pointer.unwrap_or_default(), is_drag: false }
    }

    /// A click selects, and a second one at the same place puts the pivot there.
    fn click(&mut self, rig: &mut Rig<'_>) -> Option<Action> {
        let place = self.pointer?;
        let is_second = self.clicked.take().is_some_and(|(time, before)| {
            self.time - time <= DOUBLE && before.iter().zip(place).all(|(a, b)| (a - b).abs() <= STILL)
        });
        if !is_second {
            self.clicked = Some((self.time, place));
            return Some(Action::Select(place));
        }
        self.pivot = rig.seen(place.map(f64::from));
        Some(Action::Say(
            if self.pivot.is_some() { "pivot set" } else { "no surface: pivot in the middle" }.into(),
        ))
    }

    fn wheel(&mut self, notches: f64, rig: &mut Rig<'_>) -> Option<Action> {
        if self.modifiers.ctrl {
            rig.camera = camera::zoomed(&rig.camera, notches);
            return None;
        }
        let target = if self.modifiers.shift {
            self.under_pointer(rig)
        } else {
            let (middle, depth) = (rig.middle(), self.depth(rig));
            rig.level(middle, depth)
        };
        self.dolly(target, notches, rig)
    }

    /// Moves towards a point, up to what is in the way. To fly is to pass.
    fn dolly(&self, target: DVec3, notches: f64, rig: &mut Rig<'_>) -> Option<Action> {
        let (before, radius) = (rig.camera, rig.ball().1);
        let next = motion::dollied(&before, target, notches, radius * LEAST);
        if self.mode == Mode::Fly {
            rig.camera = next;
            return None;
        }
        let (camera, is_stopped) =
            motion::slowed(&before, &next, notches, radius * MARGIN, &mut *rig.surface);
        rig.camera = camera;
        is_stopped.then(|| Action::Say("a surface is in the way: W passes it, or T for the mode fly".into()))
    }

    fn pressed(&mut self, key: Key, rig: &mut Rig<'_>) -> Option<Action> {
        let digits = [Key::Num0, Key::Num1, Key::Num2, Key::Num3, Key::Num4, Key::Num5, Key::Num6];
        if self.modifiers.ctrl {
            let digit = digits.iter().position(|digit| *digit == key)?;
            return Some(Action::Debug(digit.checked_sub(1).map(|place| VIEWS[place])));
        }
        let mut look = |from, up| {
            rig.camera = camera::standard(&rig.camera, rig.ball(), rig.aspect(), from, up);
            None
        };
        match key {
            Key::T => {
                self.mode = self.mode.next();
                Some(Action::Say(self.mode.name().into()))
            }
            Key::O | Key::Num5 => {
                let depth = self.depth(rig);
                rig.camera = motion::parallel(&rig.camera, depth, FOV_Y);
                None
            }
            Key::F => Some(Action::Frame),
            Key::X => Some(Action::Axes),
            Key::G => Some(Action::Grid),
            Key::L => Some(Action::Objects),
            Key::Comma => Some(Action::Step(-FRAME)),
            Key::Period => Some(Action::Step(FRAME)),
            Key::ArrowLeft => Some(Action::File(-1)),
            Key::ArrowRight => Some(Action::File(1)),
            Key::Delete => Some(Action::Hide),
            Key::Backspace => Some(Action::ShowAll),
            Key::F11 => Some(Action::FullScreen),
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

    fn dragged(&mut self, to: [f32; 2], rig: &mut Rig<'_>) {
        let Some(mut from) = self.pointer.replace(to) else { return };
        let Some(held) = &mut self.held else { return };
        if !held.is_drag {
            if (0..2).all(|axis| (to[axis] - held.from[axis]).abs() <= STILL) {
                return;
            }
            // Nothing of the way is lost.
            (held.is_drag, from) = (true, held.from);
        }
        let [x, y] = [0, 1].map(|axis| f64::from(to[axis]) - f64::from(from[axis]));
        let (camera, margin) = (rig.camera, rig.ball().1 * MARGIN);
        rig.camera = match held.drag {
            Drag::Look => camera::turned(&camera, -x * TURN, -y * TURN),
            Drag::Shift(depth) => shifted(rig, depth, [x, y]),
            Drag::Orbit(pivot, walls) | Drag::Roll(pivot, walls) => {
                let motion =
                    if matches!(held.drag, Drag::Roll(..)) { motion::rolled } else { motion::orbited };
                let next = motion(&camera, pivot, -x * TURN, -y * TURN);
                if walls {
                    motion::kept_inside(&camera, &next, pivot, margin, &mut *rig.surface)
                } else {
                    next
                }
            }
        };
    }

    /// Moves the camera by the held keys for so many seconds.
    pub fn advance(&mut self, seconds: f64, rig: &mut Rig<'_>) {
        self.time += seconds;
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
            let step = rig.ball().1 * SPEED * fast * seconds;
            rig.camera = camera::moved(&rig.camera, way.map(|axis| axis * step));
        }
    }

    /// Whether a key or a button is held.
    pub fn is_busy(&self) -> bool {
        !self.keys.is_empty() || self.held.is_some()
    }

    /// The point around which a drag turns the camera.
    pub fn turns_around(&self) -> Option<DVec3> {
        match self.held {
            Some(Held { drag: Drag::Orbit(pivot, _) | Drag::Roll(pivot, _), is_drag: true, .. }) => {
                Some(pivot)
            }
            _ => None,
        }
    }
}

/// The camera shifted so that what is as deep as this follows a pointer that goes so many pixels.
fn shifted(rig: &Rig<'_>, depth: f64, [x, y]: [f64; 2]) -> Camera {
    let pixel = camera::height_at(&rig.camera, depth) / f64::from(rig.size[1]);
    camera::moved(&rig.camera, [-x * pixel, y * pixel, 0.0])
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use rtrt_core::scene::Projection;

    const FREE: Free = Free { keys: true, pointer: true };
    const CAMERA: Camera = Camera {
        eye: Vec3::new(0.0, 0.0, 5.0),
        look_at: Vec3::ZERO,
        up: Vec3::Y,
        projection: Projection::Perspective { fov_y: 1.0 },
    };

    /// The camera after these events and a second, and the actions. The scene is a cube around the origin, with a wall at
    /// z = 1.
    fn after(free: Free, events: &[Event]) -> (Camera, Vec<Action>) {
        let half = DVec3::splat(2.0 / 3.0_f64.sqrt());
        let mut surface = |from: DVec3, along: DVec3| (along.z < -1e-9).then(|| (1.0 - from.z) / along.z);
        let mut rig = Rig { camera: CAMERA, extent: (-half, half), size: [640, 360], surface: &mut surface };
        let mut controls = Controls::default();
        let actions = events.iter().filter_map(|event| controls.handle(event, free, &mut rig)).collect();
        controls.advance(1.0, &mut rig);
        (rig.camera, actions)
    }

    #[test]
    fn a_held_key_moves_until_it_is_released() {
        let (camera, _) = after(FREE, &[Event::Press(Key::W)]);
        assert!((camera.eye.z - (5.0 - 0.6)).abs() < 1e-5);
        for end in [Event::Release(Key::W), Event::Focus(false)] {
            let (camera, _) = after(FREE, &[Event::Press(Key::W), end]);
            assert_eq!(camera, CAMERA);
        }
    }

    #[test]
    fn a_drag_orbits_around_the_middle_of_the_scene() {
        let drag = [Event::Move(10.0, 10.0), Event::Button(Button::Left, true), Event::Move(110.0, 10.0)];
        let (camera, _) = after(FREE, &drag);
        assert!(camera.eye.x < -1.0 && (camera.eye.length() - 5.0).abs() < 1e-4);
        let (camera, _) =
            after(FREE, &[&drag[..], &[Event::Button(Button::Left, false), Event::Move(0.0, 0.0)]].concat());
        assert!(camera.eye.x < -1.0);
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
        let (camera, actions) = after(Free { keys: false, pointer: false }, &events);
        assert_eq!((camera, actions), (CAMERA, vec![]));
        assert_ne!(after(FREE, &events).0, CAMERA);
    }

    #[test]
    fn repetitions_of_a_held_key_are_ignored_unless_it_is_a_step() {
        let (_, actions) = after(FREE, &[Event::Press(Key::B), Event::Press(Key::B)]);
        assert_eq!(actions, [Action::Backend]);
        let (_, actions) = after(FREE, &[Event::Press(Key::ArrowRight), Event::Press(Key::ArrowRight)]);
        assert_eq!(actions, [Action::File(1), Action::File(1)]);
    }

    #[test]
    fn digits_choose_a_view_with_ctrl_and_a_side_without() {
        let ctrl = Event::Modifiers(Modifiers { ctrl: true, ..Modifiers::default() });
        let (camera, actions) =
            after(FREE, &[ctrl.clone(), Event::Press(Key::Num3), Event::Press(Key::Num0)]);
        assert_eq!(actions, [Action::Debug(Some(DebugView::Depth)), Action::Debug(None)]);
        assert_eq!(camera, CAMERA);
        let (camera, _) = after(FREE, &[Event::Press(Key::Num3)]);
        assert!(camera.eye.x > 2.0 && camera.eye.z.abs() < 1e-5);
    }

    const CLICK: [Event; 3] =
        [Event::Move(320.0, 180.0), Event::Button(Button::Left, true), Event::Button(Button::Left, false)];

    #[test]
    fn a_click_selects_and_a_second_one_sets_the_pivot() {
        let (camera, actions) = after(FREE, &CLICK);
        assert_eq!((camera, actions), (CAMERA, vec![Action::Select([320.0, 180.0])]));
        let (_, actions) = after(FREE, &[CLICK, CLICK].concat());
        assert_eq!(actions[1..], [Action::Say("pivot set".into())]);
        // The camera now turns around the wall, four units away.
        let drag = [Event::Button(Button::Left, true), Event::Move(420.0, 180.0)];
        let (camera, _) = after(FREE, &[&CLICK[..], &CLICK, &drag].concat());
        assert!((camera.eye.distance(Vec3::Z) - 4.0).abs() < 1e-4, "{}", camera.eye);
        // A slow second click is another selection.
        let mut controls = Controls::default();
        let mut none = |_, _| None;
        let half = DVec3::ONE;
        let mut rig = Rig { camera: CAMERA, extent: (-half, half), size: [640, 360], surface: &mut none };
        let mut said = Vec::new();
        for _ in 0..2 {
            said.extend(CLICK.iter().filter_map(|event| controls.handle(event, FREE, &mut rig)));
            controls.advance(0.5, &mut rig);
        }
        assert_eq!(said, [Action::Select([320.0, 180.0]), Action::Select([320.0, 180.0])]);
    }

    #[test]
    fn the_wheel_goes_nearer_and_with_ctrl_changes_the_focal_length() {
        let (camera, _) = after(FREE, &[Event::Wheel(1.0)]);
        // The wall on the way is nearer than the middle of the scene.
        let near = 1.0 + 4.0 / 1.15;
        assert!((camera.eye.z - near).abs() < 1e-4 && camera.projection == CAMERA.projection);
        let ctrl = Event::Modifiers(Modifiers { ctrl: true, ..Modifiers::default() });
        let (camera, _) = after(FREE, &[ctrl, Event::Wheel(1.0)]);
        assert!(camera.eye == CAMERA.eye && camera.projection != CAMERA.projection);
        let shift = Event::Modifiers(Modifiers { shift: true, ..Modifiers::default() });
        let (camera, _) = after(FREE, &[shift, Event::Move(640.0, 180.0), Event::Wheel(1.0)]);
        // Towards the wall on the right.
        assert!(camera.eye.x > 0.1 && (camera.eye.z - (1.0 + 4.0 / 1.15)).abs() < 1e-4, "{}", camera.eye);
    }

    #[test]
    fn the_wheel_stops_at_a_wall_and_flies_through_it_in_the_mode_fly() {
        let notches = vec![Event::Wheel(1.0); 100];
        for before in [vec![], vec![Event::Modifiers(Modifiers { shift: true, ..Modifiers::default() })]] {
            let (camera, said) = after(FREE, &[&before[..], &notches].concat());
            assert!(camera.eye.z > 1.0 && camera.eye.z < 1.01, "{}", camera.eye);
            assert!(
                matches!(said.last(), Some(Action::Say(text)) if text.contains("in the way")),
                "{said:?}"
            );
        }
        let fly = [Event::Press(Key::T), Event::Release(Key::T), Event::Press(Key::T)];
        assert!(after(FREE, &[&fly[..], &notches].concat()).0.eye.z < 0.0);
        let (pinched, _) = after(FREE, &vec![Event::Pinch(1.9); 30]);
        assert!(pinched.eye.z > 1.0 && pinched.eye.z < 1.01, "{}", pinched.eye);
    }

    #[test]
    fn fingers_pinch_and_shift() {
        let (camera, _) = after(FREE, &[Event::Move(320.0, 180.0), Event::Pinch(2.0)]);
        assert!((camera.eye.z - 3.0).abs() < 1e-4, "{}", camera.eye);
        let (camera, _) = after(FREE, &[Event::Pan(36.0, 0.0)]);
        assert!(camera.eye.x < -0.1 && camera.eye.y == 0.0);
    }

    #[test]
    fn modes_change_what_a_drag_does() {
        let drag = [Event::Move(0.0, 0.0), Event::Button(Button::Left, true), Event::Move(0.0, 400.0)];
        let mode = |times| {
            let key = [Event::Press(Key::T), Event::Release(Key::T)];
            let keys = vec![key; times].concat();
            after(FREE, &[&keys[..], &drag].concat())
        };
        let (turntable, said) = mode(3);
        assert_eq!(said, ["trackball", "fly", "turntable"].map(|name| Action::Say(name.into())));
        assert_eq!(turntable.up, Vec3::Y);
        assert!(turntable.eye.y > 4.9);
        // 2 radians go over the top.
        let (trackball, _) = mode(1);
        assert!(trackball.up.y < -0.3 && trackball.eye.z < -1.0, "{trackball:?}");
        let (fly, _) = mode(2);
        assert_eq!(fly.eye, CAMERA.eye);
    }
}

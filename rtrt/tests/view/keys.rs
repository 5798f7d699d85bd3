//! Every key and every button of the mouse does what the help says.

use crate::display::{Display, folder, lines, pixels, rendered, view};
use glam::DVec3;

/// What a printed command says after an option.
fn option<'a>(printed: &'a str, name: &str) -> Option<&'a str> {
    Some(printed.split_once(&format!(" {name} "))?.1.split(' ').next().unwrap())
}

/// Where a printed command has the camera: eye, where it looks, up, field of view.
#[derive(Clone, Copy)]
struct Seen {
    eye: DVec3,
    forward: DVec3,
    up: DVec3,
    fov: f64,
}

fn seen(printed: &str) -> Seen {
    let vector = |name: &str| {
        let numbers: Vec<f64> =
            option(printed, name).unwrap().split(',').map(|number| number.parse().unwrap()).collect();
        DVec3::new(numbers[0], numbers[1], numbers[2])
    };
    let (eye, look_at) = (vector("--eye"), vector("--look-at"));
    let fov = option(printed, "--fov-y").unwrap().parse().unwrap();
    Seen { eye, forward: (look_at - eye).normalize(), up: vector("--up").normalize(), fov }
}

/// What the camera is after each of these inputs, each from the beginning.
fn after(test: &str, inputs: &[&str]) -> Option<Vec<Seen>> {
    let folder = folder(test);
    let display = Display::start(&folder)?;
    let shots: Vec<String> = inputs
        .iter()
        .map(|input| format!("press Enter\nframe 0\nrelease Enter\n{input}press F12\nframe 0\nrelease F12\n"))
        .collect();
    let line = "demo:matchbox --size 64x36 --samples 1 --shadows off --backend cpu";
    let printed = lines(&view(&display, &folder, line, &shots.concat()));
    assert_eq!(printed.len(), inputs.len());
    Some(printed.iter().map(|printed| seen(printed)).collect())
}

#[test]
fn keys_move_along_the_cameras_own_axes() {
    let held = ["W", "S", "A", "D", "PageUp", "PageDown", "Q", "E"]
        .map(|key| format!("press {key}\nframe 0.5\nrelease {key}\n"));
    let fast = "modifiers shift\npress W\nframe 0.5\nrelease W\nmodifiers\n";
    let inputs: Vec<&str> = [""].into_iter().chain(held.iter().map(String::as_str)).chain([fast]).collect();
    let Some(seen) = after("keys", &inputs) else { return };
    let start = seen[0];
    let right = start.forward.cross(start.up).normalize();
    let axes = [start.forward, right, right.cross(start.forward)];
    let step = (seen[1].eye - start.eye).length();
    let wanted = [
        [1.0, 0.0, 0.0],
        [-1.0, 0.0, 0.0],
        [0.0, -1.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [0.0, 0.0, -1.0],
    ];
    for (number, way) in wanted.into_iter().enumerate() {
        let Seen { eye, forward, up, fov } = seen[1 + number];
        let moved = axes.map(|axis| (eye - start.eye).dot(axis) / step);
        assert!(
            moved.iter().zip(way).all(|(is, wanted)| (is - wanted).abs() < 1e-3),
            "{}: {moved:?}",
            inputs[1 + number]
        );
        assert!(forward.distance(start.forward) < 1e-3 && up == start.up && fov == start.fov);
    }
    let [q, e, fast] = [seen[7], seen[8], seen[9]];
    // What is on the right goes down with E, and up with Q.
    assert!(e.up.dot(right) > 0.1 && q.up.dot(right) < -0.1 && q.eye == start.eye && e.eye == start.eye);
    assert!(((fast.eye - start.eye).length() / step - 4.0).abs() < 1e-3);
}

#[test]
fn the_mouse_orbits_looks_shifts_and_goes_nearer() {
    let drag = |button: &str| {
        format!(
            "move 30 20\nbutton {button} down\nmove 40 18\nframe 0\nbutton {button} up\nmove 0 0\nframe 0\n"
        )
    };
    let (left, right, middle) = (drag("left"), drag("right"), drag("middle"));
    let zoom = |notches| format!("modifiers ctrl\nwheel {notches}\nmodifiers\n");
    let (longer, shorter) = (zoom(1), zoom(-1));
    let inputs = ["", &left, &right, &middle, "wheel 1\n", "wheel -1\n", &longer, &shorter];
    let Some(seen) = after("mouse", &inputs) else { return };
    let [start, orbit, look, shift, near, far, longer, shorter] = seen[..] else { panic!("too few") };
    // Around a point in front of the camera, which stays as far away.
    let turned = (orbit.forward - start.forward).length();
    let radius = (orbit.eye - start.eye).length() / turned;
    assert!(
        turned > 0.01
            && (orbit.eye + orbit.forward * radius).distance(start.eye + start.forward * radius)
                < 1e-3 * radius
    );
    assert!(look.eye == start.eye && (look.forward - start.forward).length() > 0.01);
    assert!(
        shift.forward.distance(start.forward) < 1e-3
            && (shift.eye - start.eye).dot(start.forward).abs() < 1e-3
    );
    assert!((shift.eye - start.eye).length() > 1e-3);
    let nearer = [near, far].map(|seen| (seen.eye - start.eye).dot(start.forward));
    assert!(nearer[0] > 1e-3 && nearer[1] < -1e-3 && near.fov == start.fov, "{nearer:?}");
    assert!(longer.fov < start.fov && shorter.fov > start.fov && longer.eye == start.eye);
}

#[test]
fn digits_look_from_the_sides() {
    let inputs = ["1", "3", "7", "9"].map(|digit| format!("press {digit}\nframe 0\nrelease {digit}\n"));
    let Some(seen) = after("sides", &inputs.each_ref().map(String::as_str)) else { return };
    for (seen, from) in seen.iter().zip([DVec3::Z, DVec3::X, DVec3::Y, DVec3::NEG_Z]) {
        assert!(seen.forward.distance(-from) < 1e-3, "{from}: {}", seen.forward);
    }
}

#[test]
fn ctrl_and_a_digit_show_what_a_frame_is_made_of() {
    let folder = folder("digits");
    let Some(display) = Display::start(&folder) else { return };
    let shots: String = (1..=6)
        .chain([0])
        .map(|digit| format!("modifiers ctrl\npress {digit}\nframe 0\nrelease {digit}\nmodifiers\npress F12\nframe 0\nrelease F12\n"))
        .collect();
    let line = "demo:glass --size 64x36 --samples 1 --backend cpu";
    let printed = lines(&view(&display, &folder, line, &shots));
    let views = ["albedo", "normal", "depth", "ids", "heat", "shadow"].map(Some).into_iter().chain([None]);
    for (number, (printed, view)) in printed.iter().zip(views).enumerate() {
        assert_eq!(option(printed, "--debug"), view);
        assert!(pixels(&folder, &format!("rtrt-000{number}.png")) == rendered(&folder, printed), "{printed}");
    }
    assert_eq!(printed.len(), 7);
}

//! Each entry of the panel, of the list of objects and of what is selected, by replays that point at their texts.

use crate::display::{
    Display, SCREEN, Window, changed, command, folder, lines, pixels, present, rendered, stderr,
};
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

/// So long lasts what egui animates.
const REST: &str = "frames 4 0.1\n";
const SHOT: &str = "press F12\nframe 0.1\nrelease F12\n";

fn key(key: &str) -> String {
    format!("press {key}\nframe 0.1\nrelease {key}\n{REST}")
}

/// A click where an event of a recording moves the pointer to.
fn click(at: &str) -> String {
    format!("{at}\nframe 0.1\nbutton left down\nframe 0.1\nbutton left up\n{REST}")
}

/// A click at a text.
fn choose(text: &str) -> String {
    click(&format!("point {text}"))
}

/// A number typed into the field beside a text.
fn set(text: &str, number: &str) -> String {
    click(&format!("beside {text}")) + &format!("text {number}\nframe 0.1\n") + &key("Enter")
}

/// A color of sRGB bytes, chosen beside a text.
fn tint(text: &str, bytes: [u8; 3]) -> String {
    // What stands before a number is a text of its own.
    let channel = |(name, byte): (char, u8)| {
        click(&format!("point {name} ")) + &format!("text {byte}\nframe 0.1\n") + &key("Enter")
    };
    let channels: String = ['R', 'G', 'B'].into_iter().zip(bytes).map(channel).collect();
    click(&format!("beside {text}")) + &channels + &key("Escape")
}

/// The linear light of an sRGB byte, by IEC 61966-2-1.
fn linear(byte: u8) -> f64 {
    let share = f64::from(byte) / 255.0;
    if share <= 0.04045 { share / 12.92 } else { ((share + 0.055) / 1.055).powf(2.4) }
}

/// Whether numbers between commas are the light of these bytes.
fn is_tint(numbers: &str, bytes: [u8; 3]) -> bool {
    let numbers: Vec<f64> = numbers.split(',').map(|number| number.parse().unwrap()).collect();
    numbers.len() == 3 && numbers.iter().zip(bytes).all(|(number, byte)| (number - linear(byte)).abs() < 1e-5)
}

/// Two triangles of one material, `left` and `right`, which two animations move, before two cameras, `front` and `side`.
fn write_scene(folder: &Path) {
    let positions = [-1.0, -1.0, 0.0, 1.0, -1.0, 0.0, 0.0, 1.0, 0.0];
    let (times, left, right) =
        ([0.0, 2.0], [-1.5, 0.0, 0.0, -1.5, 2.0, 0.0], [1.5, 0.0, 0.0, 1.5, -2.0, 0.0]);
    let numbers = positions.iter().chain(&times).chain(&left).chain(&right);
    let bytes: Vec<u8> = numbers.flat_map(|number: &f32| number.to_le_bytes()).collect();
    fs::write(folder.join("pair.bin"), bytes).unwrap();
    let gltf = r#"{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1, 2, 3]}],
        "nodes": [{"name": "left", "mesh": 0, "translation": [-1.5, 0, 0]},
            {"name": "right", "mesh": 0, "translation": [1.5, 0, 0]},
            {"name": "front", "camera": 0, "translation": [0, 0, 6]},
            {"name": "side", "camera": 1, "translation": [6, 0, 6], "rotation": [0, 0.38268343, 0, 0.92387953]}],
        "cameras": [{"name": "front", "type": "perspective", "perspective": {"yfov": 1.0, "znear": 0.1}},
            {"name": "side", "type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}}],
        "materials": [{"name": "paint", "doubleSided": true, "pbrMetallicRoughness": {"metallicFactor": 0}}],
        "meshes": [{"name": "tri", "primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
        "animations": [{"name": "rise", "samplers": [{"input": 1, "output": 2}],
                "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}]},
            {"name": "sink", "samplers": [{"input": 1, "output": 3}],
                "channels": [{"sampler": 0, "target": {"node": 1, "path": "translation"}}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
             "min": [-1, -1, 0], "max": [1, 1, 0]},
            {"bufferView": 1, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [2]},
            {"bufferView": 2, "componentType": 5126, "count": 2, "type": "VEC3"},
            {"bufferView": 3, "componentType": 5126, "count": 2, "type": "VEC3"}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 8},
            {"buffer": 0, "byteOffset": 44, "byteLength": 24}, {"buffer": 0, "byteOffset": 68, "byteLength": 24}],
        "buffers": [{"uri": "pair.bin", "byteLength": 92}]}"#;
    fs::write(folder.join("pair.gltf"), gltf).unwrap();
}

/// Replays inputs in one viewer, each followed by a screenshot. Returns the commands that are printed for these, whose
/// pictures are compared.
fn shots(test: &str, options: &str, inputs: &[String]) -> Option<Vec<String>> {
    let folder = folder(test);
    let display = Display::start(&folder)?;
    write_scene(&folder);
    for name in ["sky.hdr", "other/dawn.hdr"] {
        fs::create_dir_all(folder.join("other")).unwrap();
        let hdr = fs::File::create(folder.join(name)).unwrap();
        let light: Vec<_> = (0..128).map(|i| image::Rgb([i as f32 * 0.01, 0.5, 0.1])).collect();
        image::codecs::hdr::HdrEncoder::new(hdr).encode(&light, 16, 8).unwrap();
    }
    fs::write(folder.join("z.obj"), "v -2 0 -2\nv 2 0 -2\nv 0 0 2\nf 3 2 1\n").unwrap();
    fs::create_dir_all(folder.join("state/rtrt")).unwrap();
    fs::create_dir_all(folder.join("other")).unwrap();
    fs::copy(folder.join("z.obj"), folder.join("other/recent.obj")).unwrap();
    let recent = format!("{}\n", folder.join("other/recent.obj").display());
    fs::write(folder.join("state/rtrt/recent.txt"), recent).unwrap();
    let recording: String = inputs.iter().map(|input| format!("{input}{SHOT}")).collect();
    let output = replayed(&display, &folder, options, &recording);
    let printed = lines(&output);
    assert_eq!(printed.len(), inputs.len(), "{printed:?}");
    for (number, printed) in printed.iter().enumerate() {
        let shot = pixels(&folder, &format!("rtrt-{number:04}.png"));
        assert!(shot == rendered(&folder, printed), "{printed}");
    }
    Some(printed)
}

fn replayed(display: &Display, folder: &Path, options: &str, recording: &str) -> Output {
    fs::write(folder.join("input.txt"), format!("rtrt input 1\nframe 0.1\n{recording}")).unwrap();
    let line = format!("view pair.gltf --samples 1 --backend cpu --replay input.txt --size {options}");
    let mut viewer = command(folder, &line);
    viewer.env("DISPLAY", &display.name).env("XDG_STATE_HOME", folder.join("state")).output().unwrap()
}

fn option<'a>(printed: &'a str, name: &str) -> Option<&'a str> {
    Some(printed.split_once(&format!(" {name} "))?.1.split(' ').next().unwrap())
}

#[test]
fn picture_light_and_camera_of_the_panel() {
    let inputs = [
        key("P")
            + &(choose("soft") + &choose("hard"))
            + &set("transparency depth", "3")
            + &set("frames a second while moving", "30")
            // It is that of `--fps`, and is seen to be another one.
            + "point 30.0\nframe 0.1\n"
            + &(choose("neutral") + &choose("aces"))
            + &set("exposure", "1.5")
            + &set("turn", "30")
            + &set("intensity", "0.5")
            + &set("blur behind", "0.25"),
        choose("auto"),
        choose("camera") + &set("angle of view", "30"),
        choose("side"),
        // A drag looks around where the camera is.
        choose("turntable")
            + &choose("fly")
            + "move 100 700\nbutton left down\nframe 0.1\nmove 130 700\nframe 0.1\nbutton left up\nframe 0.1\n",
    ];
    let Some(printed) = shots("entries", "500x760", &inputs) else { return };
    let [picture, metered, lens, side, fly] = &printed[..] else { panic!("{printed:?}") };
    for wanted in [
        " --shadows hard ",
        " --transparency-depth 3 ",
        " --tone-map aces ",
        " --exposure 1.5 ",
        " --environment-intensity 0.5 ",
        " --environment-blur 0.25 ",
    ] {
        assert!(picture.contains(wanted), "{wanted}: {picture}");
    }
    assert_eq!(option(picture, "--environment-rotation"), Some("30"));
    assert!(option(metered, "--exposure") != Some("1.5"), "{metered}");
    assert_eq!(option(lens, "--fov-y"), Some("30"));
    assert_eq!(option(side, "--eye"), Some("6,0,6"));
    assert_eq!(option(fly, "--eye"), Some("6,0,6"));
    assert!(option(fly, "--look-at") != option(side, "--look-at"), "{fly}");
}

#[test]
fn environments_of_the_panel() {
    // An environment replaces ambient light and background, which are offered where there is none.
    let offered = "point ambient\nframe 0.1\npoint background\nframe 0.1\n";
    let inputs = [
        key("P") + &choose("studio") + &choose("none") + offered + &tint("ambient", [102, 51, 204]),
        choose("none") + &choose("studio") + &set("turn", "30"),
        // Files beside the scene are offered, and others are named.
        choose("studio") + &choose("sky.hdr"),
        choose("path, then Enter") + "text other/dawn.hdr\nframe 0.1\n" + &key("Enter"),
        choose("dawn.hdr") + &choose("none"),
    ];
    let Some(printed) = shots("environments", "500x760", &inputs) else { return };
    let chosen: Vec<_> = printed.iter().map(|line| option(line, "--environment").unwrap()).collect();
    assert!(chosen[..2] == ["none", "studio"] && chosen[2].ends_with("sky.hdr"), "{printed:?}");
    assert_eq!(chosen[3..], ["other/dawn.hdr", "none"]);
    let turns: Vec<_> = printed.iter().map(|line| option(line, "--environment-rotation")).collect();
    assert_eq!(turns, [None, Some("30"), Some("30"), Some("30"), None]);
    let ambient: Vec<_> = printed.iter().map(|line| option(line, "--ambient").is_some()).collect();
    assert_eq!(ambient, [true, false, false, false, true]);
    let folder = folder("offered");
    let Some(display) = Display::start(&folder) else { return };
    write_scene(&folder);
    let output = replayed(&display, &folder, "500x760", &(key("P") + "point ambient\nframe 0.1\n"));
    assert!(stderr(&output).contains("says \"ambient\""), "{}", stderr(&output));
}

#[test]
fn small_windows_show_what_they_have_room_for() {
    let small = "size 640 401 2\nframe 0.1\n";
    let inputs = [
        // The material is in sight.
        small.to_owned() + &click("move 228 215") + "frames 5 0.1\n" + &set("roughness", "0.5"),
        // The list of objects takes the place of the panel, and the panel that of the list.
        key("P")
            + "point samples\nframe 0.1\n"
            + &key("L")
            + "point find\nframe 0.1\n"
            + &key("P")
            + "point samples\nframe 0.1\n",
    ];
    let Some(printed) = shots("small", "640x401", &inputs) else { return };
    assert_eq!(option(&printed[0], "--material"), Some("0:roughness=0.5"));
    let folder = folder("covered");
    let Some(display) = Display::start(&folder) else { return };
    write_scene(&folder);
    let keys = small.to_owned() + &key("P") + &key("L") + "point samples\nframe 0.1\n";
    let output = replayed(&display, &folder, "640x401", &keys);
    assert!(stderr(&output).contains("says \"samples\""), "{}", stderr(&output));
}

#[test]
fn lights_and_colors_of_the_panel() {
    let inputs = [
        key("P")
            + &set("position", "1")
            + &set("direction", "0.5")
            + &set("angle", "30")
            + &set("power", "9")
            + &choose("reach")
            + &set("reach", "7")
            + &choose("fades with the square of the distance")
            + &set("radius", "0.25"),
        // Of two fields of that name, that of the sun is below.
        choose("1: sun") + &set("radius", "5"),
        tint("background", [102, 51, 204]),
    ];
    let lights = "--light spot:0,2,2:0,-1,-1:40:0.125 --light sun:0,1,1:2";
    let options = format!("500x760 {lights}");
    let Some(printed) = shots("lights", &options, &inputs) else { return };
    let lights = |number: usize| -> Vec<&str> {
        let rest = printed[number].split(" --light ").skip(1);
        rest.map(|light| light.split(' ').next().unwrap()).collect()
    };
    let [spot, sun] = lights(0)[..] else { panic!("{printed:?}") };
    let (ahead, rest) = spot.strip_prefix("spot:1,2,2:0.5,-1,-1:").unwrap().split_once(':').unwrap();
    assert!((ahead.parse::<f64>().unwrap() - 30.0).abs() < 1e-4, "{spot}");
    assert_eq!(rest, "0.25:color=9,9,9:reach=7:fade=linear");
    let radius = |sun: &str| sun.rsplit(':').next().unwrap().parse::<f64>().unwrap();
    assert!((radius(sun) - 2.0).abs() < 1e-4, "{sun}");
    let [same, sun] = lights(1)[..] else { panic!("{printed:?}") };
    assert!(same == spot && (radius(sun) - 5.0).abs() < 1e-4, "{sun}");
    let background = option(&printed[2], "--background").unwrap();
    assert!(is_tint(background, [102, 51, 204]), "{background}");
}

#[test]
fn colors_of_a_material() {
    let inputs = [
        click("move 76 400") + "frames 3 0.1\n" + &tint("color", [102, 51, 204]),
        tint("emission", [10, 20, 30]),
    ];
    let Some(printed) = shots("colors", "500x760", &inputs) else { return };
    let material = |number: usize| option(&printed[number], "--material").unwrap();
    let [painted, shining] = [0, 1].map(|number| material(number).strip_prefix("0:color=").unwrap());
    assert!(is_tint(painted, [102, 51, 204]), "{painted}");
    let (color, emission) = shining.split_once(":emission=").unwrap();
    assert!(color == painted && is_tint(emission, [10, 20, 30]), "{shining}");
}

#[test]
fn boxes_of_the_panel() {
    // The panel is small, so that all of it is seen, and is closed again.
    let open = format!("size 400 300 0.375\nframe 0.1\n{}{}", key("P"), choose("camera"));
    for (name, place) in [("axes", [0.8, 0.8, 1.0, 1.0]), ("grid", [0.0, 0.0, 0.7, 1.0])] {
        let folder = folder(&format!("box_{name}"));
        let Some(display) = Display::start(&folder) else { return };
        write_scene(&folder);
        let recording = format!("rtrt input 1\n{open}{}{}frames 1000000 0\n", choose(name), key("P"));
        fs::write(folder.join("input.txt"), recording).unwrap();
        let line = "pair.gltf --size 400x300 --samples 1 --backend cpu";
        command(&folder, &format!("render {line} -o plain.png")).status().unwrap();
        let plain = pixels(&folder, "plain.png");
        let mut window = Window::open(&display, &folder, &format!("view {line} --replay input.txt"));
        window.until(name, || {
            let seen = display.pixels([400, 300]);
            changed(&plain, &seen, place) > 20 && changed(&plain, &seen, [0.9, 0.0, 1.0, 0.4]) == 0
        });
    }
    let folder = folder("box_full");
    let Some(display) = Display::start(&folder) else { return };
    let geometry = || {
        let mut xdotool = Command::new("xdotool");
        xdotool.args(["search", "--onlyvisible", "--name", "rtrt", "getwindowgeometry"]);
        let output = xdotool.env("DISPLAY", &display.name).output();
        output.map(|output| String::from_utf8_lossy(&output.stdout).into_owned())
    };
    if present("xdotool", geometry()).is_none() {
        return;
    }
    write_scene(&folder);
    let recording = format!("rtrt input 1\n{open}{}frames 1000000 0.02\n", choose("full screen"));
    fs::write(folder.join("input.txt"), recording).unwrap();
    let line = "view pair.gltf --size 400x300 --samples 1 --backend cpu --replay input.txt";
    let mut window = Window::open(&display, &folder, line);
    window.until("it fills the screen", || geometry().unwrap().contains("Geometry: 800x600"));
}

#[test]
fn time_of_the_panel() {
    let inputs = [
        // What is animated has its time in sight.
        key("P") + &set("speed", "2") + &choose("play") + &choose("stop"),
        // Near the end of the slider, in front of the number.
        click("before 1.00"),
        choose("rise") + &choose("sink") + &click("before 0.00"),
        choose("sink") + &choose("all"),
        key("Enter"),
    ];
    let Some(printed) = shots("timeline", "500x760", &inputs) else { return };
    let time = |number: usize| option(&printed[number], "--time").unwrap().parse::<f64>().unwrap();
    // Twice as fast, for the frames from one click to the other.
    assert!((time(0) - 1.0).abs() < 1e-6, "{printed:?}");
    assert!(time(1) == 2.0 && time(2) == 2.0, "{printed:?}");
    assert_eq!((time(3), time(4)), (0.0, 0.0));
    assert_eq!(option(&printed[2], "--animation"), Some("1"));
    assert_eq!(option(&printed[3], "--animation"), Some("all"));
}

#[test]
fn files_of_the_panel() {
    let inputs = [key("P") + &choose("files") + &choose("next"), choose("previous"), choose("recent.obj")];
    let Some(printed) = shots("files", "500x760", &inputs) else { return };
    let scenes: Vec<_> = printed.iter().map(|line| line.split(' ').nth(2).unwrap()).collect();
    let ends = ["z.obj", "pair.gltf", "other/recent.obj"];
    assert!(scenes.iter().zip(ends).all(|(scene, end)| scene.ends_with(end)), "{printed:?}");
}

#[test]
fn debug_views_of_the_panel() {
    let views = ["albedo", "normal", "depth", "ids", "shadow", "uv", "blocks", "heat", "tests"];
    let before = ["picture"].into_iter().chain(views);
    let mut inputs: Vec<String> = before.zip(views).map(|(from, to)| choose(from) + &choose(to)).collect();
    inputs[0] = key("P") + &inputs[0];
    // The legend is there.
    inputs[0] += "point albedo: base colors\nframe 0.1\n";
    inputs.push(choose("tests") + &choose("picture"));
    let Some(printed) = shots("views", "300x500", &inputs) else { return };
    for (printed, view) in printed.iter().zip(views.into_iter().map(Some).chain([None])) {
        assert_eq!(option(printed, "--debug"), view);
    }
}

#[test]
fn materials_and_objects() {
    let list = "frames 3 0.1\n";
    let inputs = [
        // In the middle of the left triangle, and a moment without a second click.
        click("move 76 400")
            + list
            + &set("metallic", "0.25")
            + &set("roughness", "0.5")
            + &set("alpha", "0.75")
            + &set("transmission", "0.125"),
        choose("drawn"),
        key("L") + &click("before right (tri)") + &click("before left (tri)"),
        key("Backspace"),
        choose("find") + "text IGH\nframe 0.1\n" + &choose("right (tri)") + &key("F"),
        set("roughness", "1"),
    ];
    let Some(printed) = shots("materials", "500x760", &inputs) else { return };
    let [painted, hidden, switched, all, framed, again] = &printed[..] else { panic!("{printed:?}") };
    let material = "0:metallic=0.25:roughness=0.5:alpha=0.75:transmission=0.125";
    assert_eq!((option(painted, "--material"), option(painted, "--hide")), (Some(material), None));
    assert_eq!(option(hidden, "--hide"), Some("0"));
    assert_eq!((option(switched, "--hide"), option(all, "--hide")), (Some("1"), None));
    assert!(option(framed, "--eye") != option(all, "--eye"), "{framed}");
    assert_eq!(option(again, "--material"), Some("0:metallic=0.25:alpha=0.75:transmission=0.125"));
}

#[test]
fn a_text_that_is_not_seen_ends_the_replay() {
    let folder = folder("unseen");
    let Some(display) = Display::start(&folder) else { return };
    write_scene(&folder);
    let output = replayed(&display, &folder, "64x36", "point exposure\nframe 0.1\n");
    let said = stderr(&output);
    assert!(output.status.code() == Some(3) && said.contains("says \"exposure\""), "{said}");
}

#[test]
fn f11_fills_the_screen_and_leaves_it_and_files_are_remembered() {
    let folder = folder("full");
    let Some(display) = Display::start(&folder) else { return };
    write_scene(&folder);
    let xdotool = |words: &str| {
        let mut xdotool = Command::new("timeout");
        xdotool.args(["120", "xdotool"]).args(words.split(' ')).env("DISPLAY", &display.name).status()
    };
    if present("xdotool", xdotool("version")).is_none_or(|done| !done.success()) {
        return;
    }
    let state = folder.join("state");
    let line = "view pair.gltf --size 300x200 --samples 1 --backend cpu --record recorded.txt";
    let mut viewer = command(&folder, line);
    viewer.env("XDG_STATE_HOME", &state);
    let mut window = Window::run(viewer, &display, &folder);
    let is_drawn = |x, y| display.pixels(SCREEN).get_pixel(x, y).0[..3] != [0; 3];
    window.until("the window is there", || is_drawn(20, 20) && !is_drawn(700, 500));
    assert!(xdotool("search --sync --onlyvisible --name rtrt windowfocus --sync key F11").unwrap().success());
    window.until("it fills the screen", || is_drawn(700, 500));
    assert!(xdotool("key F11").unwrap().success());
    window.until("it has its size again", || is_drawn(20, 20) && !is_drawn(700, 500));
    assert!(xdotool("key Escape").unwrap().success());
    assert_eq!(window.viewer.wait().unwrap().code(), Some(0));
    let recent = fs::read_to_string(state.join("rtrt/recent.txt")).unwrap();
    assert!(recent.trim_end().ends_with("pair.gltf") && recent.lines().count() == 1, "{recent}");
    let recorded = fs::read_to_string(folder.join("recorded.txt")).unwrap();
    assert!(recorded.contains("press F11") && recorded.contains("size 800 600 "), "{recorded}");
    assert!(recorded.contains("press Escape"), "{recorded}");
}

#[test]
fn surfaces_hide_the_grid_behind_them() {
    let folder = folder("hidden");
    let Some(display) = Display::start(&folder) else { return };
    // A wall before the camera, which hides all of the grid but what is before it.
    fs::write(
        folder.join("wall.obj"),
        "v -9 0 0\nv 9 0 0\nv 9 9 0\nv -9 9 0\nv 0 0 4\nv 1 0 4\nv 0 0 5\nf 1 2 3 4\nf 5 6 7\n",
    )
    .unwrap();
    let line = "wall.obj --size 400x300 --samples 1 --backend cpu --eye 0,2,12 --look-at 0,2,0";
    command(&folder, &format!("render {line} -o plain.png")).status().unwrap();
    let plain = pixels(&folder, "plain.png");
    fs::write(
        folder.join("input.txt"),
        format!("rtrt input 1\nframe 0.1\n{}frames 1000000 0.02\n", key("G")),
    )
    .unwrap();
    let mut window = Window::open(&display, &folder, &format!("view {line} --replay input.txt"));
    // Behind the wall, its lines are 186 to 210 pixels from the top.
    let count = |place| changed(&plain, &display.pixels([400, 300]), place);
    window.until("the grid is before the wall and not behind it", || {
        count([0.0, 0.75, 1.0, 0.9]) > 200 && count([0.2, 0.63, 0.8, 0.69]) == 0
    });
}

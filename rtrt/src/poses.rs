//! Files of cameras: rtrt's own JSON, and NeRF's `transforms.json`.
//!
//! Both are an object with a list of cameras, `cameras` or `frames`, each an object. What an entry does not say, the
//! object around the list may say for all:
//!
//! | key | value |
//! |---|---|
//! | `name`, or `file_path` | what `{camera}` becomes; the path without its folder `./` and its ending |
//! | `matrix`, or `transform_matrix` | rows of the matrix from the camera's axes to world space: 4, or the 3 that are not 0, 0, 0, 1 |
//! | `axes` | `opengl` (x to the right, y up, z backward; the default), or `opencv` (y down, z forward) |
//! | `eye`, `look_at`, `up` | three numbers each, in place of a matrix; `up` is +y if nothing is said |
//! | `fl_x`, `fl_y`, `cx`, `cy`, or `fx`, `fy` | the lens, pixels from the upper left corner; `fl_y` is `fl_x`, and `cx`, `cy` are the middle if nothing is said |
//! | `camera_angle_x` | horizontal angle of view, radians |
//! | `fov_y` | vertical angle of view, degrees |
//! | `parallel` | parallel rays: the height of the picture, world units |
//! | `near`, `far` | the depths between which surfaces are drawn, world units; 0 and no limit if nothing is said |
//! | `size`, or `w` and `h` | pixels; else `--size` |
//! | `time` | of the animation, seconds |

use crate::pose::{Pinhole, placed};
use glam::{DMat4, DVec3, DVec4, Vec3};
use rtrt_core::grid::Grid;
use rtrt_core::scene::{Camera, Projection, Setup, SetupError};
use serde::Deserialize;
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// Why a file of cameras is refused.
#[derive(Debug, thiserror::Error)]
#[error("cameras refused: {}: {why}", path.display())]
pub struct PosesError {
    /// The file.
    pub path: PathBuf,
    /// The camera, and the reason.
    pub why: String,
    /// Whether the file is not there.
    pub is_missing: bool,
}

/// A camera of a file.
#[derive(Debug, Clone)]
pub struct Pose {
    /// Its name, which no other camera of the file has; without letters that names of files cannot have.
    pub name: String,
    placement: Placement,
    projection: Projection,
    /// The depths of its near and its far plane: 0 or more, and more than that, which may be infinite.
    pub clip: [f32; 2],
    /// The size of its picture.
    pub size: [u32; 2],
    /// Its time of the animation, seconds.
    pub time: Option<f64>,
}

/// Where a camera is, in the coordinates of the scene's file.
#[derive(Debug, Clone, Copy)]
enum Placement {
    Points {
        eye: DVec3,
        look_at: DVec3,
        up: Vec3,
    },
    /// From the camera's axes, x to the right, y up, z backward.
    Matrix(DMat4),
}

impl Pose {
    /// The camera in a scene whose coordinates are relative to this origin.
    pub fn camera(&self, origin: DVec3) -> Camera {
        let Self { placement, projection, .. } = *self;
        let points = |eye: DVec3, look_at: DVec3, up| {
            let [eye, look_at] = [eye, look_at].map(|point| (point - origin).as_vec3());
            Camera { eye, look_at, up, projection }
        };
        match placement {
            Placement::Points { eye, look_at, up } => points(eye, look_at, up),
            Placement::Matrix(matrix) => placed(&(DMat4::from_translation(-origin) * matrix), projection)
                // It was placed when it was read. What is not placed so far away is refused as a camera.
                .unwrap_or_else(|_| points(matrix.w_axis.truncate(), matrix.w_axis.truncate(), Vec3::Y)),
        }
    }
}

/// The cameras of a file, and warnings.
#[derive(Debug)]
pub struct Poses {
    /// The cameras.
    pub poses: Vec<Pose>,
    /// What is not drawn as the file says, a line each.
    pub warnings: Vec<String>,
}

/// The most cameras of a file.
const MOST: usize = 1_000_000;
/// The coefficients of lens distortion.
const DISTORTION: [&str; 8] = ["k1", "k2", "k3", "k4", "k5", "k6", "p1", "p2"];

/// What an entry may say.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(default, expecting = "a camera: an object with a pose and a lens")]
struct Keys {
    name: Option<String>,
    file_path: Option<String>,
    #[serde(alias = "transform_matrix")]
    matrix: Option<Vec<[f64; 4]>>,
    axes: Option<Axes>,
    eye: Option<[f64; 3]>,
    look_at: Option<[f64; 3]>,
    up: Option<[f32; 3]>,
    #[serde(alias = "fx")]
    fl_x: Option<f64>,
    #[serde(alias = "fy")]
    fl_y: Option<f64>,
    cx: Option<f64>,
    cy: Option<f64>,
    camera_angle_x: Option<f64>,
    fov_y: Option<f64>,
    parallel: Option<f32>,
    near: Option<f32>,
    /// Wider than what it becomes: whatever is too far for that is without end.
    far: Option<f64>,
    size: Option<[f64; 2]>,
    w: Option<f64>,
    h: Option<f64>,
    time: Option<f64>,
    #[serde(flatten)]
    others: BTreeMap<String, Value>,
}

#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Axes {
    OpenGl,
    OpenCv,
}

/// The object around the list.
#[derive(Debug, Deserialize)]
#[serde(expecting = "an object with a list, cameras or frames")]
struct Whole {
    cameras: Option<Vec<Keys>>,
    frames: Option<Vec<Keys>>,
    #[serde(flatten)]
    all: Keys,
}

/// The cameras of a file, for pictures of this size if it says nothing of one.
///
/// # Errors
/// The file cannot be read, or says what no camera can be.
pub fn read(path: &Path, size: [u32; 2]) -> Result<Poses, PosesError> {
    let refused = |why: String, is_missing| PosesError { path: path.to_owned(), why, is_missing };
    let bytes = fs::read(path)
        .map_err(|error| refused(error.to_string(), error.kind() == std::io::ErrorKind::NotFound))?;
    parse(&bytes, size).map_err(|why| refused(why, false))
}

fn parse(bytes: &[u8], size: [u32; 2]) -> Result<Poses, String> {
    // Some editors begin a file with this mark.
    let bytes = bytes.strip_prefix("\u{feff}".as_bytes()).unwrap_or(bytes);
    let whole: Whole = serde_json::from_slice(bytes).map_err(|error| format!("JSON: {error}"))?;
    let is_ours = whole.cameras.is_some();
    let list = whole.cameras.or(whole.frames).ok_or("it has neither cameras nor frames")?;
    if list.is_empty() || list.len() > MOST {
        return Err(format!("it has {} cameras, and not 1 to {MOST}", list.len()));
    }
    let mut warnings = Vec::new();
    let mut poses: Vec<Pose> = Vec::with_capacity(list.len());
    let mut known = BTreeMap::new();
    for (number, keys) in list.iter().enumerate() {
        let name = name(keys).unwrap_or(number.to_string());
        let place = |why: &str| format!("camera {number} ({name}): {why}");
        if let Some(key) = keys.others.keys().chain(whole.all.others.keys()).next().filter(|_| is_ours) {
            return Err(place(&format!("there is no key {key:?}")));
        }
        for keys in [keys, &whole.all] {
            let is_bent =
                |key: &&str| keys.others.get(*key).and_then(Value::as_f64).is_some_and(|k| k != 0.0);
            if DISTORTION.iter().any(is_bent) && warnings.is_empty() {
                warnings.push("the distortion of lenses is not drawn".into());
            }
        }
        let pose = pose(keys, &whole.all, size, name.clone()).map_err(|why| place(&why))?;
        if let Some(other) = known.insert(name.clone(), number) {
            return Err(place(&format!("camera {other} has that name, too")));
        }
        poses.push(pose);
    }
    Ok(Poses { poses, warnings })
}

/// What an entry is called.
fn name(keys: &Keys) -> Option<String> {
    let path = keys.file_path.as_ref().map(|path| {
        let path = path.trim_start_matches("./");
        let ending = path.rfind('.').filter(|dot| !path[*dot..].contains('/') && *dot > 0);
        path[..ending.unwrap_or(path.len())].to_owned()
    });
    keys.name.clone().or(path).map(|name| plain(&name)).filter(|name| !name.is_empty())
}

/// A name without what names of files cannot have.
pub fn plain(name: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "._-+ ".contains(c);
    name.chars().map(|c| if is_plain(c) { c } else { '_' }).collect()
}

fn pose(keys: &Keys, all: &Keys, size: [u32; 2], name: String) -> Result<Pose, String> {
    let own = |keys: &Keys| keys.size.or(keys.w.zip(keys.h).map(|(w, h)| [w, h]));
    let size = match own(keys).or(own(all)) {
        None => size,
        Some(sides) => {
            let most = f64::from(Setup::MAX_SIDE);
            if !sides.iter().all(|side| (1.0..=most).contains(side) && side.fract() == 0.0) {
                return Err(format!("its size is {sides:?}, which are not whole numbers of 1 to {most}"));
            }
            sides.map(|side| side as u32)
        }
    };
    let projection = projection(&lens(keys, all), size)?;
    let placement = match (keys.eye, keys.look_at, &keys.matrix) {
        (Some(eye), Some(look_at), _) => {
            let up = keys.up.or(all.up).map_or(Vec3::Y, Vec3::from);
            Placement::Points { eye: eye.into(), look_at: look_at.into(), up }
        }
        (None, None, Some(rows)) => {
            let rows = match rows[..] {
                [x, y, z] => [x, y, z, [0.0, 0.0, 0.0, 1.0]],
                [x, y, z, w] => [x, y, z, w],
                _ => return Err(format!("its matrix has {} rows, and not 3 or 4", rows.len())),
            };
            let mut matrix = DMat4::from_cols_array_2d(&rows).transpose();
            if keys.axes.or(all.axes) == Some(Axes::OpenCv) {
                matrix *= DMat4::from_diagonal(DVec4::new(1.0, -1.0, -1.0, 1.0));
            }
            placed(&matrix, projection)?;
            Placement::Matrix(matrix)
        }
        _ => return Err("it has neither a matrix nor eye and look_at".into()),
    };
    let time = keys.time.or(all.time);
    if time.is_some_and(|time| !(time >= 0.0 && time.is_finite())) {
        return Err("its time is not a number of 0 or more".into());
    }
    let near = keys.near.or(all.near).unwrap_or(0.0);
    let far = keys.far.or(all.far).map_or(f32::INFINITY, |far| far as f32);
    if !(near >= 0.0 && near < far) {
        return Err(format!("its near and far are {near} and {far}, and not 0 or more, and more than that"));
    }
    let pose = Pose { name, placement, projection, clip: [near, far], size, time };
    let eye = match placement {
        Placement::Points { eye, .. } => eye,
        Placement::Matrix(matrix) => matrix.w_axis.truncate(),
    };
    // Before any picture is rendered.
    match pose.camera(eye).view(Grid { width: size[0], height: size[1], side: 1 }) {
        Err(SetupError::Camera { why }) => Err(why.into()),
        Err(error) => Err(error.to_string()),
        Ok(_) => Ok(pose),
    }
}

/// What is said of the lens: the kind of the entry, or else that of all, and what of it the entry does not say.
fn lens(keys: &Keys, all: &Keys) -> Keys {
    let says = |keys: &Keys| {
        keys.parallel.is_some()
            || keys.fov_y.is_some()
            || keys.fl_x.is_some()
            || keys.camera_angle_x.is_some()
    };
    let kind = if says(keys) { keys } else { all };
    let (fl_y, cx, cy) = (keys.fl_y.or(all.fl_y), keys.cx.or(all.cx), keys.cy.or(all.cy));
    let Keys { parallel, fov_y, fl_x, camera_angle_x, .. } = *kind;
    Keys { parallel, fov_y, fl_x, camera_angle_x, fl_y, cx, cy, ..Keys::default() }
}

/// The projection of a lens; 45° if it says nothing.
fn projection(keys: &Keys, size: [u32; 2]) -> Result<Projection, String> {
    let is_angle = |angle: f64| angle > 0.0 && angle < core::f64::consts::PI;
    let middle = size.map(|side| 0.5 * f64::from(side));
    let (cx, cy) = (keys.cx.unwrap_or(middle[0]), keys.cy.unwrap_or(middle[1]));
    let lens = match *keys {
        Keys { parallel: None, fov_y: None, fl_x: Some(fx), .. } => {
            Pinhole { fx, fy: keys.fl_y.unwrap_or(fx), cx, cy }
        }
        Keys { parallel: None, fov_y: None, camera_angle_x: Some(angle), .. } if is_angle(angle) => {
            Pinhole { cx, cy, ..Pinhole::of_angle_x(angle, size) }
        }
        Keys { parallel: None, fov_y: None, camera_angle_x: Some(angle), .. } => {
            return Err(format!("its camera_angle_x is {angle}, which is not within 0 and π"));
        }
        _ if [cx, cy] != middle => return Err("its cx and cy need fx or camera_angle_x".into()),
        Keys { parallel: Some(height), .. } if height > 0.0 && height.is_finite() => {
            return Ok(Projection::Orthographic { height });
        }
        Keys { parallel: Some(height), .. } => {
            return Err(format!("its parallel is {height}, and not a number above 0"));
        }
        Keys { fov_y: None, fl_y: Some(_), .. } => return Err("its fy needs fx".into()),
        Keys { fov_y, .. } => {
            let degrees = fov_y.unwrap_or(45.0);
            let fov_y = degrees.to_radians();
            return if is_angle(fov_y) {
                Ok(Projection::Perspective { fov_y: fov_y as f32 })
            } else {
                Err(format!("its fov_y is {degrees}, which is not within 0 and 180 degrees"))
            };
        }
    };
    if !(lens.fx > 0.0 && lens.fy > 0.0 && lens.fx.is_finite() && lens.fy.is_finite()) {
        return Err("its focal lengths are not numbers above 0".into());
    }
    Ok(lens.projection(size))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [u32; 2] = [64, 48];

    fn one(text: &str) -> Result<Pose, String> {
        parse(text.as_bytes(), SIZE).map(|poses| poses.poses[0].clone())
    }

    #[test]
    fn numbers_come_back_as_they_were_printed() {
        let mut bits = 1_u64;
        for _ in 0..10_000 {
            bits = bits.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            // 1 to 2, with all digits.
            let number = f64::from_bits(1.0_f64.to_bits() | bits >> 12);
            assert_eq!(serde_json::from_str::<f64>(&number.to_string()).unwrap(), number);
        }
    }

    #[test]
    fn a_camera_is_a_point_and_a_target_or_a_matrix() {
        let placed = one(r#"{"cameras":[{"name":"a","eye":[1,2,3],"look_at":[1,2,0],"fov_y":90}]}"#).unwrap();
        assert_eq!((placed.name.as_str(), placed.size, placed.time), ("a", SIZE, None));
        let camera = placed.camera(DVec3::ZERO);
        assert_eq!(camera.projection, Projection::Perspective { fov_y: core::f32::consts::FRAC_PI_2 });
        // The same by a matrix, which OpenCV turns around x.
        let matrix = "[[1,0,0,1],[0,1,0,2],[0,0,1,3],[0,0,0,1]]";
        let turned = "[[1,0,0,1],[0,-1,0,2],[0,0,-1,3],[0,0,0,1]]";
        for (matrix, axes) in [(matrix, "opengl"), (turned, "opencv")] {
            let text = format!(r#"{{"axes":"{axes}","fov_y":90,"cameras":[{{"matrix":{matrix}}}]}}"#);
            let Camera { eye, look_at, up, projection } = one(&text).unwrap().camera(DVec3::ZERO);
            assert_eq!((eye, up, projection), (camera.eye, Vec3::Y, camera.projection));
            assert_eq!((look_at - eye).normalize(), -Vec3::Z);
        }
    }

    #[test]
    fn digits_far_from_the_origin_count() {
        let origin = DVec3::new(6e6, 0.0, -4e6);
        let points = r#"{"cameras":[{"eye":[6000000.25,1,-4000000],"look_at":[6000000.25,1,-4000000.5]}]}"#;
        let matrix = r#"{"cameras":[{"matrix":[[1,0,0,6000000.25],[0,1,0,1],[0,0,1,-4000000],[0,0,0,1]]}]}"#;
        for text in [points, matrix] {
            let camera = one(text).unwrap().camera(origin);
            assert_eq!(camera.eye, Vec3::new(0.25, 1.0, 0.0));
            assert_eq!((camera.look_at - camera.eye).normalize(), -Vec3::Z);
        }
    }

    #[test]
    fn nerf_files_are_read() {
        let text = r#"{"camera_angle_x":1.5707963267948966,"w":80.0,"h":40,"aabb_scale":16,"k1":0.01,"frames":[
            {"file_path":"./train/r_0.png","sharpness":9,"transform_matrix":[[1,0,0,0],[0,1,0,0],[0,0,1,4],[0,0,0,1]]},
            {"file_path":"./train/r_1","fl_x":100,"cx":10,"cy":30,"time":0.5,
             "transform_matrix":[[1,0,0,0],[0,1,0,0],[0,0,1,4],[0,0,0,1]]}]}"#;
        let Poses { poses, warnings } = parse(text.as_bytes(), SIZE).unwrap();
        assert_eq!(warnings, ["the distortion of lenses is not drawn"]);
        assert_eq!([&poses[0].name, &poses[1].name], ["train_r_0", "train_r_1"]);
        assert_eq!((poses[0].size, poses[1].time), ([80, 40], Some(0.5)));
        let edges = |left, right, bottom, top| Projection::OffCenter { left, right, bottom, top };
        assert_eq!(poses[0].projection, edges(-1.0, 1.0, -0.5, 0.5));
        assert_eq!(poses[1].projection, edges(-0.1, 0.7, -0.1, 0.3));
    }

    #[test]
    fn what_an_entry_does_not_say_of_its_lens_all_may_say() {
        let pose = r#""eye":[0,0,1],"look_at":[0,0,0]"#;
        let lens = |all: &str, own: &str| {
            one(&format!(r#"{{{all}"cameras":[{{{pose}{own}}}]}}"#)).unwrap().projection
        };
        let whole = lens("", r#","fx":100,"fy":80,"cx":10,"cy":30"#);
        assert_eq!(lens(r#""fx":100,"fy":80,"#, r#","cx":10,"cy":30"#), whole);
        assert_eq!(lens(r#""cx":10,"cy":30,"fy":80,"#, r#","fx":100"#), whole);
        assert_eq!(lens(r#""fov_y":50,"fy":80,"cx":10,"#, r#","fx":100,"cy":30"#), whole);
        let angled = lens(r#""camera_angle_x":1,"#, r#","cx":10"#);
        assert_eq!(angled, lens("", r#","camera_angle_x":1,"cx":10,"cy":24"#));
        // What a report says of a lens in the middle.
        assert_eq!(
            lens("", r#","fov_y":45,"fl_x":57.9,"fl_y":57.9,"cx":32.0,"cy":24.0,"parallel":null"#),
            lens("", "")
        );
    }

    #[test]
    fn matrices_may_lack_their_last_row_and_files_begin_with_a_mark() {
        let four = r#"{"cameras":[{"matrix":[[1,0,0,1],[0,1,0,2],[0,0,1,3],[0,0,0,1]]}]}"#;
        let three = "\u{feff}{\"cameras\":[{\"matrix\":[[1,0,0,1],[0,1,0,2],[0,0,1,3]]}]}";
        let [four, three] = [four, three].map(|text| one(text).unwrap().camera(DVec3::ZERO));
        assert_eq!(three, four);
    }

    #[test]
    fn what_is_wrong_is_named() {
        let camera = r#""eye":[0,0,1],"look_at":[0,0,0]"#;
        for (text, why) in [
            ("{}".into(), "it has neither cameras nor frames"),
            ("[]".into(), "JSON: invalid type: sequence, expected an object with a list, cameras or frames"),
            (r#"{"cameras":[3]}"#.into(), "JSON: invalid type: integer `3`, expected a camera: an object"),
            (r#"{"cameras":[{"matrix":[[1,0,0,1]]}]}"#.into(), "camera 0 (0): its matrix has 1 rows"),
            (
                format!(r#"{{"cameras":[{{{camera},"fov_y":3,"cx":3}}]}}"#),
                "camera 0 (0): its cx and cy need fx",
            ),
            (format!(r#"{{"cx":3,"cameras":[{{{camera}}}]}}"#), "camera 0 (0): its cx and cy need fx"),
            (format!(r#"{{"cameras":[{{{camera},"fy":3}}]}}"#), "camera 0 (0): its fy needs fx"),
            (
                format!(r#"{{"cameras":[{{{camera}}},{{"eye":[0,0,1],"look_at":[0,0,1]}}]}}"#),
                "camera 1 (1): eye and target coincide",
            ),
            (format!(r#"{{"cameras":[{{{camera},"up":[0,0,3]}}]}}"#), "camera 0 (0): up is along the view"),
            (format!(r#"{{"cameras":[{{{camera},"fx":9,"cx":1e30}}]}}"#), "camera 0 (0): the edges of the"),
            (r#"{"cameras":[]}"#.into(), "it has 0 cameras"),
            (r#"{"cameras":[{"eye":[0,0]}]}"#.into(), "JSON: invalid length 2"),
            (r#"{"cameras":[{"eye":[0,0,1]}]}"#.into(), "camera 0 (0): it has neither a matrix nor eye"),
            (format!(r#"{{"cameras":[{{{camera},"fovy":3}}]}}"#), "camera 0 (0): there is no key \"fovy\""),
            (format!(r#"{{"cameras":[{{{camera},"fov_y":180}}]}}"#), "camera 0 (0): its fov_y is 180"),
            (
                format!(r#"{{"cameras":[{{{camera},"parallel":-3}}]}}"#),
                "camera 0 (0): its parallel is -3, and not a number above 0",
            ),
            (format!(r#"{{"cameras":[{{{camera},"fl_x":-3}}]}}"#), "camera 0 (0): its focal lengths are"),
            (format!(r#"{{"cameras":[{{{camera},"size":[0,5]}}]}}"#), "camera 0 (0): its size is [0.0, 5.0]"),
            (format!(r#"{{"cameras":[{{{camera},"time":-1}}]}}"#), "camera 0 (0): its time is not"),
            (
                format!(r#"{{"cameras":[{{{camera},"name":"a/b"}},{{{camera},"name":"a_b"}}]}}"#),
                "camera 1 (a_b): camera 0 has that name, too",
            ),
            (
                r#"{"cameras":[{"matrix":[[0,0,0,0],[0,0,0,0],[0,0,0,0],[0,0,0,1]]}]}"#.into(),
                "camera 0 (0): an axis",
            ),
        ] {
            let error = one(&text).unwrap_err();
            assert!(error.starts_with(why), "{text}: {error}");
        }
    }
}

//! Files of cameras: rtrt's own JSON, and NeRF's `transforms.json`.
//!
//! Both are an object with a list of cameras, `cameras` or `frames`, each an object. What an entry does not say, the
//! object around the list may say for all:
//!
//! | key | value |
//! |---|---|
//! | `name`, or `file_path` | what `{camera}` becomes; the path without its folder `./` and its ending |
//! | `matrix`, or `transform_matrix` | rows of the matrix from the camera's axes to world space |
//! | `axes` | `opengl` (x to the right, y up, z backward; the default), or `opencv` (y down, z forward) |
//! | `eye`, `look_at`, `up` | three numbers each, in place of a matrix; `up` is +y if nothing is said |
//! | `fl_x`, `fl_y`, `cx`, `cy`, or `fx`, `fy` | the lens, pixels from the upper left corner; `fl_y` is `fl_x`, and `cx`, `cy` are the middle if nothing is said |
//! | `camera_angle_x` | horizontal angle of view, radians |
//! | `fov_y` | vertical angle of view, degrees |
//! | `parallel` | parallel rays: the height of the picture, world units |
//! | `size`, or `w` and `h` | pixels; else `--size` |
//! | `time` | of the animation, seconds |

use crate::pose::{Pinhole, placed};
use glam::{DMat4, DVec3, DVec4, Vec3};
use rtrt_core::scene::{Camera, Projection, Setup};
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

/// The vertical angle of view of a camera that has none, radians: 45°.
const FOV_Y: f32 = core::f32::consts::FRAC_PI_4;
/// The most cameras of a file.
const MOST: usize = 1_000_000;
/// The coefficients of lens distortion.
const DISTORTION: [&str; 8] = ["k1", "k2", "k3", "k4", "k5", "k6", "p1", "p2"];

/// What an entry may say.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(default)]
struct Keys {
    name: Option<String>,
    file_path: Option<String>,
    #[serde(alias = "transform_matrix")]
    matrix: Option<[[f64; 4]; 4]>,
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
    let projection = match projection(keys, size)? {
        Some(projection) => projection,
        None => projection(all, size)?.unwrap_or(Projection::Perspective { fov_y: FOV_Y }),
    };
    let placement = match (keys.eye, keys.look_at, &keys.matrix) {
        (Some(eye), Some(look_at), _) => {
            let up = keys.up.or(all.up).map_or(Vec3::Y, Vec3::from);
            Placement::Points { eye: eye.into(), look_at: look_at.into(), up }
        }
        (None, None, Some(rows)) => {
            let mut matrix = DMat4::from_cols_array_2d(rows).transpose();
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
    Ok(Pose { name, placement, projection, size, time })
}

/// The projection that an entry names, if it does.
fn projection(keys: &Keys, size: [u32; 2]) -> Result<Option<Projection>, String> {
    let is_angle = |angle: f64| angle > 0.0 && angle < core::f64::consts::PI;
    if let Some(height) = keys.parallel {
        if !(height > 0.0 && height.is_finite()) {
            return Err(format!("its parallel is {height}, and not a number above 0"));
        }
        return Ok(Some(Projection::Orthographic { height }));
    }
    if let Some(degrees) = keys.fov_y {
        let fov_y = degrees.to_radians();
        let why = format!("its fov_y is {degrees}, which is not within 0 and 180 degrees");
        return if is_angle(fov_y) {
            Ok(Some(Projection::Perspective { fov_y: fov_y as f32 }))
        } else {
            Err(why)
        };
    }
    let middle = size.map(|side| 0.5 * f64::from(side));
    let lens = match (keys.fl_x, keys.camera_angle_x) {
        (Some(fx), _) => Pinhole { fx, fy: keys.fl_y.unwrap_or(fx), cx: middle[0], cy: middle[1] },
        (None, Some(angle)) if is_angle(angle) => Pinhole::of_angle_x(angle, size),
        (None, Some(angle)) => {
            return Err(format!("its camera_angle_x is {angle}, which is not within 0 and π"));
        }
        (None, None) => return Ok(None),
    };
    let lens = Pinhole { cx: keys.cx.unwrap_or(lens.cx), cy: keys.cy.unwrap_or(lens.cy), ..lens };
    if !(lens.fx > 0.0 && lens.fy > 0.0 && lens.fx.is_finite() && lens.fy.is_finite()) {
        return Err("its focal lengths are not numbers above 0".into());
    }
    Ok(Some(lens.projection(size)))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [u32; 2] = [64, 48];

    fn one(text: &str) -> Result<Pose, String> {
        parse(text.as_bytes(), SIZE).map(|poses| poses.poses[0].clone())
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
    fn what_is_wrong_is_named() {
        let camera = r#""eye":[0,0,1],"look_at":[0,0,0]"#;
        for (text, why) in [
            ("{}".into(), "it has neither cameras nor frames"),
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

//! Environments: panoramas and cubes, from pictures.

use super::color::srgb_to_linear;
use super::{ImportError, file};
use glam::DVec3;
use image::{DynamicImage, ImageError, ImageFormat, ImageReader, Limits};
use rtrt_core::scene::{Cube, Light, Panorama, Scene, SceneError, studio};
use std::io::Cursor;
use std::path::{Path, PathBuf};

/// The limit of columns and rows of a picture.
const MAX_SIDE: u32 = 16_384;
/// The endings of a cube's pictures.
const ENDINGS: [&str; 5] = ["hdr", "exr", "png", "jpg", "jpeg"];

/// What surrounds a scene.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Surroundings {
    /// Its files.
    pub files: Vec<PathBuf>,
    /// Its brightest light, taken out of it; as it would be if the scene's environment were neither
    /// turned nor brightened.
    pub sun: Option<Light>,
}

impl Surroundings {
    /// [`Surroundings::sun`] as the scene's environment is turned and brightened.
    pub fn placed_sun(&self, scene: &Scene) -> Option<Light> {
        let sun = self.sun?;
        let (sine, cosine) = libm::sincos(f64::from(scene.environment_rotation));
        let d = sun.direction.as_dvec3();
        // Lookups are turned, so what is looked up is turned back.
        let direction = DVec3::new(d.x * cosine - d.z * sine, d.y, d.z * cosine + d.x * sine);
        let light = Light::sun(direction.as_vec3()).radius(sun.radius);
        Some(light.color(sun.color * scene.environment_intensity))
    }
}

/// How bright the studio is in the background, as a share of its light: what is white stands out.
const STUDIO_BACKDROP: f32 = 0.5;

/// Surrounds a scene with the built-in [`studio`], whose key light is the sun. In the background it has half of its light.
///
/// # Errors
/// The scene is full.
pub fn surround_with_studio(scene: &mut Scene) -> Result<Surroundings, SceneError> {
    let (panorama, key) = studio();
    scene.set_environment(&panorama)?;
    scene.backdrop_strength = STUDIO_BACKDROP;
    Ok(Surroundings { files: vec![], sun: Some(key) })
}

/// Lights a scene without lights as the command does: in the [`studio`], which is blurred in the background, with
/// its key light. Scenes with lights stay as they are.
///
/// # Errors
/// The scene is full.
pub fn light_by_default(scene: &mut Scene) -> Result<(), SceneError> {
    if scene.lights().is_empty() {
        let studio = surround_with_studio(scene)?;
        scene.environment_blur = 1.0;
        studio.placed_sun(scene).into_iter().for_each(|sun| scene.add_light(sun));
    }
    Ok(())
}

/// Surrounds the scene with the environment at `path`. With `takes_sun`, its sun is taken out of it, if it
/// has one; see [`Panorama::take_sun`].
///
/// | file or folder | environment |
/// |---|---|
/// | a folder with pictures named px, nx, py, ny, pz, nz, all square and of one size | a [`Cube`] |
/// | a picture of 2 to 1 | a [`Panorama`] |
/// | a picture of 6 to 1, or 1 to 6 | a cube, px, nx, py, ny, pz, nz side by side, or below one another |
/// | a picture of 4 to 3 | a cube unfolded: nx, pz, px, nz in the middle row, py above pz, ny below |
/// | a picture of 3 to 4 | the same with nz, upside down, below ny |
///
/// Any other picture is refused. Photographs are 4 to 3, too, so a cross must be empty beside its arms: of one color.
///
/// Pictures are Radiance RGBE (`.hdr`) or OpenEXR (`.exr`), which are linear, or PNG or JPEG, which are sRGB
/// and at most 1.
///
/// # Errors
/// A file cannot be read, or has another shape.
pub fn surround(scene: &mut Scene, path: &Path, takes_sun: bool) -> Result<Surroundings, ImportError> {
    let refused = |source| ImportError::Scene { path: path.to_owned(), source };
    let (files, mut cube) = if path.is_dir() {
        let files = faces(path)?;
        let cube = assembled(&files)?;
        (files.into(), cube)
    } else {
        let mut picture = read(path)?;
        let files = vec![path.to_owned()];
        let cube = unfolded(&picture);
        match cube.map_err(|why| ImportError::Environment { path: path.to_owned(), why })? {
            Some(cube) => (files, cube),
            None => {
                let sun = takes_sun.then(|| picture.take_sun()).flatten();
                scene.set_environment(&picture).map_err(refused)?;
                scene.backdrop_strength = 1.0;
                return Ok(Surroundings { files, sun });
            }
        }
    };
    let sun = takes_sun.then(|| cube.take_sun()).flatten();
    scene.set_cube(&cube).map_err(refused)?;
    scene.backdrop_strength = 1.0;
    Ok(Surroundings { files, sun })
}

/// The pictures of a cube in a folder, in the order of its faces.
fn faces(folder: &Path) -> Result<[PathBuf; 6], ImportError> {
    let find = |name: &str| {
        let mut paths = ENDINGS.iter().map(|ending| folder.join(format!("{name}.{ending}")));
        paths.find(|path| path.is_file())
    };
    if let Some(name) = Cube::NAMES.iter().find(|name| find(name).is_none()) {
        let why = format!("it has no picture {name} (.{})", ENDINGS.join(", ."));
        return Err(ImportError::Environment { path: folder.to_owned(), why });
    }
    Ok(Cube::NAMES.map(|name| find(name).unwrap_or_default()))
}

/// The cube with these pictures as faces.
fn assembled(files: &[PathBuf; 6]) -> Result<Cube, ImportError> {
    let mut cube = Cube { side: 0, faces: Default::default() };
    for (face, path) in cube.faces.iter_mut().zip(files) {
        let Panorama { width, height, rgb } = read(path)?;
        let refused = |why| Err(ImportError::Environment { path: path.clone(), why });
        if width != height {
            return refused(format!(
                "pictures of a cube are square, and this one has {width} x {height} pixels"
            ));
        }
        if cube.side != 0 && cube.side != width {
            return refused(format!("it has {width} columns, but {} has {}", files[0].display(), cube.side));
        }
        (cube.side, *face) = (width, rgb);
    }
    Ok(cube)
}

/// The cube in a picture, by its shape; none for a panorama. Any other shape is an error.
fn unfolded(picture: &Panorama) -> Result<Option<Cube>, String> {
    // Columns and rows of px, nx, py, ny, pz, nz.
    const LAYOUTS: [([u32; 2], [[u32; 2]; 6]); 4] = [
        ([6, 1], [[0, 0], [1, 0], [2, 0], [3, 0], [4, 0], [5, 0]]),
        ([1, 6], [[0, 0], [0, 1], [0, 2], [0, 3], [0, 4], [0, 5]]),
        ([4, 3], [[2, 1], [0, 1], [1, 0], [1, 2], [1, 1], [3, 1]]),
        ([3, 4], [[2, 1], [0, 1], [1, 0], [1, 2], [1, 1], [1, 3]]),
    ];
    let &Panorama { width, height, .. } = picture;
    // Rows may be rounded.
    if width.abs_diff(2 * height) <= 1 {
        return Ok(None);
    }
    let fits =
        |&([columns, rows], _): &([u32; 2], _)| width % columns == 0 && width / columns * rows == height;
    let Some((shape, places)) = LAYOUTS.into_iter().find(fits) else {
        return Err(format!(
            "it has {width} x {height} pixels; a panorama is 2:1, a cube 6:1, 1:6, or as a cross 4:3 or 3:4"
        ));
    };
    let side = width / shape[0];
    let beside = (0..shape[0]).flat_map(|column| (0..shape[1]).map(move |row| [column, row]));
    if let Some([column, row]) = beside
        .filter(|place| !places.contains(place))
        .find(|place| !is_empty(picture, place.map(|place| place * side), side))
    {
        return Err(format!(
            "it is {}:{}, as a cube unfolded to a cross is, but not empty beside the cross, at {},{}; \
             a panorama is 2:1",
            shape[0],
            shape[1],
            column * side,
            row * side
        ));
    }
    let face = |place: [u32; 2]| -> Vec<[f32; 3]> {
        let [x, y] = place.map(|place| place * side);
        (y..y + side).flat_map(|y| row(picture, [x, y], side)).copied().collect()
    };
    let mut faces = places.map(face);
    if shape == [3, 4] {
        faces[5].reverse();
    }
    Ok(Some(Cube { side, faces }))
}

/// Whether the middle of a square of a picture has one color. The rest is ignored: JPEG files are not exact beside
/// edges.
fn is_empty(picture: &Panorama, [x, y]: [u32; 2], side: u32) -> bool {
    let (margin, middle) = (side / 4, side - 2 * (side / 4));
    let texels = || (y..y + middle).flat_map(|y| row(picture, [x + margin, y + margin], middle));
    (0..3).all(|channel| {
        let (low, high) = texels()
            .map(|texel| texel[channel])
            .fold((f32::MAX, 0.0_f32), |(low, high), value| (low.min(value), high.max(value)));
        high - low <= 0.05 * high + 0.002
    })
}

/// Texels of a picture's row from this one on.
fn row(picture: &Panorama, [x, y]: [u32; 2], count: u32) -> &[[f32; 3]] {
    let start = (y * picture.width + x) as usize;
    &picture.rgb[start..start + count as usize]
}

/// A picture in linear light.
fn read(path: &Path) -> Result<Panorama, ImportError> {
    let refused = |why| ImportError::Environment { path: path.to_owned(), why };
    let bytes = file::read(path, file::LONGEST).map_err(|error| refused(error.to_string()))?;
    decode(&bytes).map_err(refused)
}

fn decode(bytes: &[u8]) -> Result<Panorama, String> {
    if bytes.is_empty() {
        return Err("it is empty".into());
    }
    let format = match image::guess_format(bytes) {
        _ if bytes.starts_with(b"#?") => ImageFormat::Hdr,
        Ok(format @ (ImageFormat::OpenExr | ImageFormat::Png | ImageFormat::Jpeg)) => format,
        _ => return Err("it is not in the Radiance format (.hdr), nor OpenEXR, PNG or JPEG".into()),
    };
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut limits = Limits::default();
    limits.max_image_width = Some(MAX_SIDE);
    limits.max_image_height = Some(MAX_SIDE);
    limits.max_alloc = Some(12 * u64::from(MAX_SIDE) * u64::from(MAX_SIDE));
    reader.limits(limits);
    let picture = reader.decode().map_err(|error| damaged(&error))?;
    let (width, height) = (picture.width(), picture.height());
    let rgb = if matches!(format, ImageFormat::Hdr | ImageFormat::OpenExr) {
        picture.into_rgb32f().pixels().map(|pixel| pixel.0).collect()
    } else {
        linear(picture)
    };
    Ok(Panorama { width, height, rgb })
}

/// Why a picture cannot be read, in a line.
fn damaged(error: &ImageError) -> String {
    let detail = error.to_string().replace('\n', " ");
    match error {
        ImageError::Limits(_) => format!("it has more than {MAX_SIDE} columns or rows ({detail})"),
        ImageError::IoError(_) => format!("it ends too early, or is damaged ({detail})"),
        ImageError::Unsupported(_) => format!("it is of a kind that is not read ({detail})"),
        _ => format!("it is damaged ({detail})"),
    }
}

/// The linear light of a picture's pixels.
fn linear(picture: DynamicImage) -> Vec<[f32; 3]> {
    let table: Vec<f32> =
        (0..=u16::MAX).map(|channel| srgb_to_linear(f64::from(channel) / 65_535.0)).collect();
    picture.into_rgb16().pixels().map(|pixel| pixel.0.map(|channel| table[usize::from(channel)])).collect()
}

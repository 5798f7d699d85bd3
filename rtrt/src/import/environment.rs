//! Environments: panoramas and cubes, from pictures.

use super::{ImportError, file};
use image::{DynamicImage, ImageFormat, ImageReader, Limits};
use rtrt_core::scene::{Cube, Panorama, Scene};
use std::io::Cursor;
use std::path::{Path, PathBuf};

/// The most columns or rows of a picture.
const MAX_SIDE: u32 = 16_384;
/// How names of a cube's pictures may end.
const ENDINGS: [&str; 4] = ["hdr", "png", "jpg", "jpeg"];

/// Surrounds the scene with the environment at `path`, and returns the files that it consists of.
///
/// | what is there | what it is |
/// |---|---|
/// | a folder with pictures named px, nx, py, ny, pz, nz, all square and of one size | a [`Cube`] |
/// | a picture of 6 to 1, or 1 to 6 | a cube, px, nx, py, ny, pz, nz side by side, or below one another |
/// | a picture of 4 to 3 | a cube unfolded: nx, pz, px, nz in the middle row, py above pz, ny below |
/// | a picture of 3 to 4 | the same with nz, upside down, below ny |
/// | any other picture | a [`Panorama`] |
///
/// Pictures are Radiance RGBE (`.hdr`), whose numbers are light, or PNG or JPEG, whose numbers are
/// sRGB, 1 at most.
///
/// # Errors
/// A file cannot be read, or is no such picture.
pub fn surround(scene: &mut Scene, path: &Path) -> Result<Vec<PathBuf>, ImportError> {
    let (files, result) = if path.is_dir() {
        let files = faces(path)?;
        let cube = assembled(&files)?;
        (files.into(), scene.set_cube(&cube))
    } else {
        let picture = read(path)?;
        let result = match unfolded(&picture) {
            Some(cube) => scene.set_cube(&cube),
            None => scene.set_environment(&picture),
        };
        (vec![path.to_owned()], result)
    };
    result.map_err(|source| ImportError::Scene { path: path.to_owned(), source })?;
    Ok(files)
}

/// The pictures of a cube in a folder, in their order.
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

/// The cube of these pictures.
fn assembled(files: &[PathBuf; 6]) -> Result<Cube, ImportError> {
    let mut cube = Cube { side: 0, faces: Default::default() };
    for (face, path) in cube.faces.iter_mut().zip(files) {
        let Panorama { width, height, rgb } = read(path)?;
        let refused = |why| Err(ImportError::Environment { path: path.clone(), why });
        if width != height {
            return refused(format!(
                "a picture of a cube has to be square, and it has {width} x {height} pixels"
            ));
        }
        if cube.side != 0 && cube.side != width {
            return refused(format!("it has {width} columns, and {} {}", files[0].display(), cube.side));
        }
        (cube.side, *face) = (width, rgb);
    }
    Ok(cube)
}

/// The cube that a picture is, by its shape; none if it is a panorama.
fn unfolded(picture: &Panorama) -> Option<Cube> {
    // Columns and rows of px, nx, py, ny, pz, nz.
    const LAYOUTS: [([u32; 2], [[u32; 2]; 6]); 4] = [
        ([6, 1], [[0, 0], [1, 0], [2, 0], [3, 0], [4, 0], [5, 0]]),
        ([1, 6], [[0, 0], [0, 1], [0, 2], [0, 3], [0, 4], [0, 5]]),
        ([4, 3], [[2, 1], [0, 1], [1, 0], [1, 2], [1, 1], [3, 1]]),
        ([3, 4], [[2, 1], [0, 1], [1, 0], [1, 2], [1, 1], [1, 3]]),
    ];
    let &Panorama { width, height, ref rgb } = picture;
    let fits =
        |&([columns, rows], _): &([u32; 2], _)| width % columns == 0 && width / columns * rows == height;
    let (shape, places) = LAYOUTS.into_iter().find(fits)?;
    let side = width / shape[0];
    let face = |[column, row]: [u32; 2]| -> Vec<[f32; 3]> {
        let line = |y: u32| {
            let start = ((row * side + y) * width + column * side) as usize;
            &rgb[start..start + side as usize]
        };
        (0..side).flat_map(line).copied().collect()
    };
    let mut faces = places.map(face);
    if shape == [3, 4] {
        faces[5].reverse();
    }
    Some(Cube { side, faces })
}

/// A picture, linear.
fn read(path: &Path) -> Result<Panorama, ImportError> {
    let bytes = file::read(path, file::LONGEST)
        .map_err(|source| ImportError::Unreadable { path: path.to_owned(), source })?;
    decode(&bytes).map_err(|why| ImportError::Environment { path: path.to_owned(), why })
}

fn decode(bytes: &[u8]) -> Result<Panorama, String> {
    let format = match image::guess_format(bytes) {
        _ if bytes.starts_with(b"#?") => ImageFormat::Hdr,
        Ok(format @ (ImageFormat::Png | ImageFormat::Jpeg)) => format,
        _ => return Err("it is not in the Radiance format (.hdr), nor PNG or JPEG".into()),
    };
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut limits = Limits::default();
    limits.max_image_width = Some(MAX_SIDE);
    limits.max_image_height = Some(MAX_SIDE);
    limits.max_alloc = Some(12 * u64::from(MAX_SIDE) * u64::from(MAX_SIDE));
    reader.limits(limits);
    let picture = reader.decode().map_err(|error| error.to_string().replace('\n', " "))?;
    let (width, height) = (picture.width(), picture.height());
    let rgb = if format == ImageFormat::Hdr {
        picture.into_rgb32f().pixels().map(|pixel| pixel.0).collect()
    } else {
        linear(picture)
    };
    Ok(Panorama { width, height, rgb })
}

/// The light that sRGB stands for (IEC 61966-2-1), computed in `f64` by `libm`, so that hosts agree.
fn linear(picture: DynamicImage) -> Vec<[f32; 3]> {
    let light = |channel: u16| {
        let c = f64::from(channel) / 65_535.0;
        (if c <= 0.04045 { c / 12.92 } else { libm::pow((c + 0.055) / 1.055, 2.4) }) as f32
    };
    let table: Vec<f32> = (0..=u16::MAX).map(light).collect();
    picture.into_rgb16().pixels().map(|pixel| pixel.0.map(|channel| table[usize::from(channel)])).collect()
}

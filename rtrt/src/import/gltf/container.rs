//! The JSON and the binary chunk of a file.

use super::extensions::{BASISU, SUPPORTED, WEBP};
use crate::import::ImportError;
use crate::import::builder::Builder;
use crate::import::error::quoted;
use gltf_json::mesh::Semantic;
use gltf_json::validation::{self, Checked, Validate};
use gltf_json::{Index, Root, Value};

/// The first bytes of a binary file.
pub(super) const MAGIC: &[u8] = b"glTF";

/// The JSON of a file, and its binary chunk if it has one.
///
/// # Errors
/// It is not glTF 2.0, or requires an extension that is not implemented.
pub(super) fn open<'a, J: rtrt_core::scene::Join>(
    builder: &mut Builder<'_, J>,
    bytes: &'a [u8],
) -> Result<(Root, Option<&'a [u8]>), ImportError> {
    let path = builder.path.clone();
    let invalid = |why| ImportError::Invalid { path: path.clone(), why };
    let (json, binary) = if bytes.starts_with(MAGIC) {
        let (json, binary) = chunks(bytes).map_err(|why| invalid(why.into()))?;
        // The padding has to be spaces; some exporters write zeros.
        (trim_zeros(json), binary)
    } else if super::looks_like(bytes) {
        (bytes, None)
    } else {
        return Err(invalid("it begins neither as JSON does ({) nor as binary glTF (glTF)".into()));
    };
    let (mut root, warning) = parse(json).map_err(|error| invalid(format!("JSON: {error}")))?;
    warning.into_iter().for_each(|warning| builder.warn(warning));
    take_images_of_extensions(&mut root);
    let version = root.asset.min_version.as_ref().unwrap_or(&root.asset.version);
    if version.split('.').next() != Some("2") {
        return Err(invalid(format!("glTF {}, but only glTF 2 is supported", version.escape_debug())));
    }
    if let Some(name) = root.extensions_required.iter().find(|name| !SUPPORTED.contains(&name.as_str())) {
        let extension = name.escape_debug().to_string();
        return Err(ImportError::Extension { path: builder.path.clone(), extension });
    }
    if let Some(place) = dangling(&root) {
        return Err(invalid(format!("{} is not there", place.escape_debug())));
    }
    for name in root.extensions_used.iter().filter(|name| !SUPPORTED.contains(&name.as_str())) {
        builder.warn(format!("the extension {} is not supported", quoted(name)));
    }
    Ok((root, binary))
}

/// Gives textures the images that extensions name in place of PNG and JPEG ones.
fn take_images_of_extensions(root: &mut Root) {
    for texture in &mut root.textures {
        let extensions = texture.extensions.as_ref().map(|extensions| &extensions.others);
        let source = extensions
            .and_then(|others| others.get(WEBP).or_else(|| others.get(BASISU))?.get("source")?.as_u64());
        if let Some(source) = source {
            texture.source = Index::new(u32::try_from(source).unwrap_or(u32::MAX - 1));
        }
    }
}

/// The place of a reference to a missing element, drawn or not. Other errors are found in the content
/// that is drawn.
fn dangling(root: &Root) -> Option<String> {
    // The validation does not check this index before it uses it.
    for (mesh, source) in root.meshes.iter().enumerate() {
        for (primitive, source) in source.primitives.iter().enumerate() {
            let positions = source.attributes.get(&Checked::Valid(Semantic::Positions));
            if positions.is_some_and(|index| root.get(*index).is_none()) {
                return Some(format!("meshes[{mesh}].primitives[{primitive}].attributes.POSITION"));
            }
        }
    }
    let mut place = None;
    root.validate(root, gltf_json::Path::new, &mut |path, error| {
        if error == validation::Error::IndexOutOfBounds && place.is_none() {
            place = Some(path().to_string());
        }
    });
    place
}

/// The JSON chunk and the binary chunk of a `.glb`. Other chunks and bytes after the end are
/// ignored, as the format requires.
fn chunks(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), &'static str> {
    let word = |at: usize| bytes.get(at..at + 4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    match word(4) {
        Some(2) => {}
        Some(1) => return Err("binary glTF 1, but only glTF 2 is supported"),
        _ => return Err("the binary header has no known version"),
    }
    let length = word(8).ok_or("the binary header is cut off")? as usize;
    let bytes = bytes.get(..length).ok_or("the file is shorter than its header says")?;
    let (mut json, mut binary) = (None, None);
    let mut at = 12;
    while at < bytes.len() {
        let (Some(size), Some(kind)) = (word(at), bytes.get(at + 4..at + 8)) else {
            return Err("a chunk header is cut off");
        };
        let chunk = bytes.get(at + 8..).and_then(|rest| rest.get(..size as usize));
        let chunk = chunk.ok_or("a chunk is longer than the file")?;
        match kind {
            b"JSON" if json.is_none() && binary.is_none() => json = Some(chunk),
            b"BIN\0" if json.is_some() && binary.is_none() => binary = Some(chunk),
            _ if json.is_none() => return Err("the first chunk is not JSON"),
            _ => {}
        }
        // Chunks start at multiples of four.
        at = (at + 8 + size as usize).next_multiple_of(4);
    }
    json.map(|json| (json, binary)).ok_or("there is no JSON chunk")
}

/// The bytes without zeros at the end.
fn trim_zeros(bytes: &[u8]) -> &[u8] {
    let end = bytes.iter().rposition(|&byte| byte != 0).map_or(0, |last| last + 1);
    &bytes[..end]
}

/// The JSON, in the types of the format, and a warning if something is missing from it.
///
/// Those types refuse some things that the format allows, and some that no picture depends on. The JSON then gets a
/// second try, with numbers such as `1.0` as integers, which they are in this format, with scenes without `nodes` as
/// scenes without nodes, and without animation channels that have no target node, as the format asks for. A third try
/// leaves all animations out.
fn parse(json: &[u8]) -> Result<(Root, Option<String>), gltf_json::Error> {
    gltf_json::deserialize::from_slice(json).map(|root| (root, None)).or_else(|error| {
        let mut value: Value = gltf_json::deserialize::from_slice(json)?;
        whole_numbers(&mut value);
        add_missing_nodes(&mut value);
        let ignored = remove_channels_without_node(&mut value);
        let warning =
            (ignored > 0).then(|| format!("{ignored} animation channels without a target node are ignored"));
        gltf_json::deserialize::from_value(value.clone()).map(|root| (root, warning)).or_else(|_| {
            if let Some(root) = value.as_object_mut() {
                root.remove("animations");
            }
            let warning = Some("the animations are left out: they cannot be read".into());
            gltf_json::deserialize::from_value(value).map(|root| (root, warning)).map_err(|_| error)
        })
    })
}

/// The elements of a list, by its key.
fn elements<'a>(value: &'a mut Value, key: &str) -> impl Iterator<Item = &'a mut Value> {
    value.get_mut(key).and_then(Value::as_array_mut).into_iter().flatten()
}

/// Gives scenes without `nodes` an empty list.
fn add_missing_nodes(root: &mut Value) {
    for scene in elements(root, "scenes").filter_map(Value::as_object_mut) {
        scene.entry("nodes").or_insert_with(|| Value::Array(vec![]));
    }
}

/// Removes animation channels that have no target node, and returns how many.
fn remove_channels_without_node(root: &mut Value) -> usize {
    let mut removed = 0;
    for animation in elements(root, "animations") {
        if let Some(channels) = animation.get_mut("channels").and_then(Value::as_array_mut) {
            let before = channels.len();
            channels
                .retain(|channel| channel.get("target").is_none_or(|target| target.get("node").is_some()));
            removed += before - channels.len();
        }
    }
    removed
}

/// Turns numbers without a fraction into integers.
fn whole_numbers(value: &mut Value) {
    match value {
        Value::Number(number) => {
            let whole = number.as_f64().filter(|x| number.is_f64() && x.fract() == 0.0);
            if let Some(whole) = whole.filter(|x| (0.0..=u32::MAX.into()).contains(x)) {
                *value = Value::from(whole as u64);
            }
        }
        Value::Array(array) => array.iter_mut().for_each(whole_numbers),
        Value::Object(object) => object.values_mut().for_each(whole_numbers),
        _ => {}
    }
}

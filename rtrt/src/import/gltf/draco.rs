//! KHR_draco_mesh_compression: primitives with fewer bytes.

use super::accessor::{Column, one};
use super::buffer::Buffers;
use super::extensions::DRACO;
use crate::import::ImportError;
use draco_core::{DecodeLimits, DecoderBuffer, Mesh as Decoded, MeshDecoder};
use gltf_json::accessor::{Accessor, Type};
use gltf_json::mesh::{Primitive, Semantic};
use gltf_json::validation::Checked;
use gltf_json::{Index, Root, Value};
use std::collections::HashMap;
use std::path::Path;

/// The limits of one primitive. Damaged bytes may ask for anything; equal vertices take no bytes, so the length of the
/// bytes is no limit.
const FACES: u64 = 1 << 26;
const BYTES: u64 = 2 << 30;

/// A decoded primitive.
pub(super) struct Draco {
    /// The corners of its triangles.
    pub indices: Vec<u32>,
    /// The numbers of each attribute as `f32`, with its column but for the bytes.
    attributes: HashMap<Semantic, (Vec<u8>, usize, usize)>,
}

impl Draco {
    /// The content of the extension; none if the primitive is not compressed.
    pub fn new(
        path: &Path,
        root: &Root,
        buffers: &Buffers<'_>,
        primitive: &Primitive,
    ) -> Result<Option<Self>, ImportError> {
        let Some(extension) = primitive.extensions.as_ref().and_then(|e| e.others.get(DRACO)) else {
            return Ok(None);
        };
        let invalid =
            |why: &str| ImportError::Invalid { path: path.to_owned(), why: format!("{DRACO}: {why}") };
        let view = extension.get("bufferView").and_then(Value::as_u64);
        let view =
            view.and_then(|view| u32::try_from(view).ok()).ok_or_else(|| invalid("it has no buffer view"))?;
        let (bytes, _) = buffers.view(root, Index::new(view))?;
        let limits = DecodeLimits::default().with_max_faces(FACES).with_max_decoded_bytes(BYTES);
        let mut mesh = Decoded::new();
        let decoded =
            MeshDecoder::new().decode(&mut DecoderBuffer::new(bytes).with_limits(limits), &mut mesh);
        decoded.map_err(|error| invalid(&error.to_string().replace('\n', " ")))?;

        let ids = extension.get("attributes").and_then(Value::as_object);
        let ids = ids.ok_or_else(|| invalid("it has no attributes"))?;
        let mut attributes = HashMap::new();
        for (semantic, &index) in &primitive.attributes {
            let Checked::Valid(semantic) = semantic else { continue };
            let Some(id) = ids.get(&semantic.to_string()) else { continue };
            let id = id.as_u64().and_then(|id| u32::try_from(id).ok());
            let attribute = id.and_then(|id| mesh.attribute_by_unique_id(id));
            let attribute =
                attribute.ok_or_else(|| invalid(&format!("{} is not in it", semantic.to_string())))?;
            let (width, scale) =
                shape(root, index).ok_or_else(|| invalid("an accessor has an unknown type"))?;
            let numbers = attribute.read_f32s(mesh.num_points(), width);
            let bytes = numbers.iter().flat_map(|number| (number / scale).to_le_bytes());
            attributes.insert(semantic.clone(), (bytes.collect(), width, mesh.num_points()));
        }
        let indices = mesh.faces().as_flattened().iter().map(|point| point.0).collect();
        Ok(Some(Self { indices, attributes }))
    }

    /// The column of an attribute; none if it is not compressed.
    ///
    /// # Errors
    /// It has another type than these.
    pub fn column(&self, semantic: &Semantic, types: &[Type]) -> Option<Result<Column<'_>, String>> {
        let (bytes, width, count) = self.attributes.get(semantic)?;
        let fits = types.iter().any(|kind| kind.multiplicity() == *width);
        let wrong = || format!("{DRACO}: {} has {width} components", semantic.to_string());
        Some(if fits { Ok(Column::of_floats(bytes, *width, *count)) } else { Err(wrong()) })
    }
}

/// How many numbers an element of an accessor has, and the number that stands for 1.
fn shape(root: &Root, index: Index<Accessor>) -> Option<(usize, f32)> {
    let accessor = root.get(index)?;
    let (Checked::Valid(component), Checked::Valid(kind)) = (accessor.component_type, accessor.type_) else {
        return None;
    };
    let scale = if accessor.normalized { one(component.0) as f32 } else { 1.0 };
    Some((kind.multiplicity(), scale))
}

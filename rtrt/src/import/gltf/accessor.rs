//! Accessors: typed columns of numbers in a buffer.

use super::buffer::Buffers;
use crate::import::ImportError;
use gltf_json::accessor::{Accessor, ComponentType, Type};
use gltf_json::validation::Checked;
use gltf_json::{Index, Root, buffer};
use std::collections::HashMap;
use std::path::Path;

/// The limit of elements of an accessor without bytes, which are 0 but for the sparse ones. Without it
/// a few bytes of JSON could ask for any amount of memory.
const ZEROS: u64 = 1 << 20;

/// The elements of an accessor. All lie within their buffer.
pub(super) struct Column<'a> {
    /// The bytes from the first element on; none if all elements are 0.
    bytes: Option<&'a [u8]>,
    stride: usize,
    /// The number of elements.
    pub count: usize,
    component: ComponentType,
    /// The numbers of an element.
    pub width: usize,
    normalized: bool,
    /// The replaced elements, by index.
    sparse: HashMap<usize, &'a [u8]>,
}

impl<'a> Column<'a> {
    /// The accessor `index`. Any other type than these is an error.
    pub fn new(
        path: &Path,
        root: &Root,
        buffers: &'a Buffers<'_>,
        index: Index<Accessor>,
        types: &[Type],
    ) -> Result<Self, ImportError> {
        let number = index.value();
        let invalid = |why: &str| ImportError::Invalid {
            path: path.to_owned(),
            why: format!("accessor {number} {why}"),
        };
        let accessor = root.get(index).ok_or_else(|| invalid("is not there"))?;
        let (Checked::Valid(component), Checked::Valid(kind)) = (accessor.component_type, accessor.type_)
        else {
            return Err(invalid("has an unknown type"));
        };
        if !types.contains(&kind) {
            return Err(invalid(&format!("has the type {kind:?}, which its use does not allow")));
        }
        let (component, width) = (component.0, kind.multiplicity());
        let size = component.size() * width;
        let count = accessor.count.0;

        let range = |view: Index<buffer::View>, offset: u64, count: u64, size: usize| {
            let (bytes, stride) = buffers.view(root, view)?;
            let stride = stride.filter(|&stride| stride != 0).unwrap_or(size);
            let end = count.checked_sub(1).map_or(Some(0), |last| {
                last.checked_mul(stride as u64)?.checked_add(size as u64)?.checked_add(offset)
            });
            match end {
                Some(end) if end <= bytes.len() as u64 => {
                    Ok((bytes.get(offset as usize..).unwrap_or(&[]), stride))
                }
                _ => Err(invalid("is not within its buffer view")),
            }
        };
        let (bytes, stride) = match accessor.buffer_view {
            Some(view) => {
                let (bytes, stride) = range(view, accessor.byte_offset.unwrap_or_default().0, count, size)?;
                (Some(bytes), stride)
            }
            None if count > ZEROS => return Err(invalid("has no bytes for its elements")),
            None => (None, size),
        };

        let mut replaced = HashMap::new();
        if let Some(sparse) = &accessor.sparse {
            let indices = &sparse.indices;
            let Checked::Valid(index_type) = indices.component_type else {
                return Err(invalid("has sparse indices of an unknown type"));
            };
            if sparse.count.0 > count {
                return Err(invalid("has more sparse elements than elements"));
            }
            let index_size = index_type.0.size();
            let (at, index_stride) =
                range(indices.buffer_view, indices.byte_offset.0, sparse.count.0, index_size)?;
            let (values, value_stride) =
                range(sparse.values.buffer_view, sparse.values.byte_offset.0, sparse.count.0, size)?;
            for i in 0..sparse.count.0 as usize {
                let index = number_at(&at[i * index_stride..], index_type.0) as usize;
                if index as u64 >= count {
                    return Err(invalid("has a sparse index that is too large"));
                }
                replaced.insert(index, &values[i * value_stride..]);
            }
        }
        let count = count as usize;
        Ok(Self { bytes, stride, count, component, width, normalized: accessor.normalized, sparse: replaced })
    }

    /// The column of `count` elements of `width` numbers, given as `f32`.
    pub fn of_floats(bytes: &'a [u8], width: usize, count: usize) -> Self {
        let (stride, component) = (4 * width, ComponentType::F32);
        Self {
            bytes: Some(bytes),
            stride,
            count,
            component,
            width,
            normalized: false,
            sparse: HashMap::new(),
        }
    }

    /// The bytes from element `i` on; none if the element is 0.
    fn element(&self, i: usize) -> Option<&[u8]> {
        match self.sparse.get(&i) {
            Some(bytes) => Some(bytes),
            None => self.bytes.map(|bytes| &bytes[i * self.stride..]),
        }
    }

    /// Element `i`, below `count`, filled up with zeros. Normalized numbers are 0 ..= 1, or −1 ..= 1.
    pub fn at(&self, i: usize) -> [f32; 4] {
        let Some(bytes) = self.element(i) else { return [0.0; 4] };
        let size = self.component.size();
        core::array::from_fn(|k| if k < self.width { self.number(&bytes[k * size..]) } else { 0.0 })
    }

    /// All numbers of element `i`, below `count`.
    pub fn all(&self, i: usize) -> Vec<f32> {
        let (size, bytes) = (self.component.size(), self.element(i));
        (0..self.width).map(|k| bytes.map_or(0.0, |bytes| self.number(&bytes[k * size..]))).collect()
    }

    fn number(&self, bytes: &[u8]) -> f32 {
        let number = number_at(bytes, self.component);
        let scale = if self.normalized { one(self.component) } else { 1.0 };
        if scale == 1.0 { number as f32 } else { (number / scale).max(-1.0) as f32 }
    }

    /// Element `i`, below `count`, as an index.
    pub fn index(&self, i: usize) -> u32 {
        self.element(i).map_or(0, |bytes| number_at(bytes, self.component) as u32)
    }

    /// Whether the type is one that indices may have.
    pub fn is_index(&self) -> bool {
        matches!(self.component, ComponentType::U8 | ComponentType::U16 | ComponentType::U32)
    }
}

/// The normalized number that stands for 1.
pub(super) fn one(component: ComponentType) -> f64 {
    match component {
        ComponentType::I8 => 127.0,
        ComponentType::U8 => 255.0,
        ComponentType::I16 => 32767.0,
        ComponentType::U16 => 65535.0,
        ComponentType::U32 | ComponentType::F32 => 1.0,
    }
}

/// The number at the start of the bytes.
fn number_at(bytes: &[u8], component: ComponentType) -> f64 {
    let two = || [bytes[0], bytes[1]];
    let four = || [bytes[0], bytes[1], bytes[2], bytes[3]];
    match component {
        ComponentType::I8 => f64::from(bytes[0] as i8),
        ComponentType::U8 => f64::from(bytes[0]),
        ComponentType::I16 => f64::from(i16::from_le_bytes(two())),
        ComponentType::U16 => f64::from(u16::from_le_bytes(two())),
        ComponentType::U32 => f64::from(u32::from_le_bytes(four())),
        ComponentType::F32 => f64::from(f32::from_le_bytes(four())),
    }
}

//! EXT_meshopt_compression and KHR_meshopt_compression: buffer views with smaller bytes.
//!
//! Written from the specifications, whose appendices A (bitstream) and B (filters) are complete. KHR adds version 1 of
//! attributes and the filter of colors. Memory grows with what is decoded, not with what a file claims, except for
//! elements without differences, which take next to no bytes.

use gltf_json::Value;
use std::borrow::Cow;

/// A compressed buffer view, as the JSON has it.
pub(super) struct Compressed {
    pub buffer: u64,
    pub offset: u64,
    pub length: u64,
    stride: usize,
    count: usize,
    mode: Mode,
    filter: Filter,
}

#[derive(Clone, Copy, PartialEq)]
enum Mode {
    Attributes,
    Triangles,
    Indices,
}

#[derive(Clone, Copy, PartialEq)]
enum Filter {
    None,
    Octahedral,
    Quaternion,
    Exponential,
    Color,
}

/// What is said of bytes that end too early.
const CUT: &str = "its bytes end too early";

impl Compressed {
    /// The content of the extension.
    ///
    /// # Errors
    /// A value is missing, or breaks a rule of the specification.
    pub fn new(extension: &Value) -> Result<Self, Cow<'static, str>> {
        let number = |key: &'static str| {
            let number = extension.get(key).and_then(Value::as_u64);
            number.ok_or_else(|| format!("it has no {key}"))
        };
        let mode = match extension.get("mode").and_then(Value::as_str) {
            Some("ATTRIBUTES") => Mode::Attributes,
            Some("TRIANGLES") => Mode::Triangles,
            Some("INDICES") => Mode::Indices,
            _ => return Err("it has an unknown mode".into()),
        };
        let filter = match extension.get("filter").map(|filter| filter.as_str().unwrap_or_default()) {
            None | Some("NONE") => Filter::None,
            Some("OCTAHEDRAL") => Filter::Octahedral,
            Some("QUATERNION") => Filter::Quaternion,
            Some("EXPONENTIAL") => Filter::Exponential,
            Some("COLOR") => Filter::Color,
            Some(_) => return Err("it has an unknown filter".into()),
        };
        let (stride, count) = (number("byteStride")?, number("count")?);
        let fits = match (mode, filter) {
            (Mode::Attributes, Filter::None | Filter::Exponential) => {
                (4..=256).contains(&stride) && stride.is_multiple_of(4)
            }
            (Mode::Attributes, Filter::Octahedral | Filter::Color) => stride == 4 || stride == 8,
            (Mode::Attributes, Filter::Quaternion) => stride == 8,
            (Mode::Triangles, Filter::None) => (stride == 2 || stride == 4) && count.is_multiple_of(3),
            (Mode::Indices, Filter::None) => stride == 2 || stride == 4,
            _ => false,
        };
        let size = count.checked_mul(stride).and_then(|size| usize::try_from(size).ok());
        if !fits || size.is_none() {
            return Err(format!("its mode and filter allow no {count} elements of {stride} bytes").into());
        }
        Ok(Self {
            buffer: number("buffer")?,
            offset: extension.get("byteOffset").and_then(Value::as_u64).unwrap_or(0),
            length: number("byteLength")?,
            stride: stride as usize,
            count: count as usize,
            mode,
            filter,
        })
    }

    /// The length of the decoded bytes.
    pub fn size(&self) -> usize {
        self.count * self.stride
    }

    /// The decoded bytes.
    ///
    /// # Errors
    /// The bytes break a rule of the specification.
    pub fn decode(&self, bytes: &[u8]) -> Result<Vec<u8>, &'static str> {
        let mut decoded = match self.mode {
            Mode::Attributes => attributes(bytes, self.count, self.stride)?,
            Mode::Triangles => written(&triangles(bytes, self.count)?, self.stride),
            Mode::Indices => written(&indices(bytes, self.count)?, self.stride),
        };
        match self.filter {
            Filter::None => {}
            Filter::Octahedral if self.stride == 4 => {
                for element in decoded.as_chunks_mut::<4>().0 {
                    let [x, y, one, rest] = element.map(|byte| f32::from(byte as i8));
                    let [x, y, z] = octahedral(x, y, one).map(|c| libm::roundf(c * 127.0) as i8 as u8);
                    *element = [x, y, z, rest as i8 as u8];
                }
            }
            Filter::Octahedral => {
                for element in decoded.as_chunks_mut::<8>().0 {
                    let [x, y, one, rest] = four(element);
                    let normal = octahedral(x.into(), y.into(), one.into());
                    let [x, y, z] = normal.map(|c| libm::roundf(c * 32767.0) as i16);
                    *element = bytes_of([x, y, z, rest]);
                }
            }
            Filter::Quaternion => {
                for element in decoded.as_chunks_mut::<8>().0 {
                    *element = bytes_of(quaternion(four(element)));
                }
            }
            Filter::Color if self.stride == 4 => {
                for element in decoded.as_chunks_mut::<4>().0 {
                    let [y, co, cg, alpha] = *element;
                    let [co, cg] = [co, cg].map(|c| i32::from(c as i8));
                    *element = color(y.into(), co, cg, alpha.into(), 255.0).map(|c| c as u8);
                }
            }
            Filter::Color => {
                for element in decoded.as_chunks_mut::<8>().0 {
                    let [y, co, cg, alpha] = four(element);
                    let [y, alpha] = [y, alpha].map(|c| i32::from(c as u16));
                    let rgba = color(y, co.into(), cg.into(), alpha, 65535.0);
                    *element = bytes_of(rgba.map(|c| c as u16 as i16));
                }
            }
            Filter::Exponential => {
                for element in decoded.as_chunks_mut::<4>().0 {
                    *element = exponential(i32::from_le_bytes(*element)).to_le_bytes();
                }
            }
        }
        Ok(decoded)
    }
}

/// Mode 0: elements of `stride` bytes, as differences to the element before.
fn attributes(bytes: &[u8], count: usize, stride: usize) -> Result<Vec<u8>, &'static str> {
    let (header, body) = bytes.split_first().ok_or(CUT)?;
    let (channels, least) = match header {
        0xa0 => (0, 32),
        0xa1 => (stride / 4, 24),
        _ => return Err("its bytes are no attributes of version 0 or 1"),
    };
    let tail = body.len().checked_sub((stride + channels).max(least)).ok_or(CUT)?;
    let (mut data, tail) = body.split_at(tail);
    let (last, channels) = tail[tail.len() - stride - channels..].split_at(stride);
    let mut last = last.to_vec();
    let longest = ((8192 / stride) & !15).min(256);
    let mut decoded = Vec::new();
    let mut differences = vec![[0; 256]; stride];
    let mut first = 0;
    while first < count {
        let elements = (count - first).min(longest);
        let controls = data.split_off(..channels.len()).ok_or(CUT)?;
        for (byte, column) in differences.iter_mut().enumerate() {
            let control = controls.get(byte / 4).map(|control| control >> (2 * (byte % 4)) & 3);
            read_column(control, &mut column[..elements], &mut data)?;
        }
        decoded.reserve(elements * stride);
        for element in 0..elements {
            let parts = last.as_chunks_mut::<4>().0.iter_mut().zip(differences.as_chunks::<4>().0);
            for (channel, (last, columns)) in parts.enumerate() {
                let difference = columns.each_ref().map(|column| column[element]);
                *last = next(channels.get(channel).copied().unwrap_or(0), *last, difference)?;
                decoded.extend(*last);
            }
        }
        first += elements;
    }
    if data.is_empty() { Ok(decoded) } else { Err("its bytes go on after the last element") }
}

/// Reads the differences of one byte of all elements of a block, and `data` behind them. Version 0 has no control.
fn read_column(control: Option<u8>, column: &mut [u8], data: &mut &[u8]) -> Result<(), &'static str> {
    let bits = match control {
        None => [0, 2, 4, 8],
        Some(0) => [0, 1, 2, 4],
        Some(1) => [1, 2, 4, 8],
        Some(2) => {
            column.fill(0);
            return Ok(());
        }
        Some(_) => {
            column.copy_from_slice(data.split_off(..column.len()).ok_or(CUT)?);
            return Ok(());
        }
    };
    let headers = data.split_off(..column.len().div_ceil(16).div_ceil(4)).ok_or(CUT)?;
    for (group, column) in column.chunks_mut(16).enumerate() {
        let kind = headers[group / 4] >> (2 * (group % 4)) & 3;
        let differences = deltas(bits[usize::from(kind)], data)?;
        column.copy_from_slice(&differences[..column.len()]);
    }
    Ok(())
}

/// The 16 differences of a group, of so many bits each, and `data` behind them. One with all bits set is a byte of its
/// own.
fn deltas(bits: usize, data: &mut &[u8]) -> Result<[u8; 16], &'static str> {
    if bits == 0 {
        return Ok([0; 16]);
    }
    if bits == 8 {
        return Ok(*data.split_off(..16).and_then(|bytes| bytes.first_chunk()).ok_or(CUT)?);
    }
    let packed = data.split_off(..2 * bits).ok_or(CUT)?;
    let mut deltas = [0; 16];
    for (place, delta) in deltas.iter_mut().enumerate() {
        let at = place * bits;
        // Single bits begin at the lowest one of a byte, others at the highest.
        let shift = if bits == 1 { at % 8 } else { 8 - bits - at % 8 };
        let sentinel = (1 << bits) - 1;
        *delta = packed[at / 8] >> shift & sentinel;
        if *delta == sentinel {
            *delta = *data.split_off_first().ok_or(CUT)?;
        }
    }
    Ok(deltas)
}

/// Four bytes of an element from those of the element before, by the mode of their channel.
fn next(channel: u8, last: [u8; 4], difference: [u8; 4]) -> Result<[u8; 4], &'static str> {
    let two = |bytes: [u8; 4], at: usize| u16::from_le_bytes([bytes[at], bytes[at + 1]]);
    match channel {
        0 => Ok([0, 1, 2, 3].map(|i| {
            let delta = difference[i];
            last[i].wrapping_add(delta >> 1 ^ (delta & 1).wrapping_neg())
        })),
        1 => {
            let [low, high] = [0, 2].map(|at| {
                let delta = two(difference, at);
                two(last, at).wrapping_add(delta >> 1 ^ (delta & 1).wrapping_neg()).to_le_bytes()
            });
            Ok([low[0], low[1], high[0], high[1]])
        }
        _ if channel & 15 == 2 => {
            let delta = u32::from_le_bytes(difference).rotate_right(u32::from(channel >> 4));
            Ok((u32::from_le_bytes(last) ^ delta).to_le_bytes())
        }
        _ => Err("a channel of it has an unknown mode"),
    }
}

/// The last 16 things of a kind.
struct Recent<T> {
    ring: [T; 16],
    next: usize,
}

impl<T: Copy + Default> Recent<T> {
    fn new() -> Self {
        Self { ring: [T::default(); 16], next: 0 }
    }
    fn push(&mut self, value: T) {
        self.ring[self.next] = value;
        self.next = (self.next + 1) % 16;
    }
    /// The value that was pushed before `age` others; `age` ≤ 15.
    fn get(&self, age: usize) -> T {
        self.ring[(self.next + 15 - age) % 16]
    }
}

/// Mode 1: the corners of triangles.
fn triangles(bytes: &[u8], count: usize) -> Result<Vec<u32>, &'static str> {
    let body = bytes.strip_prefix(&[0xe1]).ok_or("its bytes are no triangles of version 1")?;
    let (codes, body) = body.split_at_checked(count / 3).ok_or(CUT)?;
    let (mut data, table) = body.split_at(body.len().checked_sub(16).ok_or(CUT)?);
    let mut edges: Recent<[u32; 2]> = Recent::new();
    let mut vertices: Recent<u32> = Recent::new();
    let (mut next, mut last) = (0_u32, 0_u32);
    let mut corners = Vec::with_capacity(count);
    let fresh = |next: &mut u32| {
        let index = *next;
        *next = next.wrapping_add(1);
        index
    };
    for &code in codes {
        let (high, low) = (usize::from(code >> 4), usize::from(code & 15));
        if high < 15 {
            let [a, b] = edges.get(high);
            let c = match low {
                0 => fresh(&mut next),
                13 => last.wrapping_sub(1),
                14 => last.wrapping_add(1),
                15 => moved(last, number(&mut data)?),
                _ => vertices.get(low),
            };
            if low >= 13 {
                last = c;
            }
            if low == 0 || low >= 13 {
                vertices.push(c);
            }
            edges.push([c, b]);
            edges.push([a, c]);
            corners.extend([a, b, c]);
            continue;
        }
        let pair = match low {
            14 | 15 => *data.split_off_first().ok_or(CUT)?,
            _ => table[low],
        };
        if low >= 14 && pair == 0 {
            next = 0;
        }
        let a = if low == 15 {
            last = moved(last, number(&mut data)?);
            last
        } else {
            fresh(&mut next)
        };
        let mut other = |nibble: u8| match nibble {
            0 => Ok(fresh(&mut next)),
            15 if low >= 14 => {
                last = moved(last, number(&mut data)?);
                Ok(last)
            }
            age => Ok(vertices.get(usize::from(age) - 1)),
        };
        let [high, low] = [pair >> 4, pair & 15];
        let (b, c) = (other(high)?, other(low)?);
        vertices.push(a);
        for (vertex, nibble) in [(b, high), (c, low)] {
            if nibble == 0 || nibble == 15 {
                vertices.push(vertex);
            }
        }
        edges.push([b, a]);
        edges.push([c, b]);
        edges.push([a, c]);
        corners.extend([a, b, c]);
    }
    if data.is_empty() { Ok(corners) } else { Err("its bytes go on after the last triangle") }
}

/// Mode 2: indices, as differences to one of two others.
fn indices(bytes: &[u8], count: usize) -> Result<Vec<u32>, &'static str> {
    let body = bytes.strip_prefix(&[0xd1]).ok_or("its bytes are no indices of version 1")?;
    let mut data = &body[..body.len().checked_sub(4).ok_or(CUT)?];
    if data.len() < count {
        return Err(CUT);
    }
    let mut last = [0; 2];
    let mut indices = Vec::with_capacity(count);
    for _ in 0..count {
        let number = number(&mut data)?;
        let last = &mut last[number as usize & 1];
        *last = moved(*last, number >> 1);
        indices.push(*last);
    }
    if data.is_empty() { Ok(indices) } else { Err("its bytes go on after the last index") }
}

/// A number of one to five bytes with seven bits each, the lowest first (LEB128), and `data` behind it.
fn number(data: &mut &[u8]) -> Result<u32, &'static str> {
    let mut number = 0;
    for shift in [0, 7, 14, 21, 28] {
        let byte = *data.split_off_first().ok_or(CUT)?;
        number |= u32::from(byte & 0x7f) << shift;
        if byte < 0x80 {
            return Ok(number);
        }
    }
    Err("it has a number of more than 32 bits")
}

/// `from`, moved by a zigzag-encoded difference.
fn moved(from: u32, zigzag: u32) -> u32 {
    from.wrapping_add(zigzag >> 1 ^ (zigzag & 1).wrapping_neg())
}

/// Indices as numbers of two or four bytes.
fn written(indices: &[u32], stride: usize) -> Vec<u8> {
    indices.iter().flat_map(|index| index.to_le_bytes().into_iter().take(stride)).collect()
}

fn four(bytes: &[u8; 8]) -> [i16; 4] {
    [0, 1, 2, 3].map(|i| i16::from_le_bytes([bytes[2 * i], bytes[2 * i + 1]]))
}

fn bytes_of(numbers: [i16; 4]) -> [u8; 8] {
    let [a, b, c, d] = numbers.map(i16::to_le_bytes);
    [a[0], a[1], b[0], b[1], c[0], c[1], d[0], d[1]]
}

/// Filter 1: the unit vector at a place of an octahedron. A broken `one` gives what a cast makes of NaN.
fn octahedral(x: f32, y: f32, one: f32) -> [f32; 3] {
    let (x, y) = (x / one, y / one);
    let z = 1.0 - x.abs() - y.abs();
    let fold = z.min(0.0);
    let (x, y) = (x - fold.copysign(x), y - fold.copysign(y));
    let length = libm::sqrtf(x * x + y * y + z * z);
    [x / length, y / length, z / length]
}

/// Filter 2: a unit quaternion from the three components that are not the largest.
fn quaternion(packed: [i16; 4]) -> [i16; 4] {
    let scale = core::f32::consts::FRAC_1_SQRT_2 / f32::from(packed[3] | 3);
    let [x, y, z] = [0, 1, 2].map(|i| f32::from(packed[i]) * scale);
    let w = libm::sqrtf((1.0 - x * x - y * y - z * z).max(0.0));
    let largest = packed[3] as usize & 3;
    let mut out = [0; 4];
    for (place, value) in [w, x, y, z].into_iter().enumerate() {
        out[(largest + place) % 4] = libm::roundf(value * 32767.0) as i16;
    }
    out
}

/// Filter 4: red, green, blue and alpha from luma and chroma of up to 16 bits. The highest bit of alpha says how many.
fn color(y: i32, co: i32, cg: i32, alpha: i32, one: f32) -> [f32; 4] {
    // Of `alpha` = 1, nothing but the highest bit is there.
    let full = (2 << alpha.max(1).ilog2()) - 1;
    let alpha = alpha & full >> 1;
    let scale = one / full as f32;
    [y + co - cg, y + cg, y - co - cg, alpha << 1 | alpha & 1].map(|c| libm::roundf(c as f32 * scale))
}

/// Filter 3: 2 to the power of the upper 8 bits, times the lower 24.
fn exponential(packed: i32) -> f32 {
    let (exponent, mantissa) = (packed >> 24, packed << 8 >> 8);
    // A power of two that f64 holds.
    let power = f64::from_bits(((1023 + i64::from(exponent)) as u64) << 52);
    (f64::from(mantissa) * power) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_are_those_of_the_specification() {
        let mut data = &[0x17, 0x5f, 0xf0, 0xbc, 0x77, 0xa9, 0x21, 0x00, 0x34, 0xb5, 9][..];
        let found =
            deltas(4, &mut data).unwrap().map(|delta| (delta >> 1 ^ (delta & 1).wrapping_neg()) as i8);
        assert_eq!(found, [-1, -4, -3, 26, -91, 0, -6, 6, -4, -4, 5, -5, 1, -1, 0, 0]);
        assert_eq!(data, [9]);
        // Two bits: 0, 1, 2 and a sentinel, four times.
        let mut data = &[0b00_01_10_11, 0, 0, 0b11_00_00_00, 200, 100][..];
        assert_eq!(deltas(2, &mut data).unwrap()[..4], [0, 1, 2, 200]);
        // One bit: 0, 1, which is the sentinel, 0 …
        let mut data = &[0b10, 0, 50][..];
        assert_eq!(deltas(1, &mut data).unwrap()[..3], [0, 50, 0]);
        assert_eq!((deltas(0, &mut data), data.len()), (Ok([0; 16]), 0));
        assert_eq!(deltas(8, &mut &[0; 15][..]), Err(CUT));
    }

    #[test]
    fn elements_follow_from_the_last_one_of_the_block_before() {
        // 300 elements of four bytes: a block of 256 and one of 44. The first byte grows by 1 (2 in zigzag) in 2-bit
        // groups; the others stay as they are in the tail.
        let mut bytes = vec![0xa0];
        for groups in [16, 3] {
            bytes.extend(vec![0b01_01_01_01; groups / 4]);
            bytes.extend(vec![0b01_01_01; usize::from(groups % 4 != 0)]);
            bytes.extend(vec![0b10_10_10_10; 4 * groups]);
            bytes.extend(vec![0; 3 * groups.div_ceil(4)]);
        }
        bytes.extend([0; 28]);
        bytes.extend([255, 7, 8, 9]);
        let decoded = attributes(&bytes, 300, 4).unwrap();
        let expected: Vec<u8> = (0..300).flat_map(|i| [i as u8, 7, 8, 9]).collect();
        assert_eq!(decoded, expected);
        for length in 0..bytes.len() {
            assert!(attributes(&bytes[..length], 300, 4).is_err());
        }
        assert!(attributes(&bytes, 299, 4).is_ok() && attributes(&bytes, 400, 4) == Err(CUT));
        assert!(attributes(&bytes, 200, 4).is_err());
        // A block of two elements, and a byte too many before the tail.
        let long = [&[0xa0, 0, 0, 0, 0, 9][..], &[5; 32]].concat();
        assert_eq!(attributes(&long, 2, 4), Err("its bytes go on after the last element"));
        assert_eq!(attributes(&[&long[..5], &[5; 32]].concat(), 2, 4), Ok(vec![5; 8]));
    }

    #[test]
    fn version_1_has_controls_and_channels() {
        let stream = |control: u8, data: &[u8], last: [u8; 4], channel: u8| {
            [&[0xa1, control], data, &[0; 19], &last, &[channel]].concat()
        };
        // Two elements; the differences are bytes as they are. 0x00ff grows by 1 (2 in zigzag), then shrinks; 0x0001 grows
        // by 0x8000.
        let literal = stream(0xff, &[2, 1, 0, 0, 0xff, 0, 0xff, 0], [0xff, 0, 1, 0], 1);
        assert_eq!(attributes(&literal, 2, 4).unwrap(), [0, 1, 1, 0x80, 0xff, 0, 1, 0x80]);
        // Exclusive or, with one bit turned back.
        let or = stream(0xff, &[1, 0, 0, 0, 0, 0, 0, 0], [0, 0, 0, 5], 0x12);
        assert_eq!(attributes(&or, 2, 4).unwrap(), [0, 0, 0, 0x85, 0, 0, 0, 0x85]);
        // The first byte has one bit a difference, the second is 0 throughout, the third has two bits, the fourth bytes.
        let mut data = vec![0b01, 0b10, 0, 9];
        data.extend([0b01, 0b10_00_00_00, 0, 0, 0]);
        data.extend([0b11, 4]);
        data.extend([0; 15]);
        let mixed = stream(0b01_01_10_00, &data, [1; 4], 0);
        assert_eq!(attributes(&mixed, 2, 4).unwrap(), [1, 1, 2, 3, 252, 1, 2, 3]);
        for length in 0..mixed.len() {
            assert!(attributes(&mixed[..length], 2, 4).is_err());
        }
        assert_eq!(
            attributes(&stream(0xaa, &[], [7; 4], 3), 2, 4),
            Err("a channel of it has an unknown mode")
        );
        // Nothing differs from the tail.
        assert_eq!(attributes(&stream(0xaa, &[], [7; 4], 0), 2, 4).unwrap(), [7; 8]);
    }

    #[test]
    fn colors_have_luma_and_chroma() {
        assert_eq!(color(255, 0, 0, 255, 255.0), [255.0; 4]);
        assert_eq!(color(64, 127, -64, 128, 255.0), [255.0, 0.0, 1.0, 0.0]);
        // Five bits of 16, half alpha: 8 of 15.
        assert_eq!(color(31, 0, 0, 0b1_0111, 65535.0), [65535.0, 65535.0, 65535.0, 31710.0]);
        color(0, 0, 0, 0, 255.0);
    }

    #[test]
    fn numbers_are_those_of_the_specification() {
        let read = |mut bytes: &[u8]| number(&mut bytes);
        assert_eq!([read(&[0x7f]), read(&[0x81, 0x04])], [Ok(0x7f), Ok(0x201)]);
        // Its third example, 0x1fd005, has the highest bits first, and contradicts the others and LEB128.
        assert_eq!([read(&[0xff, 0xa0, 0x05]), read(&[0x80])], [Ok(0x1_507f), Err(CUT)]);
        assert!(read(&[0xff; 6]).is_err());
        assert_eq!([moved(5, 0), moved(5, 1), moved(5, 2), moved(0, 1)], [5, 4, 6, u32::MAX]);
    }

    #[test]
    fn triangles_share_edges_and_vertices() {
        // f0 with the pair 00: three new vertices, 0 1 2; the edges are then 0 2, 2 1, 1 0. 00: edge 0 2 and the new
        // vertex 3. 31: edge 2 1, behind three others by then, and the last vertex but one, 2. fe with f0: a new one, one
        // by its difference to 0 (20 means +10), a new one. ff with 21: by its difference (3 means −2), and from the
        // last vertices.
        let codes = [0xf0, 0x00, 0x31, 0xfe, 0xff, 0x0d];
        let data = [0xf0, 20, 0x21, 3];
        let mut bytes = [&[0xe1][..], &codes, &data, &[0; 16]].concat();
        let corners = triangles(&bytes, 18).unwrap();
        assert_eq!(corners[..9], [0, 1, 2, 0, 2, 3, 2, 1, 2]);
        // The last vertices are then 5, 10, 4, 3: those of ages 1 and 0 are 10 and 5.
        assert_eq!(corners[9..15], [4, 10, 5, 8, 10, 5]);
        // The edge 8 5 and the vertex before 8.
        assert_eq!(corners[15..], [8, 5, 7]);
        for length in 0..bytes.len() {
            assert!(triangles(&bytes[..length], 18).is_err());
        }
        bytes.push(0);
        assert!(triangles(&bytes, 18).is_err());
    }

    #[test]
    fn indices_follow_two_others() {
        // +5 of the first, +100 of the second (two bytes), −1 of each.
        let bytes = [0xd1, 20, 0x91, 0x03, 2, 3, 0, 0, 0, 0];
        assert_eq!(indices(&bytes, 4).unwrap(), [5, 100, 4, 99]);
        assert_eq!(indices(&bytes, 5), Err(CUT));
        assert_eq!(indices(&bytes, 3), Err("its bytes go on after the last index"));
        assert_eq!(written(&[1, 0x1_0002], 2), [1, 0, 2, 0]);
    }

    #[test]
    fn filters_give_axes_and_powers() {
        let decode = |filter, stride, elements: &[u8]| {
            let count = elements.len() / stride;
            let compressed =
                Compressed { buffer: 0, offset: 0, length: 0, stride, count, mode: Mode::Attributes, filter };
            // Every delta is a byte; the first element follows from one of zeros.
            let mut bytes = vec![0xa0];
            for byte in 0..stride {
                let mut before = 0;
                bytes.push(3);
                bytes.extend((0..16).map(|i| {
                    let now = elements.get(i * stride + byte).copied().unwrap_or(before);
                    let delta = now.wrapping_sub(std::mem::replace(&mut before, now)) as i8;
                    (delta << 1 ^ delta >> 7) as u8
                }));
            }
            bytes.extend([0; 32]);
            compressed.decode(&bytes).unwrap()
        };
        // The middle is +z, the corners are −z, those between them are +x and −y; the fourth number stays.
        let octahedral = [[0, 0, 127, 5], [127, 127, 127, 6], [127, 0, 127, 7], [0, -127, 127, -8_i8]];
        let bytes: Vec<u8> = octahedral.as_flattened().iter().map(|&c| c as u8).collect();
        let expected = [[0, 0, 127, 5], [0, 0, -127, 6], [127, 0, 0, 7], [0, -127, 0, -8_i8]];
        let expected: Vec<u8> = expected.as_flattened().iter().map(|&c| c as u8).collect();
        assert_eq!(decode(Filter::Octahedral, 4, &bytes), expected);
        // With 10 bits of 16, halfway between +x and +y.
        let wide = decode(Filter::Octahedral, 8, &bytes_of([256, 255, 511, -3]));
        let [x, y, z, rest] = four(wide.as_chunks().0.first().unwrap());
        assert!((i32::from(x) - 23_170).abs() < 60 && (i32::from(y) - 23_170).abs() < 60, "{x} {y}");
        assert_eq!((z, rest), (0, -3));
        // The largest component is the second; the others are 0.
        let turn = decode(Filter::Quaternion, 8, &bytes_of([0, 0, 0, 0x7ffd]));
        assert_eq!(four(turn.as_chunks().0.first().unwrap()), [0, 32767, 0, 0]);
        let half = decode(Filter::Quaternion, 8, &bytes_of([32767, 0, 0, 0x7fff]));
        assert_eq!(four(half.as_chunks().0.first().unwrap()), [23170, 0, 0, 23170]);
        let powers = [3_i32, 5 << 24 | 1, (-2_i32) << 24 | 0x00ff_ffff];
        let powers: Vec<u8> = powers.iter().flat_map(|p| p.to_le_bytes()).collect();
        let expected: Vec<u8> = [3.0_f32, 32.0, -0.25].iter().flat_map(|p| p.to_le_bytes()).collect();
        assert_eq!(decode(Filter::Exponential, 4, &powers), expected);
        // What is not allowed gives some number.
        decode(Filter::Octahedral, 8, &[0; 8]);
        decode(Filter::Exponential, 4, &[255, 255, 255, 127, 1, 0, 0, 128]);
    }
}

//! The header of a PLY file: elements and their properties.

use std::path::Path;

use crate::error::{Error, Excerpt, Place, Result};

/// Longest header in bytes, most elements and most properties of one.
const MAX_HEADER: usize = 1 << 20;
const MAX_PARTS: usize = 1024;

/// How values are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// The type of a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn of(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    pub fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    fn is_integer(self) -> bool {
        !matches!(self, Self::F32 | Self::F64)
    }
}

/// A property: one value, or a count and as many values.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Property {
    pub name: String,
    pub count: Option<Scalar>,
    pub value: Scalar,
}

/// An element: so many records of the same properties.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Element {
    pub name: String,
    pub count: u64,
    pub properties: Vec<Property>,
}

/// What comes before the data.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Header {
    pub encoding: Encoding,
    pub elements: Vec<Element>,
    /// Where the data begins.
    pub end: usize,
}

impl Element {
    /// Bytes that a record has at least.
    pub fn least_bytes(&self, encoding: Encoding) -> u64 {
        let least = |p: &Property| match encoding {
            // A digit and a blank.
            Encoding::Ascii => 2,
            _ => p.count.unwrap_or(p.value).bytes() as u64,
        };
        self.properties.iter().map(least).sum::<u64>().max(1)
    }
}

impl Header {
    /// Reads the header of `bytes`.
    pub fn read(bytes: &[u8], path: &Path) -> Result<Self> {
        let head = &bytes[..bytes.len().min(MAX_HEADER)];
        let text = String::from_utf8_lossy(head);
        let mut header = Self { encoding: Encoding::Ascii, elements: Vec::new(), end: 0 };
        let (mut formatted, mut start) = (false, 0);
        loop {
            let Some(length) = head[start..].iter().position(|b| *b == b'\n' || *b == b'\r') else {
                let found = "the header has no end";
                return Err(Error::invalid(path, Place::Header, "header", found, "end_header"));
            };
            let line = String::from_utf8_lossy(&head[start..start + length]).into_owned();
            let place = start..start + length;
            let fault = |what: &str, found: &str, allowed: &str| {
                let excerpt = Excerpt::new(&text, place.clone());
                Error::invalid(path, Place::Text(excerpt), what, found, allowed)
            };
            let words: Vec<&str> = line.split_whitespace().collect();
            let first = start == 0;
            start += length + 1;
            // Lines may end in CR LF.
            if head[start - 1] == b'\r' && head.get(start) == Some(&b'\n') {
                start += 1;
            }
            match *words.as_slice() {
                ["ply"] if first => {}
                _ if first => return Err(fault("first line", &line, "ply")),
                ["format", name, _] => {
                    header.encoding = match name {
                        "ascii" => Encoding::Ascii,
                        "binary_little_endian" => Encoding::LittleEndian,
                        "binary_big_endian" => Encoding::BigEndian,
                        other => {
                            let allowed = "ascii, binary_little_endian, binary_big_endian";
                            return Err(fault("format", other, allowed));
                        }
                    };
                    formatted = true;
                }
                ["element", name, count] if header.elements.len() < MAX_PARTS => {
                    let allowed = "a count from 0 to 4294967295";
                    let number =
                        count.parse::<u32>().map_err(|_| fault("element", count, allowed))?;
                    let (name, count) = (name.to_owned(), u64::from(number));
                    header.elements.push(Element { name, count, properties: Vec::new() });
                }
                ["property", ref rest @ ..] => {
                    let Some(property) = property(rest) else {
                        let allowed = "property TYPE NAME, property list COUNT-TYPE TYPE NAME";
                        return Err(fault("property", &line, allowed));
                    };
                    match header.elements.last_mut() {
                        Some(element) if element.properties.len() < MAX_PARTS => {
                            element.properties.push(property);
                        }
                        _ => return Err(fault("property", &line, "properties after an element")),
                    }
                }
                ["comment" | "obj_info", ..] | [] => {}
                ["end_header"] if formatted => {
                    header.end = start;
                    return Ok(header);
                }
                _ => {
                    let allowed = "format, element, property, comment, obj_info, end_header";
                    return Err(fault("line of the header", &line, allowed));
                }
            }
        }
    }
}

fn property(words: &[&str]) -> Option<Property> {
    let (count, value, name) = match *words {
        ["list", count, value, name] => (Some(Scalar::of(count)?), Scalar::of(value)?, name),
        [value, name] => (None, Scalar::of(value)?, name),
        _ => return None,
    };
    let whole = count.is_none_or(Scalar::is_integer);
    whole.then(|| Property { name: name.to_owned(), count, value })
}

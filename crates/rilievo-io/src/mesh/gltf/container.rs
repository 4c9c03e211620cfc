//! The bytes of a glTF file: JSON text, or a GLB of JSON and binary chunks.

use std::path::Path;

use serde_json::Value;

use crate::error::{Error, Excerpt, Place, Result};
use crate::limits::Limits;

/// First bytes of a GLB.
pub const MAGIC: &[u8] = b"glTF";
const JSON_CHUNK: u32 = 0x4e4f_534a;
const BINARY_CHUNK: u32 = 0x004e_4942;
/// Bytes of memory that a byte of JSON may become.
const GROWTH: u64 = 32;

/// The parts of a file.
pub(super) struct Container<'a> {
    pub json: Value,
    /// Whether it is a GLB, and its binary chunk.
    pub glb: Option<Option<&'a [u8]>>,
}

impl<'a> Container<'a> {
    /// Parts the bytes of `path`.
    pub fn read(bytes: &'a [u8], path: &Path, limits: &Limits) -> Result<Self> {
        let (text, glb) = match bytes.starts_with(MAGIC) {
            true => {
                let (text, binary) = chunks(bytes, path)?;
                (text, Some(binary))
            }
            false => (bytes, None),
        };
        let size = [text.len() as u64, GROWTH];
        limits.check(path, Place::File, "reading JSON", &size)?;
        let json = serde_json::from_slice(text).map_err(|e| syntax_error(text, path, &e))?;
        Ok(Self { json, glb })
    }
}

/// The JSON chunk and, if there is one, the binary chunk.
fn chunks<'a>(bytes: &'a [u8], path: &Path) -> Result<(&'a [u8], Option<&'a [u8]>)> {
    let fault = |what: &str, found: String, allowed: &str| {
        Error::invalid(path, Place::Header, what, found, allowed)
    };
    let number = |at: usize| {
        let four = bytes.get(at..at + 4)?;
        Some(u32::from_le_bytes([four[0], four[1], four[2], four[3]]))
    };
    let (version, length) = (number(4).unwrap_or(0), number(8).unwrap_or(0));
    if version != 2 {
        return Err(fault("version of the GLB", version.to_string(), "2"));
    }
    if u64::from(length) != bytes.len() as u64 {
        let allowed = format!("{}, the size of the file", bytes.len());
        return Err(fault("length of the GLB", length.to_string(), &allowed));
    }
    let (mut at, mut json, mut binary) = (12, None, None);
    while at < bytes.len() {
        let header = (number(at), number(at + 4));
        let (Some(length), Some(kind)) = header else {
            return Err(fault("chunk", "cut short".to_owned(), "8 bytes of header"));
        };
        let content = bytes[at + 8..].get(..length as usize).ok_or_else(|| {
            fault("chunk", format!("{length} bytes"), "no more than the file holds")
        })?;
        at += 8 + content.len();
        match (kind, json, binary) {
            (JSON_CHUNK, None, None) => json = Some(content),
            (BINARY_CHUNK, Some(_), None) => binary = Some(content),
            (JSON_CHUNK | BINARY_CHUNK, ..) => {
                let allowed = "JSON first, then at most one binary chunk";
                return Err(fault("chunk", "a second one, or out of order".to_owned(), allowed));
            }
            // Unknown chunks are to be ignored.
            _ => {}
        }
    }
    match json {
        Some(json) => Ok((json, binary)),
        None => Err(fault("GLB", "no JSON chunk".to_owned(), "a JSON chunk, first")),
    }
}

fn syntax_error(text: &[u8], path: &Path, error: &serde_json::Error) -> Error {
    let text = String::from_utf8_lossy(text);
    let lines = text.split_inclusive('\n').take(error.line().saturating_sub(1));
    let start = lines.map(str::len).sum::<usize>() + error.column().saturating_sub(1);
    let message = error.to_string();
    let message = message.split(" at line").next().unwrap_or_default();
    let place = Place::Text(Excerpt::new(&text, start..start + 1));
    Error::invalid(path, place, "syntax", message, "JSON")
}

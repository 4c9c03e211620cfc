//! Buffers and views of them.

use std::borrow::Cow;

use super::json::Json;
use super::uri::{self, Target};
use crate::error::Result;
use crate::limits::Limits;
use crate::mesh::Beside;

/// Media types of data in the URI of a buffer.
const MEDIA: [&str; 2] = ["application/octet-stream", "application/gltf-buffer"];
/// `target` of vertex attributes and of indices.
const VERTICES: u64 = 34962;
const INDICES: u64 = 34963;

/// The bytes of a buffer, or just their number where there are none: such a buffer holds zeros.
pub(super) struct Buffer<'a> {
    length: u64,
    bytes: Option<Cow<'a, [u8]>>,
}

/// What a view is used for. A view has one use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Usage {
    Vertices,
    Indices,
    Other,
}

/// A part of a buffer.
pub(super) struct View {
    buffer: usize,
    pub offset: u64,
    pub length: u64,
    /// Bytes from one element to the next, if the file says.
    pub stride: Option<u64>,
    pub usage: Option<Usage>,
    /// Accessors of vertex attributes that lie in it, the first two.
    pub attributes: Vec<usize>,
}

/// All buffers and views of a document.
pub(super) struct Buffers<'a> {
    buffers: Vec<Buffer<'a>>,
    pub views: Vec<View>,
}

impl<'a> Buffers<'a> {
    /// Reads them. `glb` is the container's, `notes` takes what is left out.
    pub fn read(
        root: &Json<'_>,
        glb: Option<Option<&'a [u8]>>,
        (beside, limits): (Beside<'_>, &Limits),
        notes: &mut Vec<String>,
    ) -> Result<Self> {
        let mut buffers = Vec::new();
        for (k, json) in root.objects("buffers")?.iter().enumerate() {
            let length = json.require("byteLength")?.whole(1)?;
            let bytes = match (json.get("uri"), glb) {
                (Some(uri), _) => load(&uri, length, beside, limits)?,
                // Of a GLB the first buffer without URI is the binary chunk.
                (None, Some(Some(binary))) if k == 0 => Some(Cow::Borrowed(binary)),
                (None, Some(None)) if k == 0 => {
                    let allowed = "a binary chunk, or a URI";
                    return Err(json.fault("buffer", "no data in the GLB", allowed));
                }
                (None, _) => None,
            };
            let bytes = match bytes {
                Some(bytes) if (bytes.len() as u64) < length => {
                    let found = format!("{length}, but there are {} bytes", bytes.len());
                    return Err(json.fault("byteLength", found, "no more than there are"));
                }
                Some(bytes) => Some(bytes),
                None => {
                    notes.push(format!("{}: no data, read as zeros", json.pointer));
                    None
                }
            };
            buffers.push(Buffer { length, bytes });
        }
        let views = root.objects("bufferViews")?;
        let views = views.iter().map(|json| view(json, &buffers)).collect::<Result<_>>()?;
        Ok(Self { buffers, views })
    }

    /// The bytes of a view; none if its buffer holds zeros.
    pub fn bytes(&self, view: usize) -> Option<&[u8]> {
        let View { buffer, offset, length, .. } = self.views[view];
        let bytes = self.buffers[buffer].bytes.as_deref()?;
        // Views lie in their buffers, buffers have their bytes.
        bytes.get(offset as usize..(offset + length) as usize)
    }

    /// Notes what a view is used for; `json` says so.
    pub fn mark(&mut self, view: usize, usage: Usage, json: &Json<'_>) -> Result<()> {
        let view = &mut self.views[view];
        if usage != Usage::Vertices && view.stride.is_some() {
            let allowed = "a view without byteStride, which is for vertices";
            return Err(json.fault("bufferView", "a view with byteStride", allowed));
        }
        match view.usage {
            Some(other) if other != usage => {
                let found = format!("used as {usage:?} and as {other:?}").to_lowercase();
                Err(json.fault("bufferView", found, "one use of a view"))
            }
            _ => {
                view.usage = Some(usage);
                Ok(())
            }
        }
    }
}

/// The bytes behind the URI of a buffer.
fn load(
    uri: &Json<'_>,
    length: u64,
    beside: Beside<'_>,
    limits: &Limits,
) -> Result<Option<Cow<'static, [u8]>>> {
    let text = uri.text()?;
    let target = uri::resolve(text, uri.path)
        .map_err(|why| uri.fault("uri", why, "a relative reference or data in base64"))?;
    match target {
        Target::Data { media, bytes } if MEDIA.contains(&media.as_str()) => Ok(Some(bytes.into())),
        Target::Data { media, .. } => {
            Err(uri.fault("media type of a buffer", format!("{media:?}"), MEDIA.join(", ")))
        }
        Target::Elsewhere => Ok(None),
        Target::File(path) => {
            let mut bytes = beside.read(&path, limits).map_err(|e| uri.referenced(e))?;
            bytes.truncate(length as usize);
            Ok(Some(bytes.into()))
        }
    }
}

fn view(json: &Json<'_>, buffers: &[Buffer<'_>]) -> Result<View> {
    let buffer = json.require("buffer")?.index(buffers.len())?;
    let offset = json.whole_or("byteOffset", 0)?;
    let length = json.require("byteLength")?.whole(1)?;
    let most = buffers[buffer].length;
    if offset.saturating_add(length) > most {
        let found = format!("{length} bytes from {offset} on");
        return Err(json.fault("bufferView", found, format!("within {most} bytes of the buffer")));
    }
    let stride = json.get("byteStride").map(|value| value.whole(4)).transpose()?;
    if let Some(stride) = stride
        && (stride % 4 != 0 || stride > 252 || stride > length)
    {
        let allowed = "a multiple of 4 up to 252 and to byteLength";
        return Err(json.fault("byteStride", stride.to_string(), allowed));
    }
    let usage = match json.get("target").map(|value| value.whole(0)).transpose()? {
        Some(VERTICES) => Some(Usage::Vertices),
        Some(INDICES) => Some(Usage::Indices),
        _ => None,
    };
    if stride.is_some() && usage == Some(Usage::Indices) {
        return Err(json.fault("byteStride", "set for indices", "byteStride for vertices only"));
    }
    Ok(View { buffer, offset, length, stride, usage, attributes: Vec::new() })
}

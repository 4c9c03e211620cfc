//! Images and textures.

use std::path::PathBuf;
use std::sync::Arc;

use rilievo::map::Wrap;

use super::buffers::{Buffers, Usage};
use super::json::Json;
use super::uri::{self, Target};
use crate::error::{Error, Result};
use crate::image::{ImageFormat, read_image_info, read_image_info_bytes};
use crate::limits::Limits;
use crate::mesh::{Beside, ImageSource};

/// Media types of images.
const MEDIA: [&str; 2] = ["image/png", "image/jpeg"];

/// Codes of samplers.
const REPEAT: u64 = 10497;
const CLAMP_TO_EDGE: u64 = 33071;
const MIRRORED_REPEAT: u64 = 33648;

/// The images and textures of a document.
pub(super) struct Images {
    /// Where the bytes of each image are; none for one that is not of a known format.
    sources: Vec<Option<ImageSource>>,
    /// The image of each texture, and what lies beyond its borders.
    textures: Vec<(Option<usize>, [Wrap; 2])>,
}

impl Images {
    /// Reads headers of images, and textures.
    pub fn read(
        root: &Json<'_>,
        buffers: &mut Buffers<'_>,
        (beside, limits): (Beside<'_>, &Limits),
        notes: &mut Vec<String>,
    ) -> Result<Self> {
        let mut sources = Vec::new();
        for json in root.objects("images")? {
            let source = image(&json, buffers, beside, limits)?;
            if source.is_none() {
                notes.push(format!("{}: no PNG or JPEG that can be opened", json.pointer));
            }
            sources.push(source);
        }
        let mut samplers = Vec::new();
        for json in root.objects("samplers")? {
            let mut wraps = [Wrap::Repeat; 2];
            for (wrap, key) in wraps.iter_mut().zip(["wrapS", "wrapT"]) {
                *wrap = match json.whole_or(key, REPEAT)? {
                    CLAMP_TO_EDGE => Wrap::Clamp,
                    MIRRORED_REPEAT => Wrap::Mirror,
                    _ => Wrap::Repeat,
                };
            }
            samplers.push(wraps);
        }
        let mut textures = Vec::new();
        for json in root.objects("textures")? {
            let sampler = json.index_of("sampler", samplers.len())?;
            let wraps = sampler.map_or([Wrap::Repeat; 2], |sampler| samplers[sampler]);
            textures.push((json.index_of("source", sources.len())?, wraps));
        }
        Ok(Self { sources, textures })
    }

    /// Number of textures.
    pub fn textures(&self) -> usize {
        self.textures.len()
    }

    /// The image of a texture, if it can be used, and what lies beyond its borders.
    pub fn of_texture(&self, texture: usize) -> Option<(ImageSource, [Wrap; 2])> {
        let (source, wraps) = self.textures[texture];
        Some((self.sources[source?].clone()?, wraps))
    }
}

fn image(
    json: &Json<'_>,
    buffers: &mut Buffers<'_>,
    beside: Beside<'_>,
    limits: &Limits,
) -> Result<Option<ImageSource>> {
    let declared = json.text_of("mimeType")?;
    let embedded = |bytes: &[u8]| ImageSource::Embedded {
        name: PathBuf::from(format!("{}{}", json.path.display(), json.pointer)),
        bytes: Arc::from(bytes),
    };
    let source = match (json.get("uri"), json.get("bufferView")) {
        (Some(uri), None) => {
            let target = uri::resolve(uri.text()?, uri.path)
                .map_err(|why| uri.fault("uri", why, "a relative reference or data in base64"))?;
            match target {
                Target::Elsewhere => return Ok(None),
                Target::File(path) => ImageSource::File(path),
                Target::Data { media, bytes } if MEDIA.contains(&media.as_str()) => {
                    embedded(&bytes)
                }
                Target::Data { media, .. } => {
                    let allowed = MEDIA.join(", ");
                    return Err(uri.fault("media type of an image", format!("{media:?}"), allowed));
                }
            }
        }
        (None, Some(view)) => {
            if declared.is_none() {
                return Err(json.fault("image", "bufferView without mimeType", "both"));
            }
            let index = view.index(buffers.views.len())?;
            buffers.mark(index, Usage::Other, &view)?;
            match buffers.bytes(index) {
                Some(bytes) => embedded(bytes),
                None => return Ok(None),
            }
        }
        _ => return Err(json.fault("image", "not one of uri and bufferView", "one of both")),
    };
    let format = match &source {
        ImageSource::File(path) => {
            // Where files may not be opened, nothing is known of them.
            let uri = json.require("uri")?;
            let refer = |e| uri.referenced(e);
            let Some(head) = beside.head(path).map_err(refer)? else { return Ok(Some(source)) };
            let format = ImageFormat::of(&head);
            if is_readable(format) {
                read_image_info(path, limits).map_err(refer)?;
            }
            format
        }
        ImageSource::Embedded { name, bytes } => {
            let format = ImageFormat::of(bytes);
            if is_readable(format) {
                read_image_info_bytes(bytes, name, limits).map_err(|e| wrong(json, &e))?;
            }
            format
        }
    };
    let media = match format {
        Some(ImageFormat::Png) => "image/png",
        Some(ImageFormat::Jpeg) => "image/jpeg",
        _ => return Ok(None),
    };
    match declared {
        Some(declared) if declared != media => {
            Err(json.fault("mimeType", format!("{declared:?} of {media}"), media))
        }
        _ => Ok(Some(source)),
    }
}

fn is_readable(format: Option<ImageFormat>) -> bool {
    matches!(format, Some(ImageFormat::Png | ImageFormat::Jpeg))
}

fn wrong(json: &Json<'_>, error: &Error) -> Error {
    json.fault("image", error.to_string(), "an image that is whole")
}

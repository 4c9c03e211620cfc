//! Images and textures.

use std::path::PathBuf;
use std::sync::Arc;

use super::buffers::{Buffers, Usage};
use super::json::Json;
use super::uri::{self, Target};
use crate::error::{Error, Result};
use crate::image::{ImageFormat, read_image_info, read_image_info_bytes};
use crate::limits::Limits;
use crate::mesh::{Beside, ImageSource};

/// Media types of images.
const MEDIA: [&str; 2] = ["image/png", "image/jpeg"];

/// The images and textures of a document.
pub(super) struct Images {
    /// Where the bytes of each image are; none for one that is not of a known format.
    sources: Vec<Option<ImageSource>>,
    /// The image of each texture.
    textures: Vec<Option<usize>>,
}

impl Images {
    /// Reads headers of images, and textures.
    pub fn read(
        root: &Json<'_>,
        buffers: &mut Buffers<'_>,
        (beside, limits): (Beside, &Limits),
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
        let samplers = root.objects("samplers")?.len();
        let mut textures = Vec::new();
        for json in root.objects("textures")? {
            json.index_of("sampler", samplers)?;
            textures.push(json.index_of("source", sources.len())?);
        }
        Ok(Self { sources, textures })
    }

    /// Number of textures.
    pub fn textures(&self) -> usize {
        self.textures.len()
    }

    /// The image of a texture, if it can be used.
    pub fn of_texture(&self, texture: usize) -> Option<ImageSource> {
        self.sources[self.textures[texture]?].clone()
    }
}

fn image(
    json: &Json<'_>,
    buffers: &mut Buffers<'_>,
    beside: Beside,
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

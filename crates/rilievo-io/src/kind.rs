//! [`FileKind`]: what a file is, told from its first bytes.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use crate::error::{Error, Place, Result};
use crate::image::{ImageFormat, Udim};
use crate::map_file;
use crate::mesh::MeshFormat;

/// What a file is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileKind {
    /// An image of a known format.
    Image(ImageFormat),
    /// A model of a known format.
    Mesh(MeshFormat),
    /// A baked map.
    BakedMap,
    /// Text, such as a scene.
    Text,
}

impl FileKind {
    /// The kind of the file `path`; of an image in tiles, of the first of them.
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::Unsupported`] for a file that is none of them.
    pub fn of(path: &Path) -> Result<Self> {
        if let Some(tiles) = Udim::find(path)? {
            return Self::of(tiles.first());
        }
        let mut head = Vec::new();
        let file = File::open(path).map_err(|e| Error::io(path, e))?;
        file.take(64).read_to_end(&mut head).map_err(|e| Error::io(path, e))?;
        Self::of_head(&head, path).ok_or_else(|| {
            let found = match head.as_slice() {
                [] => "an empty file".to_owned(),
                _ => format!("a file that begins with {:02x?}", &head[..head.len().min(8)]),
            };
            let (images, meshes) = (ImageFormat::NAMES, MeshFormat::NAMES);
            let allowed = format!("an image ({images}), a model ({meshes}), a baked map, a scene");
            Error::unsupported(path, Place::File, "kind of file", found, allowed)
        })
    }

    /// The kind of a file called `path` that begins with `head`.
    fn of_head(head: &[u8], path: &Path) -> Option<Self> {
        if let Some(format) = ImageFormat::of_file(head, path) {
            return Some(Self::Image(format));
        }
        if let Some(format) = MeshFormat::of(head, path) {
            return Some(Self::Mesh(format));
        }
        if map_file::is_map_file(head) {
            return Some(Self::BakedMap);
        }
        let control = |&b: &u8| b < 32 && !b.is_ascii_whitespace();
        (!head.is_empty() && !head.iter().any(control)).then_some(Self::Text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kinds_are_told_from_content() {
        let of = |head| FileKind::of_head(head, Path::new("a"));
        assert_eq!(of(b"\x89PNG\r\n\x1a\n"), Some(FileKind::Image(ImageFormat::Png)));
        assert_eq!(of(b"\x89RLVO\r\n\x1a"), Some(FileKind::BakedMap));
        assert_eq!(of("# Grün\n\t[camera]\r\n".as_bytes()), Some(FileKind::Text));
        assert_eq!(of(b"\x00\x01"), None);
        assert_eq!(of(b""), None);
        assert_eq!(of(b"ply\nformat"), Some(FileKind::Mesh(MeshFormat::Ply)));
        let obj = FileKind::of_head(b"v 1 2 3", Path::new("a.OBJ"));
        assert_eq!(obj, Some(FileKind::Mesh(MeshFormat::Obj)));
    }
}

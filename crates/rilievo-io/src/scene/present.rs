//! Scenes for what is no scene: a texture set or a model alone.

use std::path::Path;

use super::file::SceneFile;
use crate::error::{Error, Place, Result};
use crate::kind::FileKind;
use crate::limits::Limits;
use crate::mesh::Model;
use crate::texture_set::TextureSet;

/// What errors call the scene that was made.
const NAME: &str = "presentation.toml";

impl SceneFile {
    /// Reads a scene file, or makes the scene that shows the texture set of a folder, or a model.
    ///
    /// # Errors
    /// As [`SceneFile::read`]; of the folder or the model, of one without displacement or triangles.
    pub fn present(path: &Path, limits: &Limits) -> Result<Self> {
        if path.is_dir() {
            let text = TextureSet::find(path, limits)?.presentation()?;
            return Self::parse(&text, &path.join(NAME));
        }
        match FileKind::of(path) {
            Ok(FileKind::Mesh(_)) => {
                let text = Model::read(path, limits)?.presentation(path).ok_or_else(|| {
                    let found = "the mesh has no triangles";
                    Error::invalid(path, Place::File, "mesh", found, "at least one face")
                })?;
                Self::parse(&text, &path.with_file_name(NAME))
            }
            _ => Self::read(path, limits),
        }
    }
}

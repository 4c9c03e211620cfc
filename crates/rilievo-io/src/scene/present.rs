//! Scenes for what is no scene: a texture set, a model or a height map alone.

use std::path::Path;

use super::cache::Cache;
use super::file::SceneFile;
use super::syntax::quoted;
use crate::error::{Error, Place, Result};
use crate::image::{HeightOptions, Terrain, read_image_info};
use crate::kind::FileKind;
use crate::limits::Limits;
use crate::mesh::Model;
use crate::texture_set::{Assumed, TextureSet, ground};

/// What errors call the scene that was made.
const NAME: &str = "presentation.toml";

impl SceneFile {
    /// Reads a scene file, or makes the scene that shows the texture set of a folder, a model, or a
    /// height map.
    ///
    /// # Errors
    /// As [`SceneFile::read`]; of the folder or the model, of one without displacement or triangles.
    pub fn present(path: &Path, limits: &Limits) -> Result<Self> {
        Self::present_into(path, limits, None)
    }

    /// [`SceneFile::present`], leaving what was read for [`SceneFile::load`].
    ///
    /// # Errors
    /// As [`SceneFile::present`].
    pub fn present_into(path: &Path, limits: &Limits, cache: Option<&Cache>) -> Result<Self> {
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
            Ok(FileKind::Image(_)) => {
                Self::parse(&of_map(path, limits, cache)?, &path.with_file_name(NAME))
            }
            _ => Self::read(path, limits),
        }
    }
}

/// The text of a scene that shows a height map: as terrain, if its file says how large it is.
fn of_map(path: &Path, limits: &Limits, cache: Option<&Cache>) -> Result<String> {
    let image = read_image_info(path, limits)?;
    let file = quoted(&path.file_name().unwrap_or_default().to_string_lossy());
    let map = format!("[maps.map]\nfile = {file}\n");
    let Some(terrain) = Terrain::read(path, limits)? else {
        let depth = f64::from(image.height) / f64::from(image.width);
        let heights = HeightOptions::default().read(path, limits)?;
        let Assumed { zero, scale, .. } = Assumed::of(&heights, path);
        if let Some(cache) = cache {
            cache.keep_judged(path, heights);
        }
        let displacement =
            format!("displacement = {{ map = \"map\", scale = {scale}, zero = {zero} }}");
        return Ok(map + "\n" + &ground(depth, &displacement));
    };
    // Kilometres would make a camera easier to place by hand; widths need no thought at all.
    let width = f64::from(image.width.max(2) - 1) * terrain.cell[0];
    let depth = f64::from(image.height.max(2) - 1) * terrain.cell[1] / width;
    let map = map + "grid = \"vertex\"\nwrap = \"clamp\"\n";
    let terrain = format!("center = [0.5, {}, 0]\nmap = \"map\"\nunit = {width}", 0.5 * depth);
    Ok(map + "\n" + &ground(depth, &terrain))
}

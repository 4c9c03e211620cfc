//! `texture_memory`: images that do not fit lie in tiles in a temporary file.
//!
//! Images are held in memory as long as all of them fit, with their coarser ones. The first that does not
//! fit goes to the file, and so do all others then: the memory is the cache's
//! ([`TileCache`]). So while a scene is loaded there is at most one image more than is allowed.
//!
//! The file has no name from the moment it is there, where the system knows such files: nothing is left
//! of it, however the program ends. It is made in the system's folder for temporary files (`TMPDIR`).

use std::fs::File;
use std::io::{self, Write};
use std::path::PathBuf;
use std::sync::Arc;

use rilievo_render::Material;
use rilievo_render::texture::{ColourImage, TileCache, TileSource};

use super::resolve::Loader;
use crate::error::{Error, Result};

/// What images take.
#[derive(Debug, Default)]
pub(super) struct TextureMemory {
    /// Bytes of those in memory.
    held: u64,
    /// Where the others are.
    tiles: Option<Tiles>,
}

/// Images in a file.
#[derive(Debug)]
struct Tiles {
    file: File,
    /// Its folder.
    folder: PathBuf,
    cache: Arc<TileCache>,
    /// Bytes written.
    end: u64,
}

/// Reads the file back.
#[derive(Debug)]
struct ReadBack {
    file: File,
    folder: PathBuf,
    /// Held while the file's one place for reading and writing is moved.
    #[cfg(not(unix))]
    one: std::sync::Mutex<()>,
}

impl ReadBack {
    #[cfg(unix)]
    fn read_at(&self, offset: u64, bytes: &mut [u8]) -> io::Result<()> {
        std::os::unix::fs::FileExt::read_exact_at(&self.file, bytes, offset)
    }

    #[cfg(not(unix))]
    fn read_at(&self, offset: u64, bytes: &mut [u8]) -> io::Result<()> {
        use std::io::{Read, Seek, SeekFrom};

        let _one = self.one.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        let mut file = &self.file;
        file.seek(SeekFrom::Start(offset))?;
        file.read_exact(bytes)
    }
}

impl TileSource for ReadBack {
    fn read(&self, offset: u64, bytes: &mut [u8]) -> std::result::Result<(), String> {
        let told = |e| format!("the temporary file in {}: {e}", self.folder.display());
        self.read_at(offset, bytes).map_err(told)
    }
}

impl Tiles {
    /// An empty file, and a cache of so many bytes.
    fn new(capacity: u64) -> Result<Self> {
        let folder = std::env::temp_dir();
        let fail = |e| Error::io(&folder, e);
        let file = tempfile::tempfile_in(&folder).map_err(fail)?;
        let back = ReadBack {
            file: file.try_clone().map_err(fail)?,
            folder: folder.clone(),
            #[cfg(not(unix))]
            one: std::sync::Mutex::default(),
        };
        let cache = Arc::new(TileCache::new(Box::new(back), capacity));
        Ok(Self { file, folder, cache, end: 0 })
    }

    /// Puts an image into the file.
    fn put(&mut self, image: &ColourImage) -> Result<ColourImage> {
        let first = self.end;
        image.tiled(&self.cache, first, &mut |tile| {
            self.file.write_all(tile).map_err(|e| Error::io(&self.folder, e))?;
            self.end += tile.len() as u64;
            Ok(())
        })
    }
}

impl Loader<'_> {
    /// Bytes that images may take, if there is a limit.
    pub(super) fn texture_limit(&self) -> Option<u64> {
        self.options.texture_memory.or(self.file.render.texture_memory)
    }

    /// The image as it is, if it fits beside those before; in tiles if not.
    pub(super) fn fitted(&mut self, image: ColourImage) -> Result<ColourImage> {
        let Some(limit) = self.texture_limit() else { return Ok(image) };
        let bytes = image.bytes() + image.coarser_bytes();
        let memory = &mut self.texture_memory;
        match &mut memory.tiles {
            None if memory.held + bytes <= limit => {
                memory.held += bytes;
                Ok(image)
            }
            None => memory.tiles.insert(Tiles::new(limit)?).put(&image),
            Some(tiles) => tiles.put(&image),
        }
    }

    /// Where an image has not fitted, puts those before it into the file, too, and tells.
    pub(super) fn fit_images(&mut self, materials: &mut [Material]) -> Result<()> {
        let Some(limit) = self.texture_limit() else { return Ok(()) };
        let Some(tiles) = &mut self.texture_memory.tiles else { return Ok(()) };
        let mut moved: Vec<(Arc<ColourImage>, Arc<ColourImage>)> = Vec::new();
        for image in self.images.values_mut().filter(|image| image.cache().is_none()) {
            let tiled = Arc::new(tiles.put(image)?);
            moved.push((std::mem::replace(image, Arc::clone(&tiled)), tiled));
        }
        for material in materials {
            *material = material.with_images(&|image| {
                let found = moved.iter().find(|(old, _)| Arc::ptr_eq(old, image));
                Arc::clone(found.map_or(image, |(_, new)| new))
            });
        }
        let mib = |bytes: u64| bytes.div_ceil(1 << 20);
        self.notes.push(format!(
            "textures of {} MiB do not fit texture_memory = {}: they lie in a temporary file, and \
             what is looked at is read from there",
            mib(tiles.end),
            mib(limit)
        ));
        Ok(())
    }
}

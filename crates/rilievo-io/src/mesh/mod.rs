//! Mesh files: Wavefront OBJ with MTL, PLY, glTF 2.0 and GLB.
//!
//! A [`Model`] is what a file holds; [`Model::mesh`] is checked and ready to be traced once
//! [`Mesh::new`] has taken it. The format is told from the content, for OBJ and glTF, which have no
//! mark, from the name.

mod gltf;
mod model;
mod mtl;
mod obj;
mod ply;
mod presentation;
mod projection;
mod words;

use std::cell::RefCell;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use rilievo::mesh::Mesh;

pub use model::{
    ImageSource, ImageUse, LightKind, Model, ModelCamera, ModelDisplacement, ModelLight,
    ModelMaterial, NO_MATERIAL,
};

pub use projection::Projection;

use crate::error::{Error, Place, Result};
use crate::limits::Limits;

/// The mesh formats that are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshFormat {
    /// Wavefront OBJ.
    Obj,
    /// Stanford PLY.
    Ply,
    /// glTF 2.0 as JSON.
    Gltf,
    /// glTF 2.0 in one binary file.
    Glb,
}

impl MeshFormat {
    /// What is read, in words.
    pub(crate) const NAMES: &'static str = "OBJ, PLY, glTF, GLB";

    /// The format of a file called `path` that begins with `head`.
    pub fn of(head: &[u8], path: &Path) -> Option<Self> {
        if let [b'p', b'l', b'y', b'\n' | b'\r' | b' ', ..] = head {
            return Some(Self::Ply);
        }
        if head.starts_with(gltf::MAGIC) {
            return Some(Self::Glb);
        }
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "obj" => Some(Self::Obj),
            "gltf" => Some(Self::Gltf),
            "glb" => Some(Self::Glb),
            _ => None,
        }
    }
}

impl std::fmt::Display for MeshFormat {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Obj => "OBJ",
            Self::Ply => "PLY",
            Self::Gltf => "glTF",
            Self::Glb => "GLB",
        })
    }
}

/// Whether files that a model names may be opened.
#[derive(Clone, Copy, Debug)]
enum Beside<'a> {
    /// They may; those that were read are noted.
    Files(&'a RefCell<Vec<PathBuf>>),
    Nothing,
}

impl Beside<'_> {
    /// The bytes of a file.
    fn read(self, path: &Path, limits: &Limits) -> Result<Vec<u8>> {
        match self {
            Self::Files(noted) => {
                let bytes = limits.read(path)?;
                noted.borrow_mut().push(path.to_owned());
                Ok(bytes)
            }
            Self::Nothing => Err(Error::io(path, std::io::ErrorKind::NotFound.into())),
        }
    }

    /// The first bytes of a file; none where files are not opened.
    fn head(self, path: &Path) -> Result<Option<Vec<u8>>> {
        let fail = |e| Error::io(path, e);
        match self {
            Self::Files(_) => {
                let mut head = Vec::new();
                let file = File::open(path).map_err(fail)?;
                file.take(16).read_to_end(&mut head).map_err(fail)?;
                Ok(Some(head))
            }
            Self::Nothing => Ok(None),
        }
    }
}

impl Model {
    /// Reads a model and the files it names beside it; of images only the headers, if at all.
    ///
    /// # Errors
    /// Of the file or its size; content that breaks its format; a format that is not known. A file
    /// without faces is a model without triangles.
    pub fn read(path: &Path, limits: &Limits) -> Result<Self> {
        let noted = RefCell::default();
        let model = Self::decode(&limits.read(path)?, path, limits, Beside::Files(&noted))?;
        Ok(Self { files: noted.into_inner(), ..model })
    }

    /// Reads a model from bytes; `name` is what errors call them. No other file is opened.
    ///
    /// # Errors
    /// As [`Model::read`]; a glTF buffer in a file. Of OBJ files materials are missing, which is no
    /// error.
    pub fn read_bytes(bytes: &[u8], name: &Path, limits: &Limits) -> Result<Self> {
        Self::decode(bytes, name, limits, Beside::Nothing)
    }

    fn decode(bytes: &[u8], name: &Path, limits: &Limits, beside: Beside<'_>) -> Result<Self> {
        match MeshFormat::of(bytes, name) {
            Some(MeshFormat::Obj) => {
                obj::read(bytes, name, limits, &|path| beside.read(path, limits))
            }
            Some(MeshFormat::Ply) => ply::read(bytes, name, limits),
            Some(MeshFormat::Gltf | MeshFormat::Glb) => gltf::read(bytes, name, limits, beside),
            None => {
                let found = match bytes {
                    [] => "an empty file".to_owned(),
                    _ => format!("a file that begins with {:02x?}", &bytes[..bytes.len().min(8)]),
                };
                let allowed = MeshFormat::NAMES;
                Err(Error::unsupported(name, Place::File, "mesh format", found, allowed))
            }
        }
    }
}

/// Reads the materials of an MTL file from bytes; `name` is what errors call them, and beside it
/// images are looked for.
///
/// # Errors
/// A line that is wrong; more materials than the limits allow.
pub fn read_materials_bytes(
    bytes: &[u8],
    name: &Path,
    limits: &Limits,
) -> Result<Vec<ModelMaterial>> {
    mtl::read(bytes, name, limits)
}

/// Reads a mesh, whatever its materials.
///
/// # Errors
/// As [`Model::read`], and a file without faces.
pub fn read_mesh(path: &Path, limits: &Limits) -> Result<Mesh> {
    let model = Model::read(path, limits)?;
    Mesh::new(model.mesh).map_err(|e| {
        let allowed = "at least one face, finite numbers";
        Error::invalid(path, Place::File, "mesh", e.to_string(), allowed)
    })
}

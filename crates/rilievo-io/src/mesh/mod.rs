//! Mesh files: Wavefront OBJ with MTL, and PLY.
//!
//! A [`Model`] is what a file holds; [`Model::mesh`] is checked and ready to be traced once
//! [`Mesh::new`] has taken it. The format is told from the content, for OBJ, which has no mark, from
//! the name.

mod model;
mod mtl;
mod obj;
mod ply;
mod presentation;
mod words;

use std::path::Path;

use rilievo::mesh::Mesh;

pub use model::{
    ImageSource, ImageUse, LightKind, Model, ModelCamera, ModelDisplacement, ModelLight,
    ModelMaterial, NO_MATERIAL,
};

use crate::error::{Error, Place, Result};
use crate::limits::Limits;

/// The mesh formats that are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshFormat {
    /// Wavefront OBJ.
    Obj,
    /// Stanford PLY.
    Ply,
}

impl MeshFormat {
    /// What is read, in words.
    pub(crate) const NAMES: &'static str = "OBJ, PLY";

    /// The format of a file called `path` that begins with `head`.
    pub fn of(head: &[u8], path: &Path) -> Option<Self> {
        if let [b'p', b'l', b'y', b'\n' | b'\r' | b' ', ..] = head {
            return Some(Self::Ply);
        }
        let ending = path.extension()?.to_str()?;
        ending.eq_ignore_ascii_case("obj").then_some(Self::Obj)
    }
}

impl std::fmt::Display for MeshFormat {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Obj => "OBJ",
            Self::Ply => "PLY",
        })
    }
}

impl Model {
    /// Reads a model and the files it names beside it, but for images.
    ///
    /// # Errors
    /// Of the file or its size; content that breaks its format; a format that is not known. A file
    /// without faces is a model without triangles.
    pub fn read(path: &Path, limits: &Limits) -> Result<Self> {
        let beside = |path: &Path| limits.read(path);
        Self::decode(&limits.read(path)?, path, limits, &beside)
    }

    /// Reads a model from bytes; `name` is what errors call them. No other file is opened.
    ///
    /// # Errors
    /// As [`Model::read`]; of OBJ files materials are missing, which is no error.
    pub fn read_bytes(bytes: &[u8], name: &Path, limits: &Limits) -> Result<Self> {
        let beside = |path: &Path| Err(Error::io(path, std::io::ErrorKind::NotFound.into()));
        Self::decode(bytes, name, limits, &beside)
    }

    fn decode(
        bytes: &[u8],
        name: &Path,
        limits: &Limits,
        beside: &dyn Fn(&Path) -> Result<Vec<u8>>,
    ) -> Result<Self> {
        match MeshFormat::of(bytes, name) {
            Some(MeshFormat::Obj) => obj::read(bytes, name, limits, beside),
            Some(MeshFormat::Ply) => ply::read(bytes, name, limits),
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

//! [`SceneFile`]: what a scene file says, checked value by value, places kept.
//!
//! Nothing is opened and no name is looked up here; see [`super::resolve`].

mod camera;
mod instances;
mod light;
mod map;
mod material;
mod model;
mod motion;
mod render;
mod shape;
mod terrain;
mod texture;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use rilievo_render::light::Light;
use toml::de::DeTable;

use super::keys::scene as keys;
use super::sets::is_set;
use super::syntax::{Document, Located, Table};
use crate::error::{Error, Result};
use crate::limits::Limits;

pub(super) use camera::CameraEntry;
pub(super) use instances::InstanceEntry;
pub(super) use light::EnvironmentEntry;
pub(super) use map::{MapEntry, MapSource};
pub(super) use material::{Diffuse, MaterialEntry};
pub(super) use model::{
    BASE_COLOUR, METALLIC, MetalEntry, ModelEntry, OPACITY, PrincipledEntry, ROUGHNESS,
};
pub(super) use render::RenderEntry;
pub(super) use shape::{
    DisplacementEntry, MeshEntry, Normals, QuadEntry, Shape, ShapeEntry, SphereEntry,
};
pub(super) use terrain::GroundEntry;
pub(super) use texture::{ColourEntry, NormalEntry, NumberEntry, TextureEntry};

/// A scene file, read and checked by itself.
#[derive(Clone, Debug)]
pub struct SceneFile {
    pub(super) path: PathBuf,
    pub(super) text: Arc<str>,
    pub(super) camera: CameraEntry,
    pub(super) render: RenderEntry,
    pub(super) maps: Vec<(Located<String>, MapEntry)>,
    pub(super) materials: Vec<(Located<String>, MaterialEntry)>,
    pub(super) shapes: Vec<ShapeEntry>,
    pub(super) lights: Vec<Light>,
    pub(super) environment: Option<EnvironmentEntry>,
}

impl SceneFile {
    /// Reads a scene file.
    ///
    /// # Errors
    /// [`Error::Io`], [`Error::Limit`], and as [`SceneFile::parse`].
    pub fn read(path: &Path, limits: &Limits) -> Result<Self> {
        let bytes = limits.read(path)?;
        let text = String::from_utf8(bytes).map_err(|e| {
            let at = e.utf8_error().valid_up_to();
            let line = e.as_bytes()[..at].iter().filter(|b| **b == b'\n').count() + 1;
            let found = format!("a byte in line {line} that is not UTF-8");
            Error::invalid(path, crate::Place::File, "text", found, "UTF-8")
        })?;
        Self::parse(&text, path)
    }

    /// Reads the text of a scene file; `path` is what errors call it and where relative paths
    /// start.
    ///
    /// # Errors
    /// [`Error::Invalid`] for text that is not TOML, an unknown key, a missing one, a value of the
    /// wrong type or out of range. The place is the value's.
    pub fn parse(text: &str, path: &Path) -> Result<Self> {
        let doc = Document { path, text };
        let parsed = DeTable::parse(text).map_err(|e| doc.syntax_error(&e))?;
        let root = Table::root(doc, &parsed);
        let (camera, render) = (root.require(&keys::CAMERA)?, root.get(&keys::RENDER));
        let (maps, materials) = (root.get(&keys::MAPS), root.get(&keys::MATERIALS));
        let (shapes, lights) = (root.get(&keys::SHAPES), root.get(&keys::LIGHTS));
        let environment = root.get(&keys::ENVIRONMENT);
        root.finish()?;

        let camera = CameraEntry::read(&camera.table()?)?;
        let nothing = DeTable::new();
        let render = match render {
            Some(value) => RenderEntry::read(&value.table()?)?,
            None => RenderEntry::read(&root.without(&keys::RENDER, &nothing))?,
        };
        let mut file = Self {
            path: path.to_owned(),
            text: text.into(),
            camera,
            render,
            maps: Vec::new(),
            materials: Vec::new(),
            shapes: Vec::new(),
            lights: Vec::new(),
            environment: None,
        };
        if let Some(value) = maps {
            for (name, value) in value.table()?.all() {
                file.maps.push((name, MapEntry::read(&value.table()?)?));
            }
        }
        if let Some(value) = materials {
            for (name, value) in value.table()?.all() {
                file.materials.push((name, MaterialEntry::read(&value.table()?)?));
            }
        }
        if let Some(value) = shapes {
            for value in value.items("an array of tables: [[shapes]]")? {
                file.shapes.push(ShapeEntry::read(&value.table()?)?);
            }
        }
        if let Some(value) = lights {
            for value in value.items("an array of tables: [[lights]]")? {
                file.lights.push(light::light(&value.table()?)?);
            }
        }
        if let Some(value) = environment {
            file.environment = Some(EnvironmentEntry::read(&value.table()?)?);
        }
        Ok(file)
    }

    /// The file `name`, in the role of `what`, could not be used.
    pub(super) fn referenced(&self, name: &Located<String>, what: &str, source: Error) -> Error {
        let found = format!("\"{}\" cannot be used", name.value);
        let fault = self.document().fault(&name.at, what, found, "");
        Error::Reference { fault: Box::new(fault), source: Box::new(source) }
    }

    /// What it says.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The files and folders the scene names, in the order of maps, materials, shapes and environment;
    /// see [`LoadedScene::files`](super::LoadedScene::files) for those that models name.
    pub fn references(&self) -> Vec<PathBuf> {
        let maps = self.maps.iter().filter_map(|(_, map)| match &map.source {
            MapSource::File { file, .. } => Some(file),
            MapSource::Procedural { .. } => None,
        });
        let baked = self.maps.iter().filter_map(|(_, map)| map.distance.file.as_ref());
        let mut textures = Vec::new();
        for (_, material) in &self.materials {
            let mut material = material.clone();
            textures.extend(material.textures_mut().into_iter().map(|t| t.file.clone()));
            if let ModelEntry::Principled(model) = &material.model {
                textures.extend(model.set.as_ref().map(|set| set.file.clone()));
            }
        }
        let meshes = self.shapes.iter().filter_map(|shape| match &shape.shape {
            Shape::Mesh(mesh) => Some(&mesh.file),
            Shape::Quad(_) | Shape::Sphere(_) => None,
        });
        let normals =
            self.shapes.iter().filter_map(|shape| match &shape.shape.displacement()?.normals {
                Normals::File { file, .. } => Some(file),
                _ => None,
            });
        let sets = self.shapes.iter().filter_map(|shape| {
            let map = &shape.shape.displacement()?.map;
            is_set(&map.value).then_some(map)
        });
        let shapes = meshes.chain(normals).chain(sets);
        let shapes = shapes.chain(self.environment.as_ref().map(|e| &e.file));
        maps.chain(baked).chain(&textures).chain(shapes).map(|f| self.beside(&f.value)).collect()
    }

    /// A path of the file; relative ones start at its folder.
    pub(super) fn beside(&self, file: &str) -> PathBuf {
        self.path.parent().unwrap_or(Path::new("")).join(file)
    }

    pub(super) fn document(&self) -> Document<'_> {
        Document { path: &self.path, text: &self.text }
    }
}

//! Meshes of a scene with the materials of their own files.
//!
//! What becomes of a material is told in `model_material`.

use std::sync::Arc;

use rilievo::glam::{DAffine3, DVec3};
use rilievo::map::{DistanceOptions, Metric};
use rilievo::mesh::Mesh;
use rilievo::relief::{Displacement, MeshOptions, MeshPart, Relief, ReliefMesh, ReliefMeshError};
use rilievo::surface::Surface;
use rilievo_render::Material;
use rilievo_render::light::{Light, PointLight, SunLight};

use super::file::MeshEntry;
use super::options::BuildDistances;
use super::relief_mesh::sides;
use super::resolve::Loader;
use super::syntax::Located;
use crate::error::{Error, Result};
use crate::image::HeightOptions;
use crate::mesh::{ImageSource, LightKind, Model, ModelLight, ModelMaterial};

/// A map with the distance map that the method of `options` walks, if it walks one; or what is wrong.
fn with_distance(
    relief: Arc<Relief>,
    mesh: &Mesh,
    options: &MeshOptions,
    build: &BuildDistances<'_>,
) -> std::result::Result<Arc<Relief>, String> {
    let Some(kind) = options.method.distance_kind().filter(|&k| relief.distance(k).is_none())
    else {
        return Ok(relief);
    };
    let (heights, displacement) = (relief.heights(), &options.displacement);
    let metric = Metric::of_face(heights, sides(mesh, displacement), displacement.scale.abs());
    let distances = DistanceOptions::by_default(heights, kind, metric);
    let map = build(heights, kind, &distances).map_err(|e| e.to_string())?;
    let relief = Arc::unwrap_or_clone(relief).with_distance(map).map_err(|e| e.to_string())?;
    Ok(Arc::new(relief))
}

impl Loader<'_> {
    /// Reads the model of an entry, with the texture coordinates and normals that it asks for.
    pub(super) fn model(&mut self, entry: &MeshEntry) -> Result<Model> {
        let path = self.file.beside(&entry.file.value);
        let mut model = match self.options.cache.and_then(|cache| cache.model(&path)) {
            Some(model) => model,
            None => Model::read(&path, &self.options.limits)
                .map_err(|e| self.file.referenced(&entry.file, "mesh", e))?,
        };
        if let Some(cache) = self.options.cache {
            cache.keep_model(&path, &model);
        }
        self.notes.extend(model.notes.iter().map(|note| format!("{}: {note}", path.display())));
        self.files.append(&mut model.files);
        if let Some(projection) = entry.projection {
            projection.lay(&mut model.mesh);
        }
        if entry.smooth {
            let groups = vec![1; model.mesh.triangles.len()];
            model.mesh.smooth(&groups);
        }
        Ok(model)
    }

    /// The mesh of `data`, placed.
    pub(super) fn placed(
        &self,
        data: rilievo::mesh::MeshData,
        file: &Located<String>,
        place: Option<&Located<DAffine3>>,
    ) -> Result<Mesh> {
        let refused = |at: &Located<String>, found: String, allowed: &str| {
            let fault = self.file.document().fault(&at.at, "mesh", found, allowed);
            Error::Invalid(Box::new(fault))
        };
        let mesh = Mesh::new(data).map_err(|e| {
            refused(file, e.to_string(), "a file with at least one face, finite numbers")
        })?;
        let Some(place) = place else { return Ok(mesh) };
        mesh.transformed(place.value).map_err(|e| {
            let at = Located { value: String::new(), at: place.at.clone() };
            refused(&at, e.to_string(), "a transform that can be inverted, numbers up to 1e100")
        })
    }

    /// The model of an entry cut by its materials, placed, each part displaced as its material says, and walls between
    /// them.
    pub(super) fn parts(&mut self, entry: &MeshEntry) -> Result<Vec<(Surface, Option<Material>)>> {
        let (file, place) = (&entry.file, entry.world_from_object.as_ref());
        let model = self.model(entry)?;
        self.light_of(&model, place);
        if model.mesh.triangles.is_empty() {
            return Ok(vec![(self.placed(model.mesh, file, place)?.into(), None)]);
        }
        // Displacements are in units of the file.
        let unit = place.map_or(1.0, |place| place.value.matrix3.determinant().abs().cbrt());
        let mut reliefs: Vec<(&ImageSource, Arc<Relief>)> = Vec::new();
        let (mut meshes, mut parts, mut materials) = (Vec::new(), Vec::new(), Vec::new());
        for (data, material) in model.by_material() {
            let mesh = self.placed(data, file, place)?;
            let material = material.and_then(|index| model.materials.get(index));
            materials.push((material, material.map(|m| self.model_material(m)).transpose()?));
            let Some(displacement) = material.and_then(|m| m.displacement.as_ref()) else {
                parts.push(MeshPart::plain(&mesh));
                meshes.push(mesh);
                continue;
            };
            let image = &displacement.image;
            let relief = match reliefs.iter().find(|(source, _)| **source == image.source) {
                Some((_, relief)) => Arc::clone(relief),
                None => {
                    let relief = self.own_relief(&image.source);
                    let relief =
                        relief.map_err(|e| self.file.referenced(file, "displacement", e))?;
                    reliefs.push((&image.source, Arc::clone(&relief)));
                    relief
                }
            };
            let options = MeshOptions {
                displacement: Displacement {
                    scale: displacement.scale * unit,
                    zero: displacement.zero,
                    tile: image.tile.into(),
                    shift: image.shift.into(),
                },
                ..self.mesh_options(entry)
            };
            let scene = self.file;
            let refuse = |found| scene.invalid(&file.at, "displacement", found, String::new());
            let build = self.options.build_distances;
            let mut relief = with_distance(relief, &mesh, &options, build).map_err(refuse)?;
            if entry.matched {
                let alone = ReliefMesh::new(&mesh, relief, options.clone());
                let alone = alone.map_err(|e| self.not_laid(file, material, &e))?;
                let matched = self.matched(entry, &mesh, alone, |relief| {
                    let relief = with_distance(Arc::new(relief), &mesh, &options, build);
                    relief.map(Arc::unwrap_or_clone).map_err(refuse)
                })?;
                relief = Arc::clone(matched.relief());
            }
            parts.push(MeshPart::displaced(&mesh, relief, options));
            meshes.push(mesh);
        }
        let joined = ReliefMesh::joined(&parts)
            .map_err(|(part, e)| self.not_laid(file, materials[part].0, &e))?;
        let all = joined.into_iter().zip(meshes).zip(materials);
        let surfaces = all.map(|((displaced, mesh), (_, own))| match displaced {
            Some(displaced) => {
                self.tell(&file.value, displaced.report());
                (displaced.into(), own)
            }
            None => (mesh.into(), own),
        });
        Ok(surfaces.collect())
    }

    /// Why the displacement of a model's material was refused.
    fn not_laid(
        &self,
        file: &Located<String>,
        material: Option<&ModelMaterial>,
        error: &ReliefMeshError,
    ) -> Error {
        let what = format!("displacement of {:?}", material.map_or("", |m| &m.name));
        let allowed = match error {
            ReliefMeshError::NoUv(_) => "texture coordinates, or `projection` in the shape",
            _ => "",
        };
        self.file.invalid(&file.at, &what, error.to_string(), allowed.to_owned())
    }

    /// Adds the lights of a model: a candela counts as 1 W/sr, a lux as 1 W/m^2. A transform moves and turns
    /// them, and leaves their numbers alone.
    fn light_of(&mut self, model: &Model, place: Option<&Located<DAffine3>>) {
        let place = place.map_or(DAffine3::IDENTITY, |place| place.value);
        for ModelLight { name, intensity, kind } in &model.lights {
            let along = |direction: DVec3| place.transform_vector3(direction);
            let at =
                |position: DVec3| PointLight::new(place.transform_point3(position), *intensity);
            let light = match *kind {
                LightKind::Point { position } => at(position).map(Light::Point),
                LightKind::Spot { position, direction, inner, outer } => at(position)
                    .and_then(|light| {
                        light.spot(along(direction), [inner, outer].map(f64::to_degrees))
                    })
                    .map(Light::Point),
                LightKind::Sun { direction } => {
                    SunLight::new(along(direction), *intensity, 0.0).map(Light::Sun)
                }
            };
            match light {
                Ok(light) => self.lamps.push(light),
                Err(e) => self.notes.push(format!("light {name:?} not used: {e}")),
            }
        }
    }

    /// The heights that a model's material names.
    fn own_relief(&mut self, source: &ImageSource) -> Result<Arc<Relief>> {
        let (heights, limits) = (HeightOptions::default(), &self.options.limits);
        let heights = match source {
            ImageSource::File(path) => {
                self.files.push(path.clone());
                heights.read(path, limits)
            }
            ImageSource::Embedded { name, bytes } => heights.read_bytes(bytes, name, limits),
        }?;
        Ok(Arc::new(Relief::with_layout(heights, self.options.layout.unwrap_or_default())))
    }
}

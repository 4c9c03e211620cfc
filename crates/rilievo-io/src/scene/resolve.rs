//! [`SceneFile::load`]: names to references, files to maps, meshes and images.

use std::collections::HashMap;
use std::ops::Range;
use std::path::PathBuf;
use std::sync::Arc;

use rilievo::map::{Lattice, NormalConvention, Wrap};
use rilievo::relief::{FaceError, FaceOptions, Method, Relief, ReliefFace, ShadingNormals};
use rilievo::surface::{Quad, Sphere, Surface, World};
use rilievo_render::bsdf::GlassTable;
use rilievo_render::film::tonemap::ToneMap;
use rilievo_render::light::{Environment, Light};
use rilievo_render::texture::ColourImage;
use rilievo_render::{Camera, Material, Scene, SceneParts};

use super::cache::{Cache, colour_of_file};
use super::file::{
    DisplacementEntry, EnvironmentEntry, Normals, QuadEntry, SceneFile, Shape, ShapeEntry,
    SphereEntry,
};
use super::load_map::{self, Face, Needs};
use super::materials::ImageKey;
use super::options::LoadOptions;
use super::relief_sphere::{LoadedSphereMap, SphereMapKey};
use super::syntax::{Located, hint};
use super::texture_memory::TextureMemory;
use crate::error::{Error, Result};
use crate::image::NormalOptions;

/// A scene with its maps, ready to be rendered.
#[derive(Debug)]
pub struct LoadedScene {
    /// The scene.
    pub scene: Scene,
    /// The maps its quads use, by name.
    pub maps: Vec<LoadedMap>,
    /// The maps its spheres use, by name.
    pub sphere_maps: Vec<LoadedSphereMap>,
    /// For each surface of the scene's world, the shape of the file that it belongs to.
    pub shape_of: Vec<u32>,
    /// How its picture is to be shown.
    pub tone_map: ToneMap,
    /// Files that its models brought with them: libraries of materials, buffers and images, sorted.
    pub files: Vec<PathBuf>,
    /// What was found in texture sets and assumed of them, what models hold that is not used: a
    /// line each.
    pub notes: Vec<String>,
}

/// A map of a scene.
#[derive(Clone, Debug)]
pub struct LoadedMap {
    /// Its name in the scene.
    pub name: String,
    /// Heights, pyramid and distance maps, shared by the shapes.
    pub relief: Arc<Relief>,
}

impl SceneFile {
    /// Reads the files that the scene's shapes need and builds the scene. A map, texture or baked
    /// file that no shape uses is not read.
    ///
    /// # Errors
    /// [`Error::Reference`] for a file that cannot be read; [`Error::Invalid`] for a name that is
    /// not there, shapes without area, a camera without direction; The place is that in the scene file.
    pub fn load(&self, options: &LoadOptions<'_>) -> Result<LoadedScene> {
        let (file, notes) = self.with_sets(options)?;
        let mut loaded = file.load_files(options)?;
        loaded.notes.splice(0..0, notes);
        Ok(loaded)
    }

    /// The same for a scene that names no texture sets.
    fn load_files(&self, options: &LoadOptions<'_>) -> Result<LoadedScene> {
        let camera = self.camera()?;
        let used = self.used_materials()?;
        let mut loader = Loader {
            file: self,
            options,
            maps: HashMap::new(),
            sphere_maps: HashMap::new(),
            images: HashMap::new(),
            glasses: options.cache.map(Cache::glasses).unwrap_or_default(),
            texture_memory: TextureMemory::default(),
            lamps: self.lights.clone(),
            files: Vec::new(),
            notes: Vec::new(),
        };
        loader.load_maps()?;
        let mut materials = Vec::new();
        for &index in &used.materials {
            materials.push(match index {
                Some(index) => loader.material(index, &mut Vec::new())?,
                None => Material::default(),
            });
        }
        let (mut surfaces, mut material_of) = (Vec::new(), Vec::new());
        let mut shape_of = Vec::new();
        for (shape, (entry, &material)) in self.shapes.iter().zip(&used.of_shape).enumerate() {
            let mut placed = loader.surfaces(entry, material, &mut materials)?;
            placed = match (&entry.instances, &entry.motion) {
                (Some(instances), motion) => loader.stand(placed, instances, motion.as_ref())?,
                (None, Some(motion)) => loader.set_off(placed, motion)?,
                (None, None) => placed,
            };
            for (surface, material) in placed {
                surfaces.push(surface);
                shape_of.push(shape as u32);
                material_of.push(material);
            }
        }
        loader.fit_images(&mut materials)?;
        let parts = SceneParts {
            world: World::new(surfaces),
            materials,
            material_of,
            camera,
            background: self.render.background,
            ambient: self.render.ambient,
            settings: self.render.settings,
        };
        let mut scene = Scene::new(parts)
            .map_err(|e| self.invalid(&(0..0), "scene", e.to_string(), String::new()))?
            .with_lamps(std::mem::take(&mut loader.lamps));
        if let Some(environment) = self.load_environment(options)? {
            scene = scene.with_environment(environment);
        }
        let mut maps: Vec<_> = (loader.maps.into_iter())
            .map(|(name, relief)| LoadedMap { name: name.to_owned(), relief })
            .collect();
        maps.sort_by(|a, b| a.name.cmp(&b.name));
        let mut sphere_maps: Vec<_> = loader.sphere_maps.into_values().collect();
        sphere_maps.sort_by_key(LoadedSphereMap::order);
        if let Some(cache) = options.cache {
            cache.keep_glasses(loader.glasses);
            cache.drop_judged();
        }
        let tone_map = self.render.tone_map;
        let (mut files, notes) = (loader.files, loader.notes);
        files.sort();
        files.dedup();
        Ok(LoadedScene { scene, maps, sphere_maps, shape_of, tone_map, files, notes })
    }

    fn load_environment(&self, options: &LoadOptions<'_>) -> Result<Option<Environment>> {
        let Some(EnvironmentEntry { file, placement }) = &self.environment else {
            return Ok(None);
        };
        let image = colour_of_file(self.beside(&file.value), options)
            .map_err(|e| self.referenced(file, "environment", e))?;
        Ok(Environment::new(&image, *placement))
    }

    /// The camera alone.
    ///
    /// # Errors
    /// [`Error::Invalid`] for one without direction; the place is that in the file.
    pub fn camera(&self) -> Result<Camera> {
        self.camera.build().map_err(|(e, at, [what, allowed])| {
            self.invalid(at, what, e.to_string(), allowed.to_owned())
        })
    }

    /// The materials that shapes name; the default one where they name none.
    fn used_materials(&self) -> Result<Used> {
        let mut used = Used { materials: Vec::new(), of_shape: Vec::new() };
        for shape in &self.shapes {
            let index = match &shape.material {
                Some(name) => Some(self.find(name, &self.materials, "material")?),
                None => None,
            };
            let at = used.materials.iter().position(|m| *m == index).unwrap_or_else(|| {
                used.materials.push(index);
                used.materials.len() - 1
            });
            used.of_shape.push(at as u32);
        }
        Ok(used)
    }

    /// The place of `name` in a list.
    pub(super) fn find<T>(
        &self,
        name: &Located<String>,
        all: &[(Located<String>, T)],
        what: &str,
    ) -> Result<usize> {
        all.iter().position(|(n, _)| n.value == name.value).ok_or_else(|| {
            let names: Vec<_> = all.iter().map(|(n, _)| n.value.as_str()).collect();
            let found = format!("\"{}\" is not there{}", name.value, hint(&name.value, &names));
            let allowed = match names.is_empty() {
                true => format!("none: the scene has no [{what}s.NAME]"),
                false => names.join(", "),
            };
            self.invalid(&name.at, what, found, allowed)
        })
    }

    pub(super) fn invalid(
        &self,
        at: &Range<usize>,
        what: &str,
        found: String,
        allowed: String,
    ) -> Error {
        Error::Invalid(Box::new(self.document().fault(at, what, found, allowed)))
    }
}

/// The materials in use, and which shape uses which.
struct Used {
    /// Places in the scene's list; none is the default material.
    materials: Vec<Option<usize>>,
    /// For each shape, a place in `materials`.
    of_shape: Vec<u32>,
}

/// Loads each file once.
pub(super) struct Loader<'a> {
    pub(super) file: &'a SceneFile,
    pub(super) options: &'a LoadOptions<'a>,
    pub(super) maps: HashMap<&'a str, Arc<Relief>>,
    pub(super) sphere_maps: HashMap<SphereMapKey<'a>, LoadedSphereMap>,
    pub(super) images: HashMap<ImageKey, Arc<ColourImage>>,
    pub(super) texture_memory: TextureMemory,
    /// Indices of refraction in use.
    pub(super) glasses: Vec<Arc<GlassTable>>,
    /// Lights that are no shapes: those of the scene, then those of models.
    pub(super) lamps: Vec<Light>,
    /// Files that models brought with them.
    pub(super) files: Vec<PathBuf>,
    /// What was not as files say, a line each.
    pub(super) notes: Vec<String>,
}

impl<'a> Loader<'a> {
    /// The method of a shape that asks for its `own`.
    pub(super) fn method(&self, own: Option<Method>) -> Method {
        self.options.method.or(own).unwrap_or(self.file.render.method)
    }

    /// Loads every map that a shape uses.
    fn load_maps(&mut self) -> Result<()> {
        self.load_sphere_maps()?;
        let mut needs: Vec<(usize, Needs)> = Vec::new();
        for shape in &self.file.shapes {
            let Some(entry) = shape.shape.displacement() else { continue };
            let index = self.file.find(&entry.map, &self.file.maps, "map")?;
            let face = match &shape.shape {
                Shape::Sphere(_) => continue,
                Shape::Quad(quad) if self.is_parallelogram(quad)? => {
                    let [c0, c1, _, c3] = quad.corners.value;
                    let tile = entry.displacement.tile;
                    let sides = [(c1 - c0).length() / tile[0], (c3 - c0).length() / tile[1]];
                    Some((self.method(quad.method), sides))
                }
                // Those of meshes are added when their size is known.
                Shape::Quad(_) | Shape::Mesh(_) => None,
            };
            let at = needs.iter().position(|(i, _)| *i == index).unwrap_or_else(|| {
                needs.push((index, Needs::default()));
                needs.len() - 1
            });
            if let Some((method, sides)) = face {
                needs[at].1.add(method, Face { sides, scale: entry.displacement.scale });
            }
        }
        for (index, needs) in needs {
            let (name, entry) = &self.file.maps[index];
            let relief = load_map::load(self.file, (&name.value, entry), &needs, self.options)?;
            self.maps.insert(&name.value, relief);
        }
        Ok(())
    }

    /// Whether a quad is displaced as one face; any other is two base triangles.
    fn is_parallelogram(&self, quad: &QuadEntry) -> Result<bool> {
        let flat = self.flat_quad(quad)?;
        let [c0, c1, c2, c3] = quad.corners.value;
        let near =
            (c2 - (c1 + c3 - c0)).length() <= 1e-9 * (c1 - c0).length().max((c3 - c0).length());
        Ok(flat.is_parallelogram() || near)
    }

    fn flat_quad(&self, quad: &QuadEntry) -> Result<Quad> {
        Quad::new(quad.corners.value, quad.one_sided).map_err(|e| {
            let allowed = "four corners that span an area, numbers up to 1e100";
            self.file.invalid(&quad.corners.at, "corners", e.to_string(), allowed.to_owned())
        })
    }

    /// The surfaces of a shape where it is, with the index of the material of each: `material`, or one
    /// of the shape's own file, which is added to `materials`.
    fn surfaces(
        &mut self,
        entry: &ShapeEntry,
        material: u32,
        materials: &mut Vec<Material>,
    ) -> Result<Vec<(Surface, u32)>> {
        let mut own = |from: Option<Material>| match from {
            Some(from) if entry.material.is_none() => {
                materials.push(from);
                materials.len() as u32 - 1
            }
            _ => material,
        };
        match &entry.shape {
            Shape::Mesh(mesh) => match &mesh.displacement {
                Some(displacement) => {
                    let parts = self.relief_mesh(mesh, displacement, entry.material.is_none())?;
                    Ok(parts.into_iter().map(|(surface, from)| (surface, own(from))).collect())
                }
                None if entry.material.is_none() => {
                    let parts = self.parts(mesh)?;
                    Ok(parts.into_iter().map(|(surface, from)| (surface, own(from))).collect())
                }
                None => Ok(vec![(self.surface(&entry.shape)?, material)]),
            },
            shape => Ok(vec![(self.surface(shape)?, material)]),
        }
    }

    fn surface(&mut self, shape: &Shape) -> Result<Surface> {
        match shape {
            Shape::Quad(quad) => match &quad.displacement {
                None => Ok(self.flat_quad(quad)?.into()),
                Some(entry) if self.is_parallelogram(quad)? => Ok(self.face(quad, entry)?.into()),
                Some(entry) => Ok(self.relief_quad(quad, entry)?.into()),
            },
            Shape::Sphere(sphere) => match &sphere.displacement {
                None => {
                    let SphereEntry { center, radius, .. } = sphere;
                    let sphere = Sphere::new(*center, radius.value).map_err(|e| {
                        let allowed = "numbers up to 1e100, a radius from 1e-100".to_owned();
                        self.file.invalid(&radius.at, "sphere", e.to_string(), allowed)
                    })?;
                    Ok(sphere.into())
                }
                Some(entry) => Ok(self.relief_sphere(sphere, entry)?.into()),
            },
            Shape::Mesh(mesh) => {
                let data = self.model(mesh)?.mesh;
                Ok(self.placed(data, &mesh.file, mesh.world_from_object.as_ref())?.into())
            }
        }
    }

    fn face(&self, quad: &QuadEntry, entry: &DisplacementEntry) -> Result<ReliefFace> {
        let relief = Arc::clone(&self.maps[entry.map.value.as_str()]);
        let axis = relief.heights().x();
        let options = FaceOptions {
            displacement: entry.displacement,
            method: self.method(quad.method),
            normals: self.normals(&entry.normals, (axis.lattice(), axis.wrap()))?,
            closed: quad.closed,
            one_sided: quad.one_sided,
            simd: self.options.simd,
        };
        ReliefFace::new(quad.corners.value, relief, options).map_err(|e| {
            let at = match e {
                FaceError::NotParallelogram { .. } | FaceError::Degenerate => &quad.corners.at,
                _ => &entry.at,
            };
            self.file.invalid(at, "displacement", e.to_string(), String::new())
        })
    }

    pub(super) fn normals(
        &self,
        normals: &Normals,
        (lattice, wrap): (Lattice, Wrap),
    ) -> Result<ShadingNormals> {
        Ok(match normals {
            Normals::Exact => ShadingNormals::Exact,
            Normals::Smooth => ShadingNormals::Smooth,
            Normals::Published => ShadingNormals::Published,
            Normals::WrongMetric => ShadingNormals::WrongMetric,
            Normals::File { file, convention } => {
                let convention = convention.unwrap_or(NormalConvention::OpenGl);
                let options = NormalOptions { convention, lattice, wrap };
                let (path, cache) = (self.file.beside(&file.value), self.options.cache);
                if let Some(map) = cache.and_then(|cache| cache.normals(&path, &options)) {
                    return Ok(ShadingNormals::Map(map));
                }
                let map = options.read(&path, &self.options.limits);
                let map = Arc::new(map.map_err(|e| self.file.referenced(file, "normals", e))?);
                if let Some(cache) = cache {
                    cache.keep_normals(&path, &options, &map);
                }
                ShadingNormals::Map(map)
            }
        })
    }
}

//! [`Scene`]: surfaces, materials, lights and a camera, checked once and never changed.

pub mod camera;
pub mod material;
pub mod model;
pub mod settings;

pub use camera::{Camera, CameraError, CameraParts, Lens, Pose, Projection};
pub use material::{Material, MaterialError, Reflectance};
pub use model::{Conductor, Diffuse, Glass, Metal, Mix, Model, Principled, ThinGlass};
pub use settings::{RenderSettings, SettingsError};

use std::sync::{Arc, OnceLock};

use glam::DVec3;
use rilievo::surface::World;

use crate::colour::{Rgb, is_radiance};
use crate::level_of_detail::LevelOfDetail;
use crate::light::{Environment, Light, Lighting};
use crate::texture::TileCache;

/// What a scene is made of.
#[derive(Debug)]
pub struct SceneParts {
    /// The surfaces.
    pub world: World,
    /// The materials.
    pub materials: Vec<Material>,
    /// For each surface of `world`, in order, its index in `materials`.
    pub material_of: Vec<u32>,
    /// The camera.
    pub camera: Camera,
    /// Radiance seen where a ray meets nothing, beside that of an environment. It lights diffuse
    /// surfaces through diffuse bounces only.
    pub background: Rgb,
    /// Radiance added to every surface, times its diffuse reflectance.
    pub ambient: Rgb,
    /// How to render.
    pub settings: RenderSettings,
}

/// Why a scene was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SceneError {
    /// `material_of` does not have one entry per surface.
    #[error("{surfaces} surfaces but {found} material indices")]
    MaterialCount {
        /// Surfaces in the world.
        surfaces: usize,
        /// Entries given.
        found: usize,
    },
    /// A surface names a material that does not exist.
    #[error("surface {surface} names material {found}, but there are {materials}")]
    NoSuchMaterial {
        /// Index of the surface.
        surface: usize,
        /// Index of the material it names.
        found: u32,
        /// Number of materials.
        materials: usize,
    },
    /// A material is out of range.
    #[error("material {index}: {error}")]
    Material {
        /// Index of the material.
        index: usize,
        /// What is wrong with it.
        error: MaterialError,
    },
    /// `background` or `ambient` has a channel that is negative, NaN or infinite.
    #[error("{part} is [{}, {}, {}]; channels must be finite and at least 0", found.x, found.y, found.z)]
    Radiance {
        /// `background` or `ambient`.
        part: &'static str,
        /// The value found.
        found: Rgb,
    },
    /// The settings are out of range.
    #[error(transparent)]
    Settings(#[from] SettingsError),
}

/// A scene ready to be traced: every index resolves and every number is in range.
#[derive(Debug)]
pub struct Scene {
    parts: SceneParts,
    /// Of surfaces, in their order; then lamps.
    lights: Vec<Light>,
    /// Lights that are surfaces.
    of_surfaces: usize,
    environment: Option<Arc<Environment>>,
    /// Made when it is first asked for.
    lighting: OnceLock<Lighting>,
    /// Made when it is first asked for; nothing if no surface has levels.
    level_of_detail: OnceLock<Option<LevelOfDetail>>,
    /// What brings in the tiles of textures, each once.
    caches: Vec<Arc<TileCache>>,
}

impl Scene {
    /// Checks `parts` against each other and finds the lights.
    ///
    /// # Errors
    /// [`SceneError`] names the first part that does not fit.
    pub fn new(parts: SceneParts) -> Result<Self, SceneError> {
        let surfaces = parts.world.surfaces();
        if parts.material_of.len() != surfaces.len() {
            let (surfaces, found) = (surfaces.len(), parts.material_of.len());
            return Err(SceneError::MaterialCount { surfaces, found });
        }
        let materials = parts.materials.len();
        let names = parts.material_of.iter().enumerate();
        if let Some((surface, &found)) = names.clone().find(|&(_, &m)| m as usize >= materials) {
            return Err(SceneError::NoSuchMaterial { surface, found, materials });
        }
        for (index, material) in parts.materials.iter().enumerate() {
            material.check().map_err(|error| SceneError::Material { index, error })?;
        }
        for (part, found) in [("background", parts.background), ("ambient", parts.ambient)] {
            if !is_radiance(found) {
                return Err(SceneError::Radiance { part, found });
            }
        }
        parts.settings.check()?;
        let lights: Vec<_> = names
            .flat_map(|(index, &m)| {
                let emitted = parts.materials[m as usize].even_emission();
                Light::of_surface(&surfaces[index], index as u32, emitted)
            })
            .collect();
        let of_surfaces = lights.len();
        let (lighting, level_of_detail) = (OnceLock::new(), OnceLock::new());
        let mut caches: Vec<Arc<TileCache>> = Vec::new();
        let textures = parts.materials.iter().flat_map(Material::textures);
        for cache in textures.filter_map(|texture| texture.image.cache()) {
            if !caches.iter().any(|known| Arc::ptr_eq(known, cache)) {
                caches.push(Arc::clone(cache));
            }
        }
        Ok(Self {
            parts,
            lights,
            of_surfaces,
            environment: None,
            lighting,
            level_of_detail,
            caches,
        })
    }

    /// The same scene with these lights that are no surfaces beside those that are. Of others, quads
    /// and spheres and triangles, only the surfaces of the world count.
    #[must_use]
    pub fn with_lamps(mut self, lamps: Vec<Light>) -> Self {
        self.lights.truncate(self.of_surfaces);
        self.lights.extend(lamps.into_iter().filter(|lamp| lamp.surface().is_none()));
        self.lighting = OnceLock::new();
        self
    }

    /// The same scene with light from all around.
    #[must_use]
    pub fn with_environment(mut self, environment: Environment) -> Self {
        self.environment = Some(Arc::new(environment));
        self.lighting = OnceLock::new();
        self
    }

    /// The same scene under other settings.
    ///
    /// # Errors
    /// [`SettingsError`] names the first count that is out of range.
    pub fn with_settings(mut self, settings: RenderSettings) -> Result<Self, SettingsError> {
        settings.check()?;
        self.parts.settings = settings;
        Ok(self)
    }

    /// The same scene seen by another camera.
    #[must_use]
    pub fn with_camera(mut self, camera: Camera) -> Self {
        self.parts.camera = camera;
        self
    }

    /// The surfaces.
    pub fn world(&self) -> &World {
        &self.parts.world
    }

    /// Whether pictures depend on when they are taken: the camera moves, or a surface.
    pub fn moves(&self) -> bool {
        self.camera().moves() || self.world().moves()
    }

    /// The materials.
    pub fn materials(&self) -> &[Material] {
        &self.parts.materials
    }

    /// The material of a surface, by the `surface` of a hit.
    ///
    /// # Panics
    /// If the world has no such surface.
    pub fn material(&self, surface: u32) -> &Material {
        &self.parts.materials[self.parts.material_of[surface as usize] as usize]
    }

    /// Why a tile of a texture could not be read, if one could not: what was rendered since shows it
    /// black.
    pub fn texture_failure(&self) -> Option<&str> {
        self.caches.iter().find_map(|cache| cache.failure())
    }

    /// The lights that the paper's integrator samples, in the order of their surfaces; lamps last.
    pub fn lights(&self) -> &[Light] {
        &self.lights
    }

    /// Whether a surface is among the lights that are sampled.
    pub(crate) fn is_light(&self, surface: u32) -> bool {
        let lights = &self.lights[..self.of_surfaces];
        lights.binary_search_by_key(&Some(surface), Light::surface).is_ok()
    }

    /// The light from all around, if there is any.
    pub fn environment(&self) -> Option<&Environment> {
        self.environment.as_deref()
    }

    /// All light, as the path integrator samples it.
    pub(crate) fn lighting(&self) -> &Lighting {
        self.lighting.get_or_init(|| {
            let material = |surface| self.material(surface);
            let lamps = &self.lights[self.of_surfaces..];
            Lighting::new(self.world(), material, lamps, self.environment.clone())
        })
    }

    /// Coarser worlds, if the settings ask for them and any surface has levels.
    pub(crate) fn level_of_detail(&self) -> Option<&LevelOfDetail> {
        if self.settings().lod <= 0.0 {
            return None;
        }
        let build = || LevelOfDetail::build(self.world(), |surface| self.material(surface).emits());
        self.level_of_detail.get_or_init(build).as_ref()
    }

    /// Radiance that comes against `direction`, any length but zero, where nothing is met, without
    /// suns.
    pub(crate) fn sky(&self, direction: DVec3) -> Rgb {
        match &self.environment {
            None => self.parts.background,
            Some(environment) => {
                self.parts.background + environment.radiance(direction.normalize())
            }
        }
    }

    /// The camera.
    pub fn camera(&self) -> &Camera {
        &self.parts.camera
    }

    /// Radiance seen where a ray meets nothing.
    pub fn background(&self) -> Rgb {
        self.parts.background
    }

    /// Radiance added to every surface, times its diffuse reflectance.
    pub fn ambient(&self) -> Rgb {
        self.parts.ambient
    }

    /// How to render.
    pub fn settings(&self) -> &RenderSettings {
        &self.parts.settings
    }
}

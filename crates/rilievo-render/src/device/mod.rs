//! [`SceneWords`]: what of a scene its integrators ask for beside surfaces, in words of 32 bits: for shaders that
//! shade where they trace.
//!
//! All lies in one run of words: single words first, by the names of [`HEAD`], then lists, whose places stand among
//! them. Numbers are floats; points are sums of two floats, relative to an anchor in the middle of the world, so that
//! they keep 48 bits. Tables that the CPU makes (albedos of rough facets, the tree over lights, means of images,
//! distributions of the sky) are given as they are: nothing is worked out twice.
//!
//! What no shader knows is refused by name ([`Uncovered`]); such a scene is traced in waves and shaded by the CPU.

mod material;
mod texture;

use std::collections::HashMap;
use std::fmt;
use std::sync::Arc;

use glam::DVec3;

use crate::integrator::{Integrator, path_spread};
use crate::light::{write_lighting, write_lights};
use crate::sampler::SamplerKind;
use crate::scene::{Material, Scene};
use material::Materials;

/// Stands for a place of what is not there.
pub const NOTHING: u32 = u32::MAX;

/// Names of the single words; a place without a name belongs to the one before.
pub const HEAD: [&str; 32] = [
    "INTEGRATOR",
    "SHADOW_SAMPLES",
    "GLOSSY_SAMPLES",
    "DIFFUSE_SAMPLES",
    "MAX_DEPTH",
    "SAMPLER",
    "CLAMP_AT",
    "SPREAD",
    "BACKGROUND",
    "",
    "",
    "AMBIENT",
    "",
    "",
    "LIGHTS",
    "FIRST_LIGHT",
    "FIRST_SURFACE",
    "CHOOSES",
    "GROUPS",
    "SUNS",
    "FIRST_SUN",
    "SKY",
    "TREE",
    "WAYS",
    "FIRST_DRAWN",
    "GLOSS_TABLE",
    "SHEEN_TABLE",
    "SRGB_TABLE",
    "TREE_NODES",
    "",
    "",
    "",
];

/// Which parts of the integrators a scene asks for: a shader that leaves the others out is compiled sooner.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Parts {
    /// Paths, rather than the paper's trees of rays or first hits.
    pub path: bool,
    /// Images on surfaces.
    pub images: bool,
    /// Maps of normals.
    pub normals: bool,
    /// An image of the sky.
    pub sky: bool,
    /// Metals.
    pub metals: bool,
    /// Clear bodies and sheets.
    pub glass: bool,
    /// Principled surfaces.
    pub principled: bool,
    /// Mixes of two materials.
    pub mixes: bool,
    /// Emitters without a closed form, which rays are aimed at.
    pub emitters: bool,
    /// Jittered numbers for paths, whose permutations take a shader long to compile.
    pub jittered: bool,
}

/// What is said of a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SurfaceWords {
    /// Place of its material.
    pub material: u32,
    /// Whether it is one of the lights of the paper's integrator.
    pub is_light: bool,
    /// The first of the lights that paths draw which it is, if it is any.
    pub drawn: Option<u32>,
}

/// A scene in words.
#[derive(Clone, Debug)]
pub struct SceneWords {
    /// The words; [`HEAD`] begins them. What is said of surfaces is for a tracer to append.
    pub words: Vec<u32>,
    /// Surface by surface.
    pub surfaces: Vec<SurfaceWords>,
    /// What the integrator needs.
    pub parts: Parts,
}

/// The part of a scene that no shader knows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Uncovered(pub &'static str);

impl fmt::Display for Uncovered {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.0)
    }
}

/// Paths of a pixel that a shader counts.
const MOST_PATHS: f64 = (1_u64 << 31) as f64;

/// Bytes that images may take.
const MOST_BYTES: u64 = 1 << 30;

impl SceneWords {
    /// Those of `scene`, in coordinates relative to `anchor`.
    ///
    /// # Errors
    /// [`Uncovered`] names what no shader knows.
    pub fn new(scene: &Scene, anchor: DVec3) -> Result<Self, Uncovered> {
        check(scene)?;
        let settings = scene.settings();
        let mut words = Words(vec![0; HEAD.len()]);
        words.set_settings(scene);
        words.set_colour("BACKGROUND", scene.background());
        words.set_colour("AMBIENT", scene.ambient());

        let path = settings.integrator == Integrator::Path;
        let (sky, jittered) =
            (scene.environment().is_some(), path && settings.sampler == SamplerKind::Jittered);
        let mut parts = Parts { path, sky, jittered, ..Parts::default() };
        let mut materials = Materials::default();
        let count = scene.world().surfaces().len() as u32;
        let places: Vec<u32> = (0..count)
            .map(|surface| materials.place(&mut words, &mut parts, scene.material(surface)))
            .collect::<Result<_, _>>()?;
        let lights = scene.lights();
        let first = write_lights(&mut words, lights, anchor);
        words.set("LIGHTS", lights.len() as u32);
        words.set("FIRST_LIGHT", first);
        let drawn = write_lighting(&mut words, &mut parts, scene, anchor)?;
        let surfaces = (0..count).zip(places).zip(drawn);
        let surfaces = surfaces.map(|((surface, material), drawn)| SurfaceWords {
            material,
            is_light: scene.is_light(surface),
            drawn,
        });
        let surfaces = surfaces.collect();
        Ok(Self { words: words.0, surfaces, parts })
    }

    /// Follows a scene that differs in camera and settings alone from that of these words; false, and nothing is
    /// changed, where more of them depends on what has changed.
    ///
    /// # Errors
    /// As [`SceneWords::new`].
    pub fn follow(&mut self, scene: &Scene) -> Result<bool, Uncovered> {
        check(scene)?;
        let settings = scene.settings();
        let path = settings.integrator == Integrator::Path;
        let jittered = path && settings.sampler == SamplerKind::Jittered;
        if (path, jittered) != (self.parts.path, self.parts.jittered) {
            return Ok(false);
        }
        let mut words = Words(std::mem::take(&mut self.words));
        words.set_settings(scene);
        self.words = words.0;
        Ok(true)
    }
}

/// What concerns the scene as a whole.
fn check(scene: &Scene) -> Result<(), Uncovered> {
    let settings = scene.settings();
    if settings.lod > 0.0 {
        return Err(Uncovered("level of detail"));
    }
    let textures = scene.materials().iter().flat_map(Material::textures);
    let images: HashMap<usize, u64> = textures
        .map(|texture| &texture.image)
        .map(|image| (Arc::as_ptr(image).addr(), image.bytes() + image.coarser_bytes()))
        .collect();
    // A texel takes at most twice its bytes.
    if images.values().sum::<u64>() > MOST_BYTES / 2 {
        return Err(Uncovered("images of more than half a gibibyte"));
    }
    if settings.integrator != Integrator::Distributed {
        return Ok(());
    }
    let splits = [settings.glossy_samples, settings.diffuse_samples].map(f64::from);
    let first = splits[0].max(1.0) + splits[1];
    let both = settings.diffuse_samples > 0;
    // At later hits a ray goes on as one reflection and one bounce.
    let later = if both { f64::from(settings.max_depth).exp2() } else { 1.0 };
    let most = f64::from(settings.shadow_samples).max(first);
    match f64::from(settings.samples) * first * later * most < MOST_PATHS {
        true => Ok(()),
        false => Err(Uncovered("a tree of so many rays for one pixel")),
    }
}

/// A number as a float, within the floats that are finite.
pub(crate) fn single(x: f64) -> f32 {
    x.clamp(f64::from(f32::MIN), f64::from(f32::MAX)) as f32
}

/// Words that grow.
pub(crate) struct Words(Vec<u32>);

impl Words {
    /// The place of the next word.
    pub(crate) fn place(&self) -> u32 {
        self.0.len() as u32
    }

    pub(crate) fn push(&mut self, word: u32) {
        self.0.push(word);
    }

    /// Sets a single word by its name.
    pub(crate) fn set(&mut self, name: &str, word: u32) {
        if let Some(at) = HEAD.iter().position(|known| *known == name) {
            self.0[at] = word;
        }
    }

    /// Sets what camera and settings say.
    fn set_settings(&mut self, scene: &Scene) {
        let settings = scene.settings();
        let integrator = match settings.integrator {
            Integrator::Aov => 0,
            Integrator::Distributed => 1,
            Integrator::Path => 2,
        };
        let sampler = match settings.sampler {
            SamplerKind::Sobol => 0,
            SamplerKind::Independent => 1,
            SamplerKind::Jittered => 2,
        };
        let clamp = if settings.clamp > 0.0 { settings.clamp } else { f64::MAX };
        self.set("INTEGRATOR", integrator);
        self.set("SHADOW_SAMPLES", settings.shadow_samples);
        self.set("GLOSSY_SAMPLES", settings.glossy_samples);
        self.set("DIFFUSE_SAMPLES", settings.diffuse_samples);
        self.set("MAX_DEPTH", settings.max_depth);
        self.set("SAMPLER", sampler);
        self.set("CLAMP_AT", single(clamp).to_bits());
        self.set("SPREAD", single(path_spread(scene)).to_bits());
    }

    fn set_colour(&mut self, name: &str, colour: DVec3) {
        if let Some(at) = HEAD.iter().position(|known| *known == name) {
            for (word, channel) in self.0[at..].iter_mut().zip(colour.to_array()) {
                *word = single(channel).to_bits();
            }
        }
    }

    pub(crate) fn set_at(&mut self, place: u32, word: u32) {
        self.0[place as usize] = word;
    }

    pub(crate) fn float(&mut self, x: f64) {
        self.0.push(single(x).to_bits());
    }

    /// Three floats.
    pub(crate) fn triple(&mut self, v: DVec3) {
        v.to_array().into_iter().for_each(|x| self.float(x));
    }

    /// Components as sums of two floats.
    pub(crate) fn point(&mut self, v: DVec3) {
        for x in v.to_array() {
            let high = single(x);
            self.0.push(high.to_bits());
            self.float(x - f64::from(high));
        }
    }

    /// Fills up to a length counted from `place`.
    pub(crate) fn fill(&mut self, place: u32, words: u32) {
        self.0.resize((place + words) as usize, 0);
    }
}

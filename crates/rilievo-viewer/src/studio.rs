//! [`Studio`]: scenes in memory, and what was read for them.
//!
//! It lives on one thread at a time and knows neither window nor clock. Loading again keeps what did not
//! change ([`Cache`]); strokes of the brush change the kept heights in place.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use glam::DVec2;
use rilievo::Counters;
use rilievo::relief::{CubeRelief, Displacement, Method, Relief};
use rilievo::surface::Surface;
use rilievo_io::Limits;
use rilievo_io::scene::{Cache, KeptMap, LoadOptions, LoadedScene, SceneFile};
use rilievo_render::film::tonemap::ToneMap;
use rilievo_render::{RenderSettings, Scene};

use crate::brush::{Dab, Stroke};
use crate::histogram::Histogram;
use crate::session::Facts;

/// Most bytes that strokes keep to be taken back; the oldest are forgotten.
const MOST_STROKES: u64 = 256 << 20;

/// What lies under a pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Pick {
    /// The surface of the world, and the shape of the file it belongs to.
    pub surface: u32,
    /// The shape of the file.
    pub shape: u32,
    /// Where it was met.
    pub position: glam::DVec3,
    /// Parameters of the surface.
    pub uv: DVec2,
    /// Of the map, 0 where there is none.
    pub height: f64,
    /// Unit length, that of the surface itself.
    pub normal: glam::DVec3,
    /// What the ray looked at.
    pub work: Counters,
    /// The place on the map, in repetitions, and samples of the map along u and v, if it has one that
    /// can be painted.
    pub map: Option<(DVec2, [u32; 2])>,
}

/// A touch of the brush on a shape of the shown scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touch {
    /// The stroke that it is part of.
    pub stroke: u32,
    /// The surface of the world that is touched.
    pub surface: u32,
    /// What is done.
    pub dab: Dab,
}

/// What is done to heights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Painting {
    /// A touch of the brush.
    Touch(Touch),
    /// A stroke is taken back, or done again.
    Swap(u32),
}

impl Painting {
    /// The stroke that is painted, or taken back.
    fn stroke(&self) -> u32 {
        match self {
            Self::Touch(touch) => touch.stroke,
            Self::Swap(stroke) => *stroke,
        }
    }
}

/// A rectangle of a map that was painted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Edit {
    /// The map.
    pub map: KeptMap,
    /// Columns and rows.
    pub samples: [Range<u32>; 2],
}

/// Why something could not be painted.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PaintError {
    /// No map, or one that was made from another.
    #[error(
        "nothing that can be painted: take a shape that is displaced by a map as it is, not one matched at seams"
    )]
    NoMap,
    /// The stroke was too long ago.
    #[error("this stroke was too long ago to be taken back")]
    Forgotten,
    /// A height would be beyond all bounds.
    #[error(transparent)]
    Map(#[from] rilievo::map::HeightMapError),
}

/// A scene as it was loaded.
#[derive(Debug)]
pub struct Shown {
    /// What is rendered.
    pub scene: Scene,
    /// How it asks to be rendered; the scene itself may hold other settings.
    pub settings: RenderSettings,
    /// For each surface, its shape in the file.
    pub shape_of: Vec<u32>,
    /// How the picture is shown.
    pub tone_map: ToneMap,
    /// What loading had to say, a line each.
    pub notes: Vec<String>,
    /// For each surface, the map that its own was resampled from, if it was.
    sources: Vec<Option<Arc<Relief>>>,
}

/// What was read, and what was painted on it.
#[derive(Debug, Default)]
pub struct Studio {
    cache: Cache,
    limits: Limits,
    strokes: BTreeMap<u32, (KeptMap, Stroke)>,
}

impl Studio {
    /// The scene of a path, as `rilievo render` would take it, and whether it presents what is no scene.
    ///
    /// # Errors
    /// As [`SceneFile::present`].
    pub fn open(&self, path: &Path) -> rilievo_io::Result<(SceneFile, bool)> {
        let file = SceneFile::present_into(path, &self.limits, Some(&self.cache))?;
        let bare = file.path() != path;
        Ok((file, bare))
    }

    /// Loads a scene; `method` goes before all its own.
    ///
    /// # Errors
    /// As [`SceneFile::load`].
    pub fn load(&self, file: &SceneFile, method: Option<Method>) -> rilievo_io::Result<Shown> {
        let options = LoadOptions {
            limits: self.limits,
            method,
            cache: Some(&self.cache),
            ..LoadOptions::default()
        };
        let LoadedScene { scene, shape_of, tone_map, notes, .. } = file.load(&options)?;
        let settings = *scene.settings();
        let source = |surface| sphere_of(surface).and_then(|cube| self.cache.source_of(cube));
        let sources = scene.world().surfaces().iter().map(source).collect();
        Ok(Shown { scene, settings, shape_of, tone_map, notes, sources })
    }

    /// Which map heights are, if they are one that can be painted.
    pub fn name_of(&self, relief: &Arc<Relief>) -> Option<KeptMap> {
        self.cache.map_of(relief)
    }

    /// The heights of a map as they are now.
    pub fn map_named(&self, map: &KeptMap) -> Option<Arc<Relief>> {
        self.cache.heights_of(map)
    }

    /// Changes heights that `shown` uses, which is given away so that they need not be copied; it has to be
    /// loaded again. What was changed is added to `edits`.
    ///
    /// # Errors
    /// The first [`PaintError`]; what it is about is as it was.
    pub fn paint(
        &mut self,
        shown: Option<Shown>,
        paintings: &[Painting],
        edits: &mut Vec<Edit>,
    ) -> Result<(), PaintError> {
        let mut result = Ok(());
        let mut found = Vec::new();
        for painting in paintings {
            let map = match painting {
                Painting::Touch(touch) => {
                    let relief = shown.as_ref().and_then(|shown| shown.map_of(touch.surface));
                    relief.and_then(|relief| self.cache.map_of(relief)).ok_or(PaintError::NoMap)
                }
                Painting::Swap(stroke) => {
                    let known = self.strokes.get(stroke).ok_or(PaintError::Forgotten);
                    known.map(|(map, _)| map.clone())
                }
            };
            match map {
                Ok(map) => found.push((map, painting)),
                Err(e) => result = result.and(Err(e)),
            }
        }
        drop(shown);
        for (map, painting) in found {
            let number = painting.stroke();
            let new = || (map.clone(), Stroke::default());
            let (_, stroke) = match painting {
                Painting::Touch(_) => self.strokes.entry(number).or_insert_with(new),
                Painting::Swap(_) => match self.strokes.get_mut(&number) {
                    Some(known) => known,
                    None => continue,
                },
            };
            let before = stroke.areas().count();
            let (done, first) = match painting {
                Painting::Touch(Touch { dab, .. }) => {
                    (self.cache.edit(&map, |relief| stroke.dab(relief, dab)), before)
                }
                Painting::Swap(_) => (self.cache.edit(&map, |relief| stroke.swap(relief)), 0),
            };
            let areas = stroke.areas().skip(first);
            edits.extend(areas.map(|samples| Edit { map: map.clone(), samples }));
            let done = done.ok_or(PaintError::NoMap).and_then(|done| Ok(done?));
            result = result.and(done);
        }
        self.forget_old_strokes();
        result
    }

    fn forget_old_strokes(&mut self) {
        let mut bytes: u64 = self.strokes.values().map(|(_, stroke)| stroke.bytes()).sum();
        while bytes > MOST_STROKES
            && self.strokes.len() > 1
            && let Some((_, (_, stroke))) = self.strokes.pop_first()
        {
            bytes -= stroke.bytes();
        }
    }
}

impl Shown {
    /// The facts that the text need not say.
    pub fn facts(&self) -> Facts {
        let mut displacements: Vec<(usize, Displacement)> = Vec::new();
        let mut corners = Vec::new();
        for (surface, &shape) in self.scene.world().surfaces().iter().zip(&self.shape_of) {
            let shape = shape as usize;
            if let Some(displacement) = displacement_of(surface)
                && displacements.iter().all(|(known, _)| *known != shape)
            {
                displacements.push((shape, displacement));
                if let Surface::Face(face) = surface {
                    let [corner, u, v, _] = face.frame();
                    corners.push((shape, [corner, corner + u, corner + u + v, corner + v]));
                }
            }
        }
        let surfaces = self.scene.world().surfaces().iter();
        let mut walks = surfaces.filter_map(|surface| {
            Some((method_of(surface)?, relief_of(surface)?.pyramid().layout()))
        });
        Facts {
            walk: walks.next(),
            displacements,
            corners,
            camera: self.scene.camera().parts(),
            settings: self.settings,
            tone_map: self.tone_map,
        }
    }

    /// The map that a shape of the file shows; of a sphere the one that its own was resampled from.
    pub fn relief(&self, shape: usize) -> Option<&Arc<Relief>> {
        let surfaces = (0..).zip(&self.shape_of);
        surfaces
            .filter(|&(_, &of)| of as usize == shape)
            .find_map(|(surface, _)| self.map_of(surface))
    }

    /// The map that a surface shows; of a sphere the one that its own was resampled from.
    fn map_of(&self, surface: u32) -> Option<&Arc<Relief>> {
        let index = surface as usize;
        let own = self.scene.world().surfaces().get(index).and_then(relief_of);
        own.or_else(|| self.sources.get(index)?.as_ref())
    }

    /// How often heights occur on the map of a shape.
    pub fn histogram(&self, shape: usize) -> Option<Histogram> {
        self.relief(shape).map(|relief| Histogram::of(relief.heights()))
    }

    /// What lies under a point of the picture, 0 to 1 to the right and down.
    pub fn pick(&self, at: DVec2) -> Option<Pick> {
        let camera = self.scene.camera();
        let [width, height] = camera.resolution().map(f64::from);
        let ray = camera.ray(at.x * width, at.y * height);
        let mut work = Counters::default();
        let hit = self.scene.world().closest(&ray, &mut work)?;
        let surface = &self.scene.world().surfaces()[hit.surface as usize];
        let map = self.map_of(hit.surface).zip(displacement_of(surface)).map(|(relief, laid)| {
            let size = [relief.heights().width(), relief.heights().height()];
            (hit.uv * DVec2::from(laid.tile) + DVec2::from(laid.shift), size)
        });
        Some(Pick {
            surface: hit.surface,
            shape: self.shape_of[hit.surface as usize],
            position: hit.position,
            uv: hit.uv,
            height: hit.height,
            normal: hit.geometric_normal,
            work,
            map,
        })
    }
}

/// The heights of a surface, if they are those of a map as it is.
fn relief_of(surface: &Surface) -> Option<&Arc<Relief>> {
    match surface {
        Surface::Face(face) => Some(face.relief()),
        Surface::ReliefMesh(mesh) => Some(mesh.relief()),
        Surface::Instance(instance) => relief_of(instance.prototype()),
        Surface::Moving(moving) => relief_of(moving.prototype()),
        Surface::Quad(_) | Surface::Sphere(_) | Surface::Mesh(_) | Surface::ReliefSphere(_) => None,
    }
}

/// The map of a displaced sphere, resampled.
fn sphere_of(surface: &Surface) -> Option<&Arc<CubeRelief>> {
    match surface {
        Surface::ReliefSphere(sphere) => Some(sphere.relief()),
        Surface::Instance(instance) => sphere_of(instance.prototype()),
        Surface::Moving(moving) => sphere_of(moving.prototype()),
        Surface::Face(_)
        | Surface::ReliefMesh(_)
        | Surface::Quad(_)
        | Surface::Sphere(_)
        | Surface::Mesh(_) => None,
    }
}

/// How the map of a surface is laid on it.
fn displacement_of(surface: &Surface) -> Option<Displacement> {
    match surface {
        Surface::Face(face) => Some(face.options().displacement),
        Surface::ReliefMesh(mesh) => Some(mesh.options().displacement),
        Surface::ReliefSphere(sphere) => Some(sphere.options().displacement),
        Surface::Instance(instance) => displacement_of(instance.prototype()),
        Surface::Moving(moving) => displacement_of(moving.prototype()),
        Surface::Quad(_) | Surface::Sphere(_) | Surface::Mesh(_) => None,
    }
}

/// How the relief of a surface is walked, if it shows a map as it is.
fn method_of(surface: &Surface) -> Option<Method> {
    match surface {
        Surface::Face(face) => Some(face.options().method),
        Surface::ReliefMesh(mesh) => Some(mesh.options().method),
        Surface::Instance(instance) => method_of(instance.prototype()),
        Surface::Moving(moving) => method_of(moving.prototype()),
        Surface::Quad(_) | Surface::Sphere(_) | Surface::Mesh(_) | Surface::ReliefSphere(_) => None,
    }
}

#[cfg(test)]
mod tests;

//! Making the worlds: a chain of levels for each map, and for each level the surfaces that show it.
//!
//! Surfaces of one scene have cells of many sizes. The chain of worlds counts from the finest of them: level `k` is for
//! footprints `2^k` times as wide, and shows each relief at the level of its own map that comes nearest to that.
//! What surfaces share they share at every level: maps, and prototypes of instances. Surfaces without relief are
//! the same at all levels, and so are those that emit, which the lighting knows by their full shape.

use std::collections::HashMap;
use std::sync::Arc;

use rilievo::map::LostSlopes;
use rilievo::relief::{
    CubeRelief, FaceOptions, MeshOptions, Method, Relief, ReliefSphere, ShadingNormals,
    SphereOptions,
};
use rilievo::surface::{Instance, MovingInstance, Surface, World};

use super::{Level, LevelOfDetail, Lost};

/// The levels of a map, finest first.
type Maps = Vec<(Arc<Relief>, Arc<LostSlopes>)>;

/// The levels of a map around a sphere.
type Cubes = Vec<(Arc<CubeRelief>, Arc<[LostSlopes; 6]>)>;

/// A surface that others show, and what it lost.
type Prototype = (Arc<Surface>, Lost);

/// What was made so far, by where the full one lies in memory.
#[derive(Default)]
struct Made {
    maps: HashMap<*const Relief, Arc<Maps>>,
    cubes: HashMap<*const CubeRelief, Arc<Cubes>>,
    /// Prototypes, by the level of their map as well.
    prototypes: HashMap<(*const Surface, usize), Option<Prototype>>,
}

impl LevelOfDetail {
    /// The levels of a world in which `stays` names the surfaces that are to stay as they are; none if nothing
    /// has levels.
    pub fn build(full: &World, stays: impl Fn(u32) -> bool) -> Option<Self> {
        let mut made = Made::default();
        // Width of cells and number of levels, for each surface that has any.
        let all: Vec<Option<(f64, usize)>> = (0..)
            .zip(full.surfaces())
            .map(|(index, surface)| {
                let cell = cell_width(surface).filter(|cell| cell.is_finite() && *cell > 0.0)?;
                (!stays(index)).then_some((cell, made.levels_of(surface)))
            })
            .collect();
        let cells = all.iter().flatten().map(|(cell, _)| *cell);
        let cell = cells.fold(f64::INFINITY, f64::min);
        // How many levels later than the finest one a surface begins.
        let later = |width: f64| (width / cell).log2().round() as usize;
        let ends = all.iter().flatten().map(|(width, levels)| later(*width) + levels);
        let count = ends.max().unwrap_or(0);
        let levels: Vec<Level> = (1..=count)
            .map(|level| {
                let (surfaces, lost) = full
                    .surfaces()
                    .iter()
                    .zip(&all)
                    .map(|(surface, own)| {
                        let own = own.map_or(0, |(cell, levels)| {
                            level.saturating_sub(later(cell)).min(levels)
                        });
                        match made.at_level(surface, own) {
                            Some((coarser, lost)) => (coarser, Some(lost)),
                            None => (surface.clone(), None),
                        }
                    })
                    .unzip();
                Level { world: World::new(surfaces), lost }
            })
            .collect();
        (!levels.is_empty()).then_some(Self { levels, cell })
    }
}

impl Made {
    /// Levels above the full map of a relief.
    fn levels_of(&mut self, surface: &Surface) -> usize {
        match surface {
            Surface::Face(face) => self.maps(face.relief()).len(),
            Surface::ReliefMesh(mesh) => self.maps(mesh.relief()).len(),
            Surface::ReliefSphere(sphere) => self.cubes(sphere.relief()).len(),
            Surface::Instance(instance) => self.levels_of(instance.prototype()),
            Surface::Moving(moving) => self.levels_of(moving.prototype()),
            Surface::Quad(_) | Surface::Sphere(_) | Surface::Mesh(_) => 0,
        }
    }

    fn maps(&mut self, relief: &Arc<Relief>) -> Arc<Maps> {
        let make = || {
            let levels = relief.levels().into_iter();
            Arc::new(levels.map(|(relief, lost)| (Arc::new(relief), Arc::new(lost))).collect())
        };
        Arc::clone(self.maps.entry(Arc::as_ptr(relief)).or_insert_with(make))
    }

    fn cubes(&mut self, relief: &Arc<CubeRelief>) -> Arc<Cubes> {
        let make = || {
            let levels = relief.levels().into_iter();
            Arc::new(levels.map(|(relief, lost)| (Arc::new(relief), Arc::new(lost))).collect())
        };
        Arc::clone(self.cubes.entry(Arc::as_ptr(relief)).or_insert_with(make))
    }

    /// A surface under a level of its map, and what that lost. None for the full one, for surfaces without a map,
    /// and where the library refuses the coarser surface.
    fn at_level(&mut self, surface: &Surface, level: usize) -> Option<(Surface, Lost)> {
        let index = level.checked_sub(1)?;
        match surface {
            Surface::Face(face) => {
                let (relief, lost) = self.maps(face.relief()).get(index)?.clone();
                let FaceOptions { displacement, method, normals, .. } = face.options().clone();
                let options = FaceOptions {
                    method: of_level(method),
                    normals: of_level_normals(normals),
                    ..face.options().clone()
                };
                let [corner, u, v, _] = face.frame();
                let corners = [corner, corner + u, corner + u + v, corner + v];
                let coarser = rilievo::relief::ReliefFace::new(corners, relief, options).ok()?;
                Some((coarser.into(), Lost::Map(lost, displacement)))
            }
            Surface::ReliefMesh(mesh) => {
                let (relief, lost) = self.maps(mesh.relief()).get(index)?.clone();
                let MeshOptions { displacement, method, normals, .. } = mesh.options().clone();
                let options = MeshOptions {
                    method: of_level(method),
                    normals: of_level_normals(normals),
                    ..mesh.options().clone()
                };
                let coarser = mesh.with_relief(relief, options).ok()?;
                Some((coarser.into(), Lost::Map(lost, displacement)))
            }
            Surface::ReliefSphere(sphere) => {
                let (relief, slopes) = self.cubes(sphere.relief()).get(index)?.clone();
                let SphereOptions { displacement, method, normals, .. } = sphere.options().clone();
                let options = SphereOptions {
                    method: of_level(method),
                    normals: of_level_normals(normals),
                    ..sphere.options().clone()
                };
                let (radius, cells) = (sphere.radius(), relief.cells());
                let coarser = ReliefSphere::new(sphere.center(), radius, relief, options).ok()?;
                let lost = Lost::Cube { slopes, cells, radius, scale: displacement.scale };
                Some((coarser.into(), lost))
            }
            Surface::Instance(instance) => {
                let (prototype, lost) = self.prototype(instance.prototype(), level)?;
                let coarser = Instance::new(prototype, *instance.world_from_local()).ok()?;
                Some((coarser.into(), lost))
            }
            Surface::Moving(moving) => {
                let (prototype, lost) = self.prototype(moving.prototype(), level)?;
                let begin = moving.world_from_local(0.0);
                let coarser = MovingInstance::new(prototype, begin, *moving.motion()).ok()?;
                Some((coarser.into(), lost))
            }
            Surface::Quad(_) | Surface::Sphere(_) | Surface::Mesh(_) => None,
        }
    }

    fn prototype(&mut self, full: &Arc<Surface>, level: usize) -> Option<Prototype> {
        let key = (Arc::as_ptr(full), level);
        if let Some(known) = self.prototypes.get(&key) {
            return known.clone();
        }
        let made = self.at_level(full, level).map(|(surface, lost)| (Arc::new(surface), lost));
        self.prototypes.insert(key, made.clone());
        made
    }
}

/// How rays walk a level of a relief that they walk by `method`: levels have no distance maps.
fn of_level(method: Method) -> Method {
    match method {
        Method::Dda => Method::Dda,
        _ => Method::Pyramid,
    }
}

/// With which normals a level is shaded: those of a map are of the full heights.
fn of_level_normals(normals: ShadingNormals) -> ShadingNormals {
    match normals {
        ShadingNormals::Map(_) => ShadingNormals::Smooth,
        own => own,
    }
}

/// Width of the cells of a relief's map, in scene units: the geometric mean along both axes.
fn cell_width(surface: &Surface) -> Option<f64> {
    let mean = |relief: &Relief, lengths: [f64; 2], tile: [f64; 2]| {
        let heights = relief.heights();
        let periods = [heights.x().period(), heights.y().period()].map(f64::from);
        let [x, y] = [0, 1].map(|k| lengths[k] / (tile[k] * periods[k]));
        (x * y).sqrt()
    };
    let scaled =
        |prototype: &Surface, volume: f64| Some(cell_width(prototype)? * volume.abs().cbrt());
    match surface {
        Surface::Face(face) => {
            let [_, u, v, _] = face.frame();
            let tile = face.options().displacement.tile;
            Some(mean(face.relief(), [u.length(), v.length()], tile))
        }
        Surface::ReliefMesh(mesh) => {
            let lengths = mesh.data().lengths_of_uv()?;
            Some(mean(mesh.relief(), lengths, mesh.options().displacement.tile))
        }
        Surface::ReliefSphere(sphere) => {
            // Six faces of cells share the sphere.
            let share = (4.0 * std::f64::consts::PI / 6.0).sqrt();
            Some(share * sphere.radius() / f64::from(sphere.relief().cells()))
        }
        Surface::Instance(instance) => {
            let volume = instance.world_from_local().matrix3.determinant();
            scaled(instance.prototype(), volume)
        }
        Surface::Moving(moving) => {
            let volume = moving.world_from_local(0.0).matrix3.determinant();
            scaled(moving.prototype(), volume)
        }
        Surface::Quad(_) | Surface::Sphere(_) | Surface::Mesh(_) => None,
    }
}

//! Maps of a scene: read or made once, with the distance maps that methods ask for.

use std::sync::Arc;

use rilievo::map::{
    CubeFace, CubeHeights, DistanceKind, DistanceMap, DistanceOptions, HeightMap, Metric,
    ResamplingError, Tiling,
};
use rilievo::relief::{CubeRelief, Method, Relief};

use super::cache::MapKey;
use super::file::{MapEntry, MapSource, SceneFile};
use super::options::{DistanceBuild, LoadOptions};
use super::syntax::Located;
use crate::error::{Error, Place, Result};
use crate::image::HeightOptions;
use crate::limits::Limits;
use crate::map_file::{BakedContent, BakedMap, MapSource as BakedSource};

/// What a map needs beyond its heights: distance kinds, each with the metric of the face that asks
/// first.
#[derive(Clone, Debug, Default)]
pub(super) struct Needs {
    kinds: Vec<(DistanceKind, Face)>,
}

/// The surface a distance map is made for: its sides and its depth.
#[derive(Clone, Copy, Debug)]
pub(super) struct Face {
    /// Lengths of one repetition of the map along u and v, scene units.
    pub sides: [f64; 2],
    /// Scene units per unit of height.
    pub scale: f64,
}

impl Needs {
    /// Notes that `face` is walked by `method`.
    pub fn add(&mut self, method: Method, face: Face) {
        let Some(kind) = method.distance_kind() else { return };
        if self.kinds.iter().all(|(k, _)| *k != kind) {
            self.kinds.push((kind, face));
        }
    }
}

/// The map that a cube is resampled from.
enum Source {
    Kept(Arc<Relief>),
    Read(HeightMap),
}

impl Source {
    fn heights(&self) -> &HeightMap {
        match self {
            Self::Kept(relief) => relief.heights(),
            Self::Read(map) => map,
        }
    }
}

/// Reads or makes the map of `entry` and lays it on the faces around a sphere, with the distance maps
/// that it needs; also measures by how much that changes it, if asked.
pub(super) fn load_cube(
    file: &SceneFile,
    (name, entry): (&str, &MapEntry),
    tiling: &Located<Tiling>,
    needs: &Needs,
    options: &LoadOptions<'_>,
) -> Result<(Arc<CubeRelief>, [u32; 2], Option<ResamplingError>)> {
    let limits = &options.limits;
    let layout = options.layout.unwrap_or(entry.layout);
    let kept = MapKey::of(file, entry);
    let cache = options.cache.filter(|_| !options.resampling_error);
    let kinds = needs.kinds.iter().map(|&(kind, _)| kind);
    let made_as = (tiling.value, layout);
    if let Some((cube, size)) = cache.and_then(|cache| cache.cube(&kept, made_as, kinds)) {
        return Ok((cube, size, None));
    }
    let source = match cache {
        // The next tiling wants the map as it is, and so does a brush.
        Some(_) => Source::Kept(load(file, (name, entry), &Needs::default(), options)?),
        None => Source::Read(heights(file, entry, options)?),
    };
    let map = source.heights();
    let place = Place::Text(crate::Excerpt::new(&file.text, tiling.at.clone()));
    limits.check(
        &file.path,
        place,
        "the map of a sphere",
        &[CubeHeights::predicted_bytes(map, tiling.value)],
    )?;
    let cube = CubeHeights::resample(map, tiling.value)
        .map_err(|e| fault(file, &tiling.at, "displacement", e.to_string(), ""))?;
    let error = options.resampling_error.then(|| cube.resampling_error(map));
    let size = [map.width(), map.height()];
    drop(source);
    let mut relief = CubeRelief::with_layout(cube, layout);
    if let (Some(name), false) = (&entry.distance.file, needs.kinds.is_empty()) {
        let found = "a map baked for faces";
        let allowed = "nothing for spheres: their maps are resampled, and distances made";
        return Err(fault(file, &name.at, "distance.file", found, allowed));
    }
    for &(kind, face) in &needs.kinds {
        let heights = relief.face(CubeFace::PosX).heights();
        let build = plan_distance(file, entry, heights, (kind, face), (6, limits))?;
        tell(options, name, (kind, build.value.size), heights);
        relief = relief
            .with_distances(kind, &build.value)
            .map_err(|e| fault(file, &build.at, "distance", e.to_string(), ""))?;
    }
    let relief = Arc::new(relief);
    if let Some(cache) = cache {
        cache.keep_cube(kept, made_as, (Arc::clone(&relief), size));
    }
    Ok((relief, size, error))
}

/// Reads or makes the map `name` and what it needs.
pub(super) fn load(
    file: &SceneFile,
    (name, entry): (&str, &MapEntry),
    needs: &Needs,
    options: &LoadOptions<'_>,
) -> Result<Arc<Relief>> {
    let layout = options.layout.unwrap_or(entry.layout);
    let key = MapKey::of(file, entry);
    let mut relief = match options.cache.and_then(|cache| cache.relief(&key, layout)) {
        Some(relief) => relief,
        None => Arc::new(Relief::with_layout(heights(file, entry, options)?, layout)),
    };
    for &(kind, face) in &needs.kinds {
        if relief.distance(kind).is_none() {
            let own = Arc::unwrap_or_clone(relief);
            let need = (kind, face);
            relief = Arc::new(add_distance(file, (name, entry), own, need, options)?);
        }
    }
    keep(file, entry, &relief, options);
    Ok(relief)
}

/// Leaves heights for the next loading.
pub(super) fn keep(
    file: &SceneFile,
    entry: &MapEntry,
    relief: &Arc<Relief>,
    options: &LoadOptions<'_>,
) {
    if let Some(cache) = options.cache {
        cache.keep_relief(MapKey::of(file, entry), relief);
    }
}

/// Reads or makes a distance map and adds it to the map `name`.
pub(super) fn add_distance(
    file: &SceneFile,
    (name, entry): (&str, &MapEntry),
    relief: Relief,
    (kind, face): (DistanceKind, Face),
    options: &LoadOptions<'_>,
) -> Result<Relief> {
    let limits = &options.limits;
    let map = match &entry.distance.file {
        Some(name) => {
            let map = read_baked(file, name, relief.heights(), limits)?;
            if map.kind() != kind {
                let found = format!("a distance map of kind {:?}", map.kind());
                let allowed = format!("{kind:?}, which the method of a shape asks for");
                return Err(fault(file, &name.at, "distance.file", found, allowed));
            }
            map
        }
        None => {
            let build = plan_distance(file, entry, relief.heights(), (kind, face), (1, limits))?;
            tell(options, name, (kind, build.value.size), relief.heights());
            (options.build_distances)(relief.heights(), kind, &build.value)
                .map_err(|e| fault(file, &build.at, "distance", e.to_string(), ""))?
        }
    };
    relief.with_distance(map).map_err(|e| fault(file, &entry.at, "distance", e.to_string(), ""))
}

/// Tells that a distance map is about to be built.
fn tell(
    options: &LoadOptions<'_>,
    map: &str,
    (kind, size): (DistanceKind, [u32; 3]),
    heights: &HeightMap,
) {
    let cells = [heights.x().cells(), heights.y().cells()];
    (options.building)(&DistanceBuild { map, kind, size, cells });
}

fn fault(
    file: &SceneFile,
    at: &std::ops::Range<usize>,
    what: &str,
    found: impl Into<String>,
    allowed: impl Into<String>,
) -> Error {
    Error::Invalid(Box::new(file.document().fault(at, what, found, allowed)))
}

fn heights(file: &SceneFile, entry: &MapEntry, options: &LoadOptions<'_>) -> Result<HeightMap> {
    let limits = &options.limits;
    if let Some(map) = options.cache.and_then(|cache| cache.heights(&MapKey::of(file, entry))) {
        return Ok(map);
    }
    match &entry.source {
        MapSource::File { file: name, invert } => {
            let meant = HeightOptions { lattice: entry.lattice, wrap: entry.wrap, invert: *invert };
            let path = file.beside(&name.value);
            let judged = options.cache.and_then(|cache| cache.take_judged(&path));
            if let Some(map) = judged.filter(|_| !invert) {
                return Ok(map.with_lattice(entry.lattice, entry.wrap));
            }
            meant.read(&path, limits).map_err(|e| file.referenced(name, "map", e))
        }
        MapSource::Procedural { shape, size, codes } => {
            let [width, height] = size.value;
            let sample = if *codes { 2 } else { 4 };
            let sides = [u64::from(width), u64::from(height), sample];
            let place = Place::Text(crate::Excerpt::new(&file.text, size.at.clone()));
            limits.check(&file.path, place, "the height map", &sides)?;
            let made = if *codes {
                shape.height_map(size.value, entry.lattice, entry.wrap)
            } else {
                shape.height_map_f32(size.value, entry.lattice, entry.wrap)
            };
            made.map_err(|e| fault(file, &entry.at, "map", e.to_string(), ""))
        }
    }
}

/// The baked distance map `name`, made from `heights`.
fn read_baked(
    file: &SceneFile,
    name: &Located<String>,
    heights: &HeightMap,
    limits: &Limits,
) -> Result<DistanceMap> {
    let path = file.beside(&name.value);
    let baked = BakedMap::read(&path, limits);
    let baked = baked.map_err(|e| file.referenced(name, "distance.file", e))?;
    let allowed = "a distance map baked from this map, with this grid and wrap";
    let BakedContent::Distances(map) = baked.content else {
        return Err(fault(file, &name.at, "distance.file", "another kind of baked map", allowed));
    };
    if baked.source != BakedSource::of(heights) {
        return Err(fault(file, &name.at, "distance.file", "baked from another map", allowed));
    }
    Ok(map)
}

/// How distance maps, so many of them, are to be built, and the place that says so.
fn plan_distance(
    file: &SceneFile,
    entry: &MapEntry,
    heights: &HeightMap,
    (kind, face): (DistanceKind, Face),
    (count, limits): (u64, &Limits),
) -> Result<Located<DistanceOptions>> {
    let metric = Metric::of_face(heights, face.sides, face.scale.abs());
    let default = DistanceOptions::by_default(heights, kind, metric);
    let size = entry.distance.size.clone();
    let size = size.unwrap_or(Located { value: default.size, at: entry.at.clone() });
    let bits = entry.distance.bits.unwrap_or(default.bits);
    let bytes = DistanceMap::predicted_bytes(size.value, bits);
    let place = Place::Text(crate::Excerpt::new(&file.text, size.at.clone()));
    let bytes = u64::try_from(bytes).unwrap_or(u64::MAX);
    limits.check(&file.path, place, "the distance map", &[bytes, count])?;
    Ok(Located { value: DistanceOptions { size: size.value, metric, bits }, at: size.at })
}

//! `rilievo check`: a scene with all its files, or a baked map against its height map.

use std::collections::BTreeSet;

use rilievo::map::{
    DistanceMap, HeightMap, Level, NormalConvention, NormalKind, NormalMap, Pyramid,
};
use rilievo_io::image::HeightOptions;
use rilievo_io::map_file::{BakedContent, BakedMap, BakedNormals, MapSource};
use rilievo_io::scene::{LoadOptions, SceneFile};
use rilievo_io::texture_set::TextureSet;
use rilievo_io::{FileKind, Limits};
use serde::Serialize;

use crate::args::CheckArgs;
use crate::job;
use crate::outcome::{Failure, Outcome};
use crate::progress::Progress;

/// The JSON object of a baked map.
#[derive(Serialize)]
struct Report {
    /// Whether header, size and checksum hold: always true, or an error is printed instead.
    readable: bool,
    /// Whether the map was made from the height map given; none without one.
    same_source: Option<bool>,
    /// Whether no stored value is wrong for the height map given; none without one.
    safe: Option<bool>,
    /// Number of stored values that are.
    unsafe_values: Option<u64>,
    /// Number of stored values.
    values: u64,
}

pub fn run(args: &CheckArgs) -> Result<Outcome, Failure> {
    if args.file.is_dir() && args.map.is_none() {
        return scene(args);
    }
    match FileKind::of(&args.file)? {
        FileKind::Text | FileKind::Mesh(_) if args.map.is_some() => {
            Err(Failure::Usage("--map belongs to a baked map, not to a scene".to_owned()))
        }
        FileKind::Text | FileKind::Mesh(_) => scene(args),
        FileKind::BakedMap => baked(args),
        FileKind::Image(format) => {
            let path = args.file.display();
            Err(Failure::Refused(format!("{path}: {format}; allowed: a scene or a baked map")))
        }
    }
}

/// The JSON object of a scene.
#[derive(Serialize)]
struct SceneReport {
    /// Always true, or an error is printed instead.
    valid: bool,
    surfaces: usize,
    materials: usize,
    lights: usize,
    maps: Vec<String>,
    /// Files the scene names.
    files: usize,
}

fn scene(args: &CheckArgs) -> Result<Outcome, Failure> {
    let limits = Limits::default();
    let files = SceneFile::present(&args.file, &limits)?.references();
    let options = LoadOptions { limits, ..LoadOptions::default() };
    let loaded = job::load(&args.file, &options, args.talk)?;
    // Files that no shape uses are not loaded; they must at least be there.
    for file in &files {
        match file.is_dir() {
            true => drop(TextureSet::find(file, &limits)?),
            false => drop(FileKind::of(file)?),
        }
    }
    let (scene, files) = (&loaded.scene, files.len());
    let of_quads = loaded.maps.iter().map(|map| map.name.clone());
    let of_spheres = loaded.sphere_maps.iter().map(|map| map.name.clone());
    let maps: BTreeSet<_> = of_quads.chain(of_spheres).collect();
    let report = SceneReport {
        valid: true,
        surfaces: scene.world().surfaces().len(),
        materials: scene.materials().len(),
        lights: scene.lights().len(),
        maps: maps.into_iter().collect(),
        files,
    };
    args.talk.line(format_args!(
        "{}: valid, {} surfaces, {} materials, {} lights, {} maps, {files} files",
        args.file.display(),
        report.surfaces,
        report.materials,
        report.lights,
        report.maps.len()
    ));
    args.talk.object(&report)?;
    Ok(Outcome::Done)
}

fn baked(args: &CheckArgs) -> Result<Outcome, Failure> {
    let limits = Limits::default();
    let map = BakedMap::read(&args.file, &limits)?;
    let (talk, path) = (args.talk, args.file.display());
    let values = match &map.content {
        BakedContent::Normals(normals) => normals.texels.len() as u64,
        BakedContent::Distances(map) => map.codes().len() as u64,
        BakedContent::MinMax(levels) => levels.iter().map(values).sum(),
    };
    let mut report =
        Report { readable: true, same_source: None, safe: None, unsafe_values: None, values };
    let Some(source) = &args.map else {
        talk.line(format_args!(
            "{path}: header, size and checksum hold; --map HEIGHTMAP checks that it is safe"
        ));
        talk.object(&report)?;
        return Ok(Outcome::Done);
    };
    let MapSource { lattice, wrap, .. } = map.source;
    let heights = HeightOptions { lattice, wrap, invert: args.invert }.read(source, &limits)?;
    let same = MapSource::of(&heights) == map.source;
    let progress = Progress::uncounted(talk.quiet, "checking every stored value");
    let found = match &map.content {
        BakedContent::Normals(normals) => check_normals(normals, &heights),
        BakedContent::Distances(map) => check_distances(map, &heights),
        BakedContent::MinMax(levels) => check_bounds(levels, &heights),
    };
    drop(progress);
    if !same {
        talk.line(format_args!("{path}: made from another height map than {}", source.display()));
    }
    match &found.first {
        None => talk.line(format_args!("{path}: safe, {values} values checked")),
        Some(first) => talk.line(format_args!(
            "{path}: {} of {values} values are not safe; the first: {first}",
            found.count
        )),
    }
    report.same_source = Some(same);
    report.safe = Some(found.count == 0);
    report.unsafe_values = Some(found.count);
    talk.object(&report)?;
    Ok(if found.count == 0 { Outcome::Done } else { Outcome::Unequal })
}

/// Values that are not what the heights allow, and a word about the first.
struct Unsafe {
    count: u64,
    first: Option<String>,
}

impl Unsafe {
    const NONE: Self = Self { count: 0, first: None };

    fn one(why: impl std::fmt::Display) -> Self {
        Self { count: 1, first: Some(why.to_string()) }
    }
}

/// Number of bounds in a level: one a lane of maxima and minima.
fn values(level: &Level) -> u64 {
    level.nodes.iter().map(|&n| u64::from(n)).product::<u64>() * 32
}

fn check_distances(map: &DistanceMap, heights: &HeightMap) -> Unsafe {
    match map.unsafe_codes(heights, &Pyramid::build(heights)) {
        Err(other) => Unsafe::one(other),
        Ok(found) => {
            Unsafe { count: found.count, first: found.first.map(|first| first.to_string()) }
        }
    }
}

fn check_bounds(levels: &[Level], heights: &HeightMap) -> Unsafe {
    match Pyramid::from_levels(levels.to_vec(), heights) {
        Ok(_) => Unsafe::NONE,
        Err(violation) => Unsafe::one(violation),
    }
}

/// Normals are right if they are those of one kind.
fn check_normals(normals: &BakedNormals, heights: &HeightMap) -> Unsafe {
    let kinds = [NormalKind::Smooth, NormalKind::Exact, NormalKind::Published];
    let counts = kinds.map(|kind| {
        let meant = NormalMap::from_height(heights, kind, normals.metric);
        let meant = meant.to_texels(NormalConvention::OpenGl);
        let size = heights.width() as usize * heights.height() as usize;
        let found = normals.texels.iter().zip(&meant).filter(|(a, b)| a != b).count() as u64;
        if normals.texels.len() == size { found } else { u64::MAX }
    });
    let count = counts.into_iter().min().unwrap_or(0);
    match count {
        0 => Unsafe::NONE,
        u64::MAX => Unsafe::one("the normal map has another number of texels"),
        _ => {
            Unsafe { count, first: Some("texels are not those of any kind of normals".to_owned()) }
        }
    }
}

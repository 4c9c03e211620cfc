//! `rilievo info`: what a file is and what a render of it needs.

mod agreement;
mod map;
mod model;
mod scene;
mod texture_set;

use rilievo_io::map_file::{BakedContent, BakedMap, MapSource};
use rilievo_io::{FileKind, Limits};
use serde::Serialize;

use crate::args::InfoArgs;
use crate::name;
use crate::outcome::{Failure, Outcome};
use crate::report;

pub fn run(args: &InfoArgs) -> Result<Outcome, Failure> {
    if args.file.is_dir() {
        texture_set::run(args)?;
        return Ok(Outcome::Done);
    }
    match FileKind::of(&args.file)? {
        FileKind::Image(_) => map::run(args)?,
        FileKind::Mesh(format) => model::run(args, format)?,
        FileKind::BakedMap => baked(args)?,
        FileKind::Text => scene::run(args)?,
    }
    Ok(Outcome::Done)
}

/// The JSON object of a baked map.
#[derive(Serialize)]
struct BakedReport {
    kind: &'static str,
    /// Texels and 1; voxels or nodes; stored cells and levels.
    size: [u32; 3],
    bits: u32,
    bytes: u64,
    /// Scene units per cell along x and y and per raw unit of height.
    metric: Option<[f64; 3]>,
    /// Scene units of one step of distance.
    quantum: Option<f64>,
    /// Samples of the height map.
    samples: [u32; 2],
    grid: &'static str,
    wrap: &'static str,
    raw_range: [f32; 2],
    /// Hash of the height map.
    source: String,
}

impl BakedReport {
    fn of(map: &BakedMap) -> Self {
        let MapSource { samples, lattice, wrap, raw_range, hash } = map.source;
        let plain = Self {
            kind: "normal",
            size: [samples[0], samples[1], 1],
            bits: 16,
            bytes: 0,
            metric: None,
            quantum: None,
            samples,
            grid: name::lattice(lattice),
            wrap: name::wrap(wrap),
            raw_range: [raw_range.0, raw_range.1],
            source: format!("{hash:016x}"),
        };
        match &map.content {
            BakedContent::Normals(normals) => Self {
                bytes: size_of_val(normals.texels.as_slice()) as u64,
                metric: Some([normals.metric.x, normals.metric.y, normals.metric.z]),
                ..plain
            },
            BakedContent::Distances(map) => Self {
                kind: name::distance_kind(map.kind()),
                size: map.size(),
                bits: 8 * map.codes().bits().bytes() as u32,
                bytes: map.bytes(),
                metric: Some([map.metric().x, map.metric().y, map.metric().z]),
                quantum: Some(map.quantum()),
                ..plain
            },
            BakedContent::MinMax(levels) => Self {
                kind: "min-max",
                size: [samples[0], samples[1], levels.len() as u32],
                bits: levels.first().map_or(16, |level| level.bounds.layout().bits()),
                bytes: levels.iter().map(|level| level.bounds.bytes()).sum(),
                ..plain
            },
        }
    }
}

fn baked(args: &InfoArgs) -> Result<(), Failure> {
    let report = BakedReport::of(&BakedMap::read(&args.file, &Limits::default())?);
    let talk = args.talk;
    let [x, y, z] = report.size;
    talk.line(format_args!(
        "{}: baked {} map, {x} x {y} x {z}, {} bit, {}",
        args.file.display(),
        report.kind,
        report.bits,
        report::bytes(report.bytes)
    ));
    talk.line(format_args!(
        "made from   {} x {} samples, {}, {}, raw heights {} to {}, hash {}",
        report.samples[0],
        report.samples[1],
        report.grid,
        report.wrap,
        report.raw_range[0],
        report.raw_range[1],
        report.source
    ));
    if let Some([x, y, z]) = report.metric {
        talk.line(format_args!(
            "metric      {x:.6e} by {y:.6e} a cell, {z:.6e} a raw unit of height"
        ));
    }
    if let Some(quantum) = report.quantum {
        talk.line(format_args!("quantum     {quantum:.6e} scene units"));
    }
    talk.object(&report)
}

//! `rilievo bake`: derived maps as files, read back after writing.

use rilievo::map::{
    DistanceMap, DistanceOptions, HeightMap, Metric, NormalConvention, NormalMap, NormalTexels,
    Pyramid,
};
use rilievo_io::Limits;
use rilievo_io::image::{HeightOptions, NormalOptions, write_png_rgb16};
use rilievo_io::map_file::{BakedContent, BakedMap, BakedNormals, MapSource};
use serde::Serialize;

use crate::args::value::has_extension;
use crate::args::{Bake, BakeArgs, BakeFiles, BoundsArgs, DistanceArgs, FaceSize, NormalArgs};
use crate::name;
use crate::outcome::{Failure, Outcome};
use crate::progress::Progress;
use crate::report;
use crate::stopwatch::{Elapsed, Stopwatch};

/// The JSON object.
#[derive(Serialize)]
struct Report {
    /// What was made.
    kind: &'static str,
    /// Texels and 1; voxels or nodes; stored cells and levels.
    size: [u32; 3],
    build_seconds: f64,
    /// Processor time of all threads; null where the system does not tell.
    build_cpu_seconds: Option<f64>,
    map_bytes: u64,
    bytes: u64,
}

/// What was made: its size, how long it took, its bytes.
type Made = ([u32; 3], Elapsed, u64);

impl Report {
    fn new(kind: &'static str, heights: &HeightMap, (size, build, bytes): Made) -> Self {
        Self {
            kind,
            size,
            build_seconds: build.seconds,
            build_cpu_seconds: build.cpu_seconds,
            map_bytes: heights.bytes(),
            bytes,
        }
    }
}

pub fn run(args: &BakeArgs) -> Result<Outcome, Failure> {
    let (files, report) = match &args.what {
        Bake::Normal(args) => (&args.files, normal(args)?),
        Bake::Distance(args) => (&args.files, distance(args)?),
        Bake::Bounds(args) => (&args.files, bounds(args)?),
    };
    let [x, y, z] = report.size;
    files.talk.line(format_args!(
        "{}: {} map, {x} x {y} x {z}, {}, built in {}, read back and found the same",
        files.output.display(),
        report.kind,
        report::bytes(report.bytes),
        report::duration(report.build_seconds)
    ));
    files.talk.object(&report)?;
    Ok(Outcome::Done)
}

impl BakeFiles {
    fn heights(&self) -> Result<HeightMap, Failure> {
        let meaning = self.meaning;
        let options =
            HeightOptions { lattice: meaning.grid, wrap: meaning.wrap, invert: meaning.invert };
        Ok(options.read(&self.map, &Limits::default())?)
    }

    /// Builds a map and takes the time.
    fn timed<T>(&self, what: &str, build: impl FnOnce() -> T) -> (T, Elapsed) {
        let progress = Progress::uncounted(self.talk.quiet, &format!("building the {what} map"));
        let watch = Stopwatch::start();
        let built = build();
        let elapsed = watch.elapsed();
        drop(progress);
        (built, elapsed)
    }

    /// Writes a map and reads it back.
    fn store(&self, heights: &HeightMap, content: BakedContent) -> Result<(), Failure> {
        let map = BakedMap { source: MapSource::of(heights), content };
        map.write(&self.output)?;
        let back = BakedMap::read(&self.output, &Limits::default())?;
        self.compare(back == map)
    }

    fn compare(&self, same: bool) -> Result<(), Failure> {
        if same {
            return Ok(());
        }
        let path = self.output.display();
        Err(Failure::Refused(format!("{path}: what was read back is not what was written")))
    }
}

impl FaceSize {
    fn metric(&self, heights: &HeightMap) -> Metric {
        Metric::of_face(heights, self.face, self.depth)
    }
}

fn normal(args: &NormalArgs) -> Result<Report, Failure> {
    let files = &args.files;
    let png = has_extension(&files.output, "png");
    if !png && args.convention == NormalConvention::DirectX {
        let why = "--convention directx is for PNG; map files state their own, green up";
        return Err(Failure::Usage(why.to_owned()));
    }
    let heights = files.heights()?;
    let metric = args.face.metric(&heights);
    let make = || NormalMap::from_height(&heights, args.normals, metric);
    let (map, build) = files.timed("normal", make);
    let texels = map.to_texels(args.convention);
    let bytes = size_of_val(texels.as_slice()) as u64;
    let (width, height) = (heights.width(), heights.height());
    if png {
        let (lattice, wrap) = (heights.x().lattice(), heights.x().wrap());
        // Files begin at the top, maps at the bottom.
        let rows: Vec<_> = texels.chunks(width as usize).rev().flatten().copied().collect();
        write_png_rgb16(&files.output, [width, height], &rows)?;
        let options = NormalOptions { convention: args.convention, lattice, wrap };
        let back = options.read(&files.output, &Limits::default())?;
        let texels = NormalTexels::U16(texels);
        let meant =
            NormalMap::from_texels([width, height], &texels, args.convention, (lattice, wrap));
        files.compare(meant.is_ok_and(|meant| meant == back))?;
    } else {
        files.store(&heights, BakedContent::Normals(BakedNormals { metric, texels }))?;
    }
    let size = [width, height, 1];
    let made = (size, build, bytes);
    Ok(Report::new("normal", &heights, made))
}

fn distance(args: &DistanceArgs) -> Result<Report, Failure> {
    let files = &args.files;
    let least = args.kind.least_size();
    if let Some(size) = args.size
        && size.iter().any(|&n| n < least)
    {
        let kind = name::distance_kind(args.kind);
        let why = format!("--size of kind {kind} needs at least {least} along each axis");
        return Err(Failure::Usage(why));
    }
    let heights = files.heights()?;
    let by_default = DistanceOptions::by_default(&heights, args.kind, args.face.metric(&heights));
    let size = args.size.unwrap_or(by_default.size);
    let options = DistanceOptions { size, bits: args.bits, ..by_default };
    let make = || DistanceMap::from_height(&heights, args.kind, &options);
    let (map, build) = files.timed("distance", make);
    let map = map.map_err(Failure::refused)?;
    let bytes = map.bytes();
    files.store(&heights, BakedContent::Distances(map))?;
    let kind = name::distance_kind(args.kind);
    let made = (size, build, bytes);
    Ok(Report::new(kind, &heights, made))
}

fn bounds(args: &BoundsArgs) -> Result<Report, Failure> {
    let files = &args.files;
    let heights = files.heights()?;
    let (pyramid, build) = files.timed("min-max", || Pyramid::build_as(&heights, args.layout));
    let [x, y] = pyramid.cells();
    let size = [x, y, pyramid.levels()];
    let bytes = pyramid.bytes();
    let levels = (0..pyramid.levels()).map(|l| pyramid.level(l).clone()).collect();
    files.store(&heights, BakedContent::MinMax(levels))?;
    let made = (size, build, bytes);
    Ok(Report::new("min-max", &heights, made))
}

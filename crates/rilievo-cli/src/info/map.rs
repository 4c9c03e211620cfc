//! A height map as `rilievo info` tells it.

use rilievo::map::{HeightStatistics, NormalAgreement, NormalConvention, Samples, Seam};
use rilievo::relief::Relief;
use rilievo_io::Limits;
use rilievo_io::image::{
    Blocks, HeightOptions, ImageInfo, NormalOptions, SampleKind, Terrain, read_image_info,
};
use rilievo_render::{Film, MemoryUse};
use serde::Serialize;

use super::agreement;
use crate::args::InfoArgs;
use crate::memory::predicted_bytes;
use crate::outcome::Failure;
use crate::picture::PictureKind;
use crate::report;

/// Pixels of the render whose memory is told, unless said otherwise.
const RESOLUTION: [u32; 2] = [512, 512];

/// The JSON object.
#[derive(Serialize)]
struct Report {
    kind: &'static str,
    format: String,
    width: u32,
    height: u32,
    channels: u32,
    /// Bits a sample in memory: 16 for codes, 32 for numbers.
    bits: u32,
    /// Bits a code in the file, 32 for numbers of any width.
    file_bits: u32,
    /// Smallest and largest stored value.
    raw_range: [f32; 2],
    /// The same in heights.
    range: [f64; 2],
    /// Distinct values.
    levels: u64,
    /// Whether slopes will show steps.
    terraces: bool,
    seams: Seams,
    tiles: bool,
    resolution: [u32; 2],
    map_bytes: u64,
    bounds_bytes: u64,
    predicted_bytes: u64,
    /// Null for a file that does not say how large its cells are.
    terrain: Option<TerrainReport>,
    /// Samples without a measurement, filled with the lowest height.
    voids: u64,
    /// How `--normals` agree; null without.
    agreement: Option<agreement::Report>,
}

#[derive(Serialize)]
struct TerrainReport {
    /// Metres from one sample to the next along u and v.
    cell_metres: [f64; 2],
    /// Metres of a unit of height, of codes of a code.
    height_metres: f64,
    /// Degrees, where cells are degrees.
    latitude: Option<f64>,
}

impl From<Terrain> for TerrainReport {
    fn from(terrain: Terrain) -> Self {
        let Terrain { cell, metre, latitude } = terrain;
        Self { cell_metres: cell, height_metres: metre, latitude }
    }
}

#[derive(Serialize)]
struct Seams {
    u: SeamReport,
    v: SeamReport,
}

#[derive(Serialize)]
struct SeamReport {
    largest: f64,
    mean: f64,
    inner_largest: f64,
    inner_mean: f64,
    tiles: bool,
}

impl From<Seam> for SeamReport {
    fn from(seam: Seam) -> Self {
        let Seam { largest, mean, inner_largest, inner_mean, .. } = seam;
        Self { largest, mean, inner_largest, inner_mean, tiles: seam.tiles() }
    }
}

pub fn run(args: &InfoArgs) -> Result<(), Failure> {
    let limits = Limits::default();
    let info = read_image_info(&args.file, &limits)?;
    let meaning = args.meaning;
    let options =
        HeightOptions { lattice: meaning.grid, wrap: meaning.wrap, invert: meaning.invert };
    let (heights, voids) = options.read_with_voids(&args.file, &limits)?;
    let agreement = match &args.normals {
        Some(path) => {
            let convention = NormalConvention::OpenGl;
            let options = NormalOptions { convention, lattice: meaning.grid, wrap: meaning.wrap };
            Some(NormalAgreement::of(&heights, &options.read(path, &limits)?))
        }
        None => None,
    };
    let relief = Relief::with_layout(heights, args.layout.unwrap_or_default());
    let mut report = Report::new(&info, &relief, args.resolution.unwrap_or(RESOLUTION));
    report.terrain = Terrain::read(&args.file, &limits)?.map(TerrainReport::from);
    report.voids = voids;
    report.agreement = agreement.map(agreement::Report::from);
    report.tell(args);
    args.talk.object(&report)
}

impl Report {
    fn new(info: &ImageInfo, relief: &Relief, resolution: [u32; 2]) -> Self {
        let heights = relief.heights();
        let (low, high) = heights.raw_range();
        let unit = heights.unit();
        let bits = match heights.samples() {
            Samples::U16(_) => 16,
            Samples::F32(_) => 32,
        };
        let (map_bytes, bounds_bytes) = relief.bytes();
        let film = Film::predicted_bytes(resolution, &[], false);
        let memory =
            MemoryUse { heights: map_bytes, bounds: bounds_bytes, film, ..MemoryUse::default() };
        let writing = PictureKind::Colour.writing_bytes(resolution, Blocks::Lines, 0);
        let predicted_bytes = predicted_bytes(&memory, writing);
        // After the prediction: sorting values takes memory that no render needs.
        let HeightStatistics { levels, seams: [u, v] } = HeightStatistics::of(heights);
        Self {
            kind: "height map",
            format: info.format.to_string(),
            width: info.width,
            height: info.height,
            channels: info.channels,
            bits,
            file_bits: 8 * info.sample.bytes(),
            raw_range: [low, high],
            range: [f64::from(low) * unit, f64::from(high) * unit],
            levels,
            // Two levels are a shape of steps, and meant so.
            terraces: levels > 2 && (levels <= 256 || info.sample == SampleKind::U8),
            tiles: u.tiles() && v.tiles(),
            seams: Seams { u: u.into(), v: v.into() },
            resolution,
            map_bytes,
            bounds_bytes,
            predicted_bytes,
            terrain: None,
            voids: 0,
            agreement: None,
        }
    }

    fn tell(&self, args: &InfoArgs) {
        let talk = args.talk;
        talk.line(format_args!(
            "{}: height map, {}, {} x {} samples, {} bit, {}",
            args.file.display(),
            self.format,
            self.width,
            self.height,
            self.file_bits,
            if self.channels == 1 {
                "1 channel".to_owned()
            } else {
                format!("{} channels", self.channels)
            }
        ));
        let ([low, high], [raw_low, raw_high]) = (self.range, self.raw_range);
        talk.line(format_args!(
            "heights     {low:.6} to {high:.6} (stored {raw_low} to {raw_high}), {} distinct levels",
            self.levels
        ));
        for (axis, seam) in [("u", &self.seams.u), ("v", &self.seams.v)] {
            talk.line(format_args!(
                "seam in {axis}   largest step {}, mean {} (inside {}): {}",
                report::number(seam.largest),
                report::number(seam.mean),
                report::number(seam.inner_mean),
                if seam.tiles { "tiles" } else { "does not tile" }
            ));
        }
        let [width, height] = self.resolution;
        talk.line(format_args!(
            "memory      heights {}, bounds {}; a render of {width} x {height} needs about {}",
            report::bytes(self.map_bytes),
            report::bytes(self.bounds_bytes),
            report::bytes(self.predicted_bytes)
        ));
        if let Some(terrain) = &self.terrain {
            let [x, y] = terrain.cell_metres;
            let degrees = match terrain.latitude {
                Some(latitude) => format!(", degrees at latitude {latitude:.3}"),
                None => String::new(),
            };
            talk.line(format_args!("terrain     cells of {x:.2} x {y:.2} m{degrees}"));
        }
        if self.voids > 0 {
            talk.line(format_args!(
                "voids       {} samples without a measurement, filled with the lowest height",
                self.voids
            ));
        }
        if let Some(agreement) = &self.agreement {
            agreement.tell(talk);
        }
        if self.terraces {
            talk.line(format_args!(
                "warning     {} levels are 8-bit steps: slopes will show terraces {:.4} of the \
                 depth high",
                self.levels,
                (self.range[1] - self.range[0]) / (self.levels - 1) as f64
            ));
        }
    }
}

//! A texture set as `rilievo info` tells it: which file is which map, what is assumed, and how the
//! author's normals agree with the heights.

use rilievo_io::Limits;
use rilievo_io::image::HeightOptions;
use rilievo_io::texture_set::{MapRole, SetMap, TextureSet, Told};
use serde::Serialize;

use super::agreement;
use crate::args::InfoArgs;
use crate::name;
use crate::outcome::Failure;

/// The JSON object.
#[derive(Serialize)]
struct Report {
    kind: &'static str,
    maps: Vec<MapReport>,
    /// Images that were not taken.
    passed_over: Vec<String>,
    /// Null without a displacement map.
    assumed: Option<Assumptions>,
    /// Null without a normal map.
    agreement: Option<agreement::Report>,
}

#[derive(Serialize)]
struct MapReport {
    role: &'static str,
    file: String,
    width: u32,
    height: u32,
    channels: u32,
    file_bits: u32,
    /// What told its role: `name`, `MaterialX` or `nothing`.
    told: &'static str,
    /// What the name of a normal map says of green.
    convention: Option<&'static str>,
}

#[derive(Serialize)]
struct Assumptions {
    zero: f64,
    /// Displacement of a height of 1, in widths of the map.
    scale: f64,
    invert: bool,
    why: String,
}

impl From<&SetMap> for MapReport {
    fn from(map: &SetMap) -> Self {
        Self {
            role: map.role.name(),
            file: map.path.display().to_string(),
            width: map.image.width,
            height: map.image.height,
            channels: map.image.channels,
            file_bits: map.image.file_bits,
            told: match map.told {
                Told::Name => "name",
                Told::Document => "MaterialX",
                Told::Nothing => "nothing",
            },
            convention: map.convention.map(name::convention),
        }
    }
}

pub fn run(args: &InfoArgs) -> Result<(), Failure> {
    let (limits, talk) = (Limits::default(), args.talk);
    let set = TextureSet::find(&args.file, &limits)?;
    talk.line(format_args!("{}: texture set, {} maps", args.file.display(), set.maps.len()));
    for note in set.describe() {
        talk.line(format_args!("{note}"));
    }
    let passed_over = set.passed_over.iter().map(|(path, why)| {
        talk.line(format_args!("{}: not taken: {why}", path.display()));
        path.display().to_string()
    });
    let mut report = Report {
        kind: "texture set",
        maps: set.maps.iter().map(MapReport::from).collect(),
        passed_over: passed_over.collect(),
        assumed: None,
        agreement: None,
    };
    if set.map(MapRole::Displacement).is_some() {
        let meaning = args.meaning;
        let options = HeightOptions { lattice: meaning.grid, wrap: meaning.wrap, invert: false };
        let heights = set.heights(&options, &limits)?;
        let assumed = set.assumed(&heights, &limits)?;
        talk.line(format_args!("{}", assumed.describe()));
        report.agreement = assumed.agreement.map(agreement::Report::from);
        if let Some(agreement) = &report.agreement {
            agreement.tell(talk);
        }
        let (zero, scale) = (assumed.zero, assumed.scale);
        let (invert, why) = (assumed.invert, assumed.why);
        report.assumed = Some(Assumptions { zero, scale, invert, why });
    }
    talk.object(&report)
}

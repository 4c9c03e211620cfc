//! `[maps.NAME]` and its distance maps.

use rilievo::map::{DistanceBits, Lattice, Layout, Wrap};

use super::kind::{Choice, Codes, Each, Flag, Form, Integer, Number, Text, along_uv};
use super::{Fallback, Key, Optional, Section};

/// Largest size of a procedural map along an axis.
const MAX_SIZE: u32 = 1 << 24;
/// Largest size of a distance map along an axis.
const MAX_DISTANCE_SIZE: u32 = 1 << 16;

/// The formulas, before their parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Formula {
    Flat,
    Gaussian,
    Studded,
    Fbm,
    Ramp,
    Step,
    Tent,
    Ripple,
}

/// What lies beyond the border of an image.
pub const WRAPS: Choice<Wrap> =
    Choice(|| vec![("repeat", Wrap::Repeat), ("clamp", Wrap::Clamp), ("mirror", Wrap::Mirror)]);

pub const FILE: Key<Text, Optional> = Key::new(
    "file",
    Text("path"),
    Optional("or `procedural`"),
    "PNG, TIFF, JPEG, OpenEXR, PFM, Radiance HDR; `.asc`, `.hgt`, `.bil` ([terrain](ASSETS.md))",
);
pub const INVERT: Key<Flag, Fallback<bool>> = Key::new(
    "invert",
    Flag,
    Fallback(false),
    "with `file`; `true`: black is high, `H` becomes `1 - H`",
);
pub const PROCEDURAL: Key<Choice<Formula>, Optional> = Key::new(
    "procedural",
    Choice(|| {
        vec![
            ("flat", Formula::Flat),
            ("gaussian", Formula::Gaussian),
            ("studded", Formula::Studded),
            ("fbm", Formula::Fbm),
            ("ramp", Formula::Ramp),
            ("step", Formula::Step),
            ("tent", Formula::Tent),
            ("ripple", Formula::Ripple),
        ]
    }),
    Optional("or `file`"),
    "a formula in place of `file`",
);
pub const SIZE: Key<Each<Integer<u32>, 2>, Fallback<[u32; 2]>> = Key::new(
    "size",
    along_uv(Integer::within(2, MAX_SIZE)),
    Fallback([256, 256]),
    "with `procedural`",
)
.unit("samples");
/// `true` stands for codes.
pub const BITS: Key<Codes<bool>, Fallback<bool>> = Key::new(
    "bits",
    Codes(&[(16, true), (32, false)]),
    Fallback(true),
    "with `procedural`; 16: codes; 32: floats",
);
pub const VALUE: Key<Number, Fallback<f64>> =
    Key::new("value", Number::Within(0.0, 1.0), Fallback(0.0), "height, with `\"flat\"`");
pub const STUDS: Key<Each<Integer<u32>, 2>, Fallback<[u32; 2]>> = Key::new(
    "studs",
    along_uv(Integer::within(1, MAX_SIZE)),
    Fallback([8, 8]),
    "along u and v, with `\"studded\"`",
);
pub const OCTAVES: Key<Integer<u32>, Fallback<u32>> =
    Key::new("octaves", Integer::within(1, 16), Fallback(6), "with `\"fbm\"`");
pub const SEED: Key<Integer<u64>, Fallback<u64>> =
    Key::new("seed", Integer::SEED, Fallback(0), "with `\"fbm\"`");
pub const WAVES: Key<Integer<u32>, Fallback<u32>> = Key::new(
    "waves",
    Integer::within(1, MAX_SIZE),
    Fallback(4),
    "from the middle to the border, with `\"ripple\"`",
);
pub const GRID: Key<Choice<Lattice>, Optional> = Key::new(
    "grid",
    Choice(|| vec![("vertex", Lattice::Vertex), ("texel", Lattice::Texel)]),
    Optional("files `\"texel\"`, procedural `\"vertex\"`"),
    "where samples lie",
);
pub const WRAP: Key<Choice<Wrap>, Fallback<Wrap>> =
    Key::new("wrap", WRAPS, Fallback(Wrap::Repeat), "what lies beyond the border");
pub const LAYOUT: Key<Choice<Layout>, Fallback<Layout>> = Key::new(
    "layout",
    Choice(|| Layout::ALL.map(|l| (l.name(), l)).into()),
    Fallback(Layout::Default),
    "of the bounds; `\"default\"`: 0.27 byte a texel; `\"tiny\"`: 0.15; the picture is the same",
);
pub const DISTANCE_TABLE: Key<Form, Optional> =
    Key::new("distance", Form("table"), Optional("`{}`"), "for the `distance` methods, see below");

/// `[maps.NAME]`.
pub const MAPS: Section = Section {
    name: "maps",
    table: "maps.NAME",
    keys: &[
        &FILE,
        &INVERT,
        &PROCEDURAL,
        &SIZE,
        &BITS,
        &VALUE,
        &STUDS,
        &OCTAVES,
        &SEED,
        &WAVES,
        &GRID,
        &WRAP,
        &LAYOUT,
        &DISTANCE_TABLE,
    ],
};

pub const DISTANCE_SIZE: Key<Each<Integer<u32>, 3>, Optional> = Key::new(
    "size",
    Each { each: Integer::within(1, MAX_DISTANCE_SIZE), form: "[along x, along y, along z]" },
    Optional("from the map: at most 256 voxels or 128 steps along u and v, 32 along z"),
    "voxels or nodes; not with `file`",
);
pub const DISTANCE_BITS: Key<Codes<DistanceBits>, Optional> = Key::new(
    "bits",
    Codes(&[(8, DistanceBits::U8), (16, DistanceBits::U16)]),
    Optional("16"),
    "of a distance; not with `file`",
);
pub const DISTANCE_FILE: Key<Text, Optional> = Key::new(
    "file",
    Text("path"),
    Optional("none"),
    "a map that `rilievo bake` has written for exactly this height map, grid and wrap",
);

/// `distance` of a map.
pub const DISTANCE: Section = Section {
    name: "distance",
    table: "maps.NAME.distance",
    keys: &[&DISTANCE_SIZE, &DISTANCE_BITS, &DISTANCE_FILE],
};

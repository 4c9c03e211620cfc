//! Where shapes stand: transforms, `instances` and `scatter`.

use super::kind::{Each, Form, Integer, Number, Points, Span, along_uv};
use super::{Fallback, Key, Optional, Required, Section, motion};

/// Most places of a shape.
const MOST: u64 = 10_000_000;

/// Three numbers along or about the axes.
const fn xyz() -> Each<Number, 3> {
    Each { each: Number::Finite, form: "[x, y, z]" }
}

/// Three numbers along or about the axes.
type Triple = Key<Each<Number, 3>, Fallback<[f64; 3]>>;

pub const TRANSLATE: Triple =
    Key::new("translate", xyz(), Fallback([0.0; 3]), "moved last").unit("scene units");
pub const ROTATE: Triple =
    Key::new("rotate", xyz(), Fallback([0.0; 3]), "about x, then y, then z").unit("degrees");
pub const SCALE: Key<Number, Fallback<f64>> =
    Key::new("scale", Number::NotZero, Fallback(1.0), "first of all; negative mirrors");

/// `transform` of a mesh.
pub const TRANSFORM: Section = Section {
    name: "transform",
    table: "shapes[].transform",
    keys: &[&TRANSLATE, &ROTATE, &SCALE],
};

pub const INSTANCES: Key<Form, Optional> = Key::new(
    "instances",
    Form("array of tables"),
    Optional("none: once, where it is"),
    "one a place: the keys of a transform, `displacement` and `motion`",
);
pub const SCATTER_TABLE: Key<Form, Optional> = Key::new(
    "scatter",
    Form("table"),
    Optional("none"),
    "places strewn over a parallelogram; not with `instances`",
);

/// Places of any shape.
pub const PLACES: Section =
    Section { name: "places", table: "shapes[]", keys: &[&INSTANCES, &SCATTER_TABLE] };

pub const CHANGES: Key<Form, Optional> = Key::new(
    "displacement",
    Form("table"),
    Optional("those of the shape"),
    "`scale`, `zero`, `tile`, `shift`",
);

/// A place among `instances`.
pub const PLACE: Section = Section {
    name: "place",
    table: "shapes[].instances[]",
    keys: &[&TRANSLATE, &ROTATE, &SCALE, &CHANGES, &motion::OF_PLACE],
};

/// What holds of a number that a place does not change.
const OF_SHAPE: Optional = Optional("that of the shape");

pub const CHANGED_SCALE: Key<Number, Optional> =
    Key::new("scale", Number::NotZero, OF_SHAPE, "of a unit of height").unit("scene units");
pub const CHANGED_ZERO: Key<Number, Optional> =
    Key::new("zero", Number::Finite, OF_SHAPE, "height that stays in place");
pub const CHANGED_TILE: Key<Each<Number, 2>, Optional> =
    Key::new("tile", along_uv(Number::Above(0.0)), OF_SHAPE, "repetitions along u and v");
pub const CHANGED_SHIFT: Key<Each<Number, 2>, Optional> =
    Key::new("shift", along_uv(Number::Finite), OF_SHAPE, "along u and v").unit("repetitions");

/// `displacement` of a place.
pub const DISPLACEMENT: Section = Section {
    name: "place displacement",
    table: "shapes[].instances[].displacement",
    keys: &[&CHANGED_SCALE, &CHANGED_ZERO, &CHANGED_TILE, &CHANGED_SHIFT],
};

pub const COUNT: Key<Integer<u64>, Required> =
    Key::new("count", Integer::within(1, MOST), Required(""), "places");
pub const OVER: Key<Points<3>, Required> = Key::new(
    "over",
    Points("a corner and two edges: [[x, y, z], [x, y, z], [x, y, z]]"),
    Required(""),
    "a corner and two edges that span an area",
)
.unit("scene units");
pub const SIZES: Key<Span, Fallback<[f64; 2]>> =
    Key::new("scale", Span(Number::Above(0.0)), Fallback([1.0; 2]), "smallest and largest size");
pub const TURN: Key<Number, Fallback<f64>> =
    Key::new("turn", Number::Finite, Fallback(360.0), "about the normal, at most").unit("degrees");
pub const SEED: Key<Integer<u64>, Fallback<u64>> =
    Key::new("seed", Integer::SEED, Fallback(0), "of what is random");

/// `scatter` of a shape.
pub const SCATTER: Section = Section {
    name: "scatter",
    table: "shapes[].scatter",
    keys: &[&COUNT, &OVER, &SIZES, &TURN, &SEED],
};

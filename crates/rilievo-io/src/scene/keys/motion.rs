//! `motion` of shapes and of their places.

use rilievo::glam::DVec3;

use super::kind::{Form, Number, Point};
use super::{Fallback, Key, Optional, Section};

/// Most degrees of a turn: a thousand times round.
const MOST: f64 = 360_000.0;

pub const OF_SHAPE: Key<Form, Optional> = Key::new(
    "motion",
    Form("table"),
    Optional("at rest"),
    "how far it has gone at time 1, see `motion` of a shape",
);
pub const OF_PLACE: Key<Form, Optional> =
    Key::new("motion", Form("table"), Optional("at rest"), "of this place alone, in the world");

pub const TRANSLATE: Key<Point, Fallback<DVec3>> =
    Key::new("translate", Point::Position, Fallback(DVec3::ZERO), "how far it has gone at time 1")
        .unit("scene units");
pub const AXIS: Key<Point, Fallback<DVec3>> =
    Key::new("axis", Point::NotZero, Fallback(DVec3::Z), "about which it turns");
pub const ANGLE: Key<Number, Fallback<f64>> = Key::new(
    "angle",
    Number::Within(-MOST, MOST),
    Fallback(0.0),
    "how far it has turned at time 1, counter-clockwise seen against the axis",
)
.unit("degrees");
pub const PIVOT: Key<Point, Fallback<DVec3>> =
    Key::new("pivot", Point::Position, Fallback(DVec3::ZERO), "a point of the axis at time 0")
        .unit("scene units");
pub const PLACE_PIVOT: Key<Point, Optional> = Key::new(
    "pivot",
    Point::Position,
    Optional("`translate` of the place"),
    "a point of the axis at time 0",
)
.unit("scene units");

/// `motion` of a shape.
pub const SHAPE: Section = Section {
    name: "shape motion",
    table: "shapes[].motion",
    keys: &[&TRANSLATE, &AXIS, &ANGLE, &PIVOT],
};

/// `motion` of a place.
pub const PLACE: Section = Section {
    name: "place motion",
    table: "shapes[].instances[].motion",
    keys: &[&TRANSLATE, &AXIS, &ANGLE, &PLACE_PIVOT],
};

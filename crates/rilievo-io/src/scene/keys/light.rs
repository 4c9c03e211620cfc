//! `[[lights]]` and `[environment]`.

use rilievo::glam::DVec3;
use rilievo_render::light::Up;

use super::kind::{Choice, Colour, Grey, Number, Point, Text};
use super::{Fallback, Key, Required, Section};

/// The kinds of `[[lights]]`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightKind {
    Point,
    Spot,
    Sun,
}

pub const TYPE: Key<Choice<LightKind>, Required> = Key::new(
    "type",
    Choice(|| {
        vec![("point", LightKind::Point), ("spot", LightKind::Spot), ("sun", LightKind::Sun)]
    }),
    Required(""),
    "what it is",
);
pub const POSITION: Key<Point, Required> =
    Key::new("position", Point::Position, Required("of a point or spot"), "where it is")
        .unit("scene units");
pub const INTENSITY: Key<Colour, Required> =
    Key::new("intensity", Colour::Any, Required("of a point or spot"), "of a point or spot")
        .unit("W/sr");
pub const DIRECTION: Key<Point, Required> =
    Key::new("direction", Point::NotZero, Required("of a spot or sun"), "the way light goes");
pub const INNER_ANGLE: Key<Number, Fallback<f64>> = Key::new(
    "inner_angle",
    Number::AtLeast(0.0),
    Fallback(0.0),
    "from the axis of a spot; below `outer_angle`",
)
.unit("degrees");
pub const OUTER_ANGLE: Key<Number, Fallback<f64>> = Key::new(
    "outer_angle",
    Number::AboveUpTo(0.0, 90.0),
    Fallback(45.0),
    "from the axis of a spot",
)
.unit("degrees");
pub const IRRADIANCE: Key<Colour, Required> =
    Key::new("irradiance", Colour::Any, Required("of a sun"), "on a surface that faces the sun")
        .unit("W/m^2");
pub const ANGLE: Key<Number, Fallback<f64>> = Key::new(
    "angle",
    Number::Within(0.0, 180.0),
    Fallback(0.0),
    "across the sun's disc; 0: one direction",
)
.unit("degrees");

/// `[[lights]]`.
pub const LIGHTS: Section = Section {
    name: "lights",
    table: "lights[]",
    keys: &[
        &TYPE,
        &POSITION,
        &INTENSITY,
        &DIRECTION,
        &INNER_ANGLE,
        &OUTER_ANGLE,
        &IRRADIANCE,
        &ANGLE,
    ],
};

pub const FILE: Key<Text, Required> = Key::new(
    "file",
    Text("path"),
    Required(""),
    "OpenEXR, Radiance HDR, PFM, float TIFF: linear; PNG, TIFF, JPEG: sRGB",
);
pub const SCALE: Key<Grey, Fallback<DVec3>> =
    Key::new("scale", Grey, Fallback(DVec3::ONE), "of a texel of 1").unit("W/(sr m^2)");
pub const ROTATE: Key<Number, Fallback<f64>> = Key::new(
    "rotate",
    Number::Finite,
    Fallback(0.0),
    "about the up axis, counter-clockwise seen from above",
)
.unit("degrees");
pub const UP: Key<Choice<Up>, Fallback<Up>> = Key::new(
    "up",
    Choice(|| vec![("z", Up::Z), ("y", Up::Y)]),
    Fallback(Up::Z),
    "axis of the image's top",
);

/// `[environment]`.
pub const ENVIRONMENT: Section =
    Section { name: "environment", table: "environment", keys: &[&FILE, &SCALE, &ROTATE, &UP] };

//! `[camera]` and its motion.

use rilievo::glam::DVec3;
use rilievo_render::{Camera, Lens};

use super::kind::{Choice, Each, Form, Integer, Number, Point, Span};
use super::{Fallback, Key, Optional, Required, Section};

/// A projection by name, before its numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProjectionKind {
    Perspective,
    Orthographic,
    Panoramic,
}

/// The projections.
const PROJECTIONS: Choice<ProjectionKind> = Choice(|| {
    vec![
        ("perspective", ProjectionKind::Perspective),
        ("orthographic", ProjectionKind::Orthographic),
        ("panoramic", ProjectionKind::Panoramic),
    ]
});

/// Sides of a lens's opening.
const BLADE_RANGE: Integer<u32> = Integer::within(3, Lens::MAX_BLADES).or(0);

pub const POSITION: Key<Point, Required> =
    Key::new("position", Point::Position, Required(""), "where it is").unit("scene units");
pub const LOOK_AT: Key<Point, Required> =
    Key::new("look_at", Point::Position, Required(""), "another point than `position`")
        .unit("scene units");
pub const UP: Key<Point, Fallback<DVec3>> =
    Key::new("up", Point::Direction, Fallback(DVec3::Z), "not along the view");
pub const FOV: Key<Number, Fallback<f64>> =
    Key::new("fov", Number::Between(0.0, 180.0), Fallback(40.0), "angle of view, vertical")
        .unit("degrees");
pub const RESOLUTION: Key<Each<Integer<u32>, 2>, Fallback<[u32; 2]>> = Key::new(
    "resolution",
    Each { each: Integer::within(1, Camera::MAX_RESOLUTION), form: "[width, height]" },
    Fallback([512, 512]),
    "width and height",
)
.unit("pixels");
pub const PROJECTION: Key<Choice<ProjectionKind>, Fallback<ProjectionKind>> =
    Key::new("projection", PROJECTIONS, Fallback(ProjectionKind::Perspective), "see below");
pub const HEIGHT: Key<Number, Required> = Key::new(
    "height",
    Number::Above(0.0),
    Required("with `\"orthographic\"`"),
    "of the image; with `\"orthographic\"` only",
)
.unit("scene units");
pub const APERTURE: Key<Number, Optional> = Key::new(
    "aperture",
    Number::AtLeast(0.0),
    Optional("a pinhole"),
    "diameter of the lens; 0: a pinhole",
)
.unit("scene units");
pub const F_STOP: Key<Number, Optional> =
    Key::new("f_stop", Number::Above(0.0), Optional("none"), "in place of `aperture`");
pub const FOCUS_DISTANCE: Key<Number, Optional> = Key::new(
    "focus_distance",
    Number::Above(0.0),
    Optional("to `look_at`"),
    "along the view, to what is sharp",
)
.unit("scene units");
pub const BLADES: Key<Integer<u32>, Fallback<u32>> =
    Key::new("blades", BLADE_RANGE, Fallback(0), "sides of the lens's opening; 0: round");
pub const BLADE_ROTATION: Key<Number, Fallback<f64>> = Key::new(
    "blade_rotation",
    Number::Finite,
    Fallback(0.0),
    "counter-clockwise; at 0 a corner is to the right",
)
.unit("degrees");
pub const MOTION_TABLE: Key<Form, Optional> =
    Key::new("motion", Form("table"), Optional("at rest"), "its pose at time 1, see below");
pub const SHUTTER: Key<Span, Fallback<[f64; 2]>> = Key::new(
    "shutter",
    Span(Number::Within(0.0, 1.0)),
    Fallback([0.0, 1.0]),
    "times of all motions at which it opens and closes",
);

/// `[camera]`.
pub const CAMERA: Section = Section {
    name: "camera",
    table: "camera",
    keys: &[
        &POSITION,
        &LOOK_AT,
        &UP,
        &FOV,
        &RESOLUTION,
        &PROJECTION,
        &HEIGHT,
        &APERTURE,
        &F_STOP,
        &FOCUS_DISTANCE,
        &BLADES,
        &BLADE_ROTATION,
        &MOTION_TABLE,
        &SHUTTER,
    ],
};

/// What holds of a pose that does not change.
const AT_REST: Optional = Optional("that of `[camera]`");

pub const END_POSITION: Key<Point, Optional> =
    Key::new("position", Point::Position, AT_REST, "where it is at time 1").unit("scene units");
pub const END_LOOK_AT: Key<Point, Optional> =
    Key::new("look_at", Point::Position, AT_REST, "another point than `position`, all the way")
        .unit("scene units");
pub const END_UP: Key<Point, Optional> =
    Key::new("up", Point::Direction, AT_REST, "not along the view, all the way");

/// `motion` of a camera.
pub const MOTION: Section = Section {
    name: "motion",
    table: "camera.motion",
    keys: &[&END_POSITION, &END_LOOK_AT, &END_UP],
};

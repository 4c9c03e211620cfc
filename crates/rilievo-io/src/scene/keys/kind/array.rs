//! Arrays: points, colours, pairs.

use rilievo::glam::DVec3;

use super::super::super::syntax::Value;
use super::{Item, Kind, Number, Read, counted};
use crate::error::Result;

/// A place or a direction in space.
#[derive(Clone, Copy, Debug)]
pub enum Point {
    /// A place.
    Position,
    /// A direction; what is wrong with 0 others say.
    Direction,
    /// A direction that is not 0.
    NotZero,
}

impl Kind for Point {
    type Value = DVec3;

    fn name(&self) -> String {
        if matches!(self, Self::Position) { "point" } else { "direction" }.into()
    }

    fn allowed(&self) -> String {
        if matches!(self, Self::NotZero) { "not zero" } else { "finite" }.into()
    }

    fn written(&self, value: &DVec3) -> String {
        array(&value.to_array())
    }
}

impl Read for Point {
    fn read(&self, value: &Value<'_>) -> Result<DVec3> {
        match (self, DVec3::from_array(VECTOR.read(value)?)) {
            (Self::NotZero, DVec3::ZERO) => Err(value.invalid("a direction other than zero")),
            (_, point) => Ok(point),
        }
    }
}

/// Three coordinates.
const VECTOR: Each<Number, 3> = Each { each: Number::Finite, form: "[x, y, z]" };

/// A linear colour.
#[derive(Clone, Copy, Debug)]
pub enum Colour {
    /// Each channel at least 0.
    Any,
    /// Each channel from 0 to 1.
    Share,
}

impl Colour {
    fn channels(self) -> Each<Number, 3> {
        let each = match self {
            Self::Any => Number::AtLeast(0.0),
            Self::Share => Number::Within(0.0, 1.0),
        };
        Each { each, form: "[red, green, blue]" }
    }
}

impl Kind for Colour {
    type Value = DVec3;

    fn name(&self) -> String {
        "colour".into()
    }

    fn allowed(&self) -> String {
        self.channels().each.allowed()
    }

    fn written(&self, value: &DVec3) -> String {
        array(&value.to_array())
    }
}

impl Read for Colour {
    fn read(&self, value: &Value<'_>) -> Result<DVec3> {
        self.channels().read(value).map(DVec3::from_array)
    }
}

/// A colour, or a number for a grey.
#[derive(Clone, Copy, Debug)]
pub struct Grey;

impl Kind for Grey {
    type Value = DVec3;

    fn name(&self) -> String {
        "number or colour".into()
    }

    fn allowed(&self) -> String {
        Colour::Any.allowed()
    }

    fn written(&self, value: &DVec3) -> String {
        match value.to_array() {
            [r, g, b] if r == g && g == b => r.to_string(),
            rgb => array(&rgb),
        }
    }
}

impl Read for Grey {
    fn read(&self, value: &Value<'_>) -> Result<DVec3> {
        match value.number() {
            Ok(grey) if grey >= 0.0 => Ok(DVec3::splat(grey)),
            Ok(_) => Err(value.invalid("a number of at least 0, or three")),
            Err(_) => Colour::Any.read(value),
        }
    }
}

/// An array of `N` values of one kind.
#[derive(Clone, Copy, Debug)]
pub struct Each<K, const N: usize> {
    /// What each is.
    pub each: K,
    /// How they stand.
    pub form: &'static str,
}

/// Numbers along u and v.
pub const fn along_uv<K>(each: K) -> Each<K, 2> {
    Each { each, form: "[along u, along v]" }
}

impl<K: Item, const N: usize> Kind for Each<K, N> {
    type Value = [K::Value; N];

    fn name(&self) -> String {
        counted(N, &self.each.name())
    }

    fn allowed(&self) -> String {
        self.each.allowed()
    }

    fn written(&self, values: &Self::Value) -> String {
        let values: Vec<_> = values.iter().map(|value| self.each.written(value)).collect();
        format!("[{}]", values.join(", "))
    }
}

impl<K: Item, const N: usize> Read for Each<K, N> {
    fn read(&self, value: &Value<'_>) -> Result<Self::Value> {
        let allowed = format!("{}: {}", self.each.count(N), self.form);
        value.array::<_, N>(&allowed, |value| self.each.read(value))
    }
}

/// Points in an array of `N`: how they stand.
#[derive(Clone, Copy, Debug)]
pub struct Points<const N: usize>(pub &'static str);

impl<const N: usize> Kind for Points<N> {
    type Value = [DVec3; N];

    fn name(&self) -> String {
        counted(N, "point")
    }

    fn allowed(&self) -> String {
        "finite".into()
    }

    fn written(&self, points: &[DVec3; N]) -> String {
        format!("[{}]", points.map(|point| array(&point.to_array())).join(", "))
    }
}

impl<const N: usize> Read for Points<N> {
    fn read(&self, value: &Value<'_>) -> Result<[DVec3; N]> {
        value.array(self.0, |value| Point::Position.read(value))
    }
}

/// Two numbers, the smaller first.
#[derive(Clone, Copy, Debug)]
pub struct Span(pub Number);

impl Kind for Span {
    type Value = [f64; 2];

    fn name(&self) -> String {
        "two numbers".into()
    }

    fn allowed(&self) -> String {
        format!("{}, the smaller first", self.0.allowed())
    }

    fn written(&self, value: &[f64; 2]) -> String {
        array(value)
    }
}

impl Read for Span {
    fn read(&self, value: &Value<'_>) -> Result<[f64; 2]> {
        let allowed = format!("{}, the smaller first", self.0.count(2));
        let span = value.array::<_, 2>(&allowed, |value| self.0.read(value))?;
        if span[0] <= span[1] { Ok(span) } else { Err(value.invalid(allowed)) }
    }
}

fn array(values: &[f64]) -> String {
    let values: Vec<_> = values.iter().map(f64::to_string).collect();
    format!("[{}]", values.join(", "))
}

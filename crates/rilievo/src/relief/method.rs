//! [`Method`]: how a ray is walked through a relief.

use std::fmt;
use std::str::FromStr;

use crate::map::DistanceKind;

/// How a ray is walked through a relief. The exact methods give one answer, bit for bit: they
/// differ in which cells they show to the one leaf.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Method {
    /// Every cell under the ray, no hierarchy \[Musgrave1988\]. Exact.
    Dda,
    /// Min-max pyramid over blocks of 4 x 4 cells. Exact; the default.
    #[default]
    Pyramid,
    /// Steps through a box distance map, leaf near the surface. Exact.
    Distance,
    /// Steps through interpolated exact distances less the interpolation error, leaf near the
    /// surface. Exact.
    DistanceCorrected,
    /// The seed paper as it was \[Book2007\]: distances to texel points, interpolated, no leaf.
    /// Approximate: it misses at steps.
    DistancePublished,
    /// Fixed steps and one secant, as parallax occlusion mapping does. Approximate.
    March,
}

/// A name that is no method's.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no method is called {0:?}; there are {names}", names = Method::ALL.map(Method::name).join(", "))]
pub struct UnknownMethod(pub String);

impl Method {
    /// All methods, the exact ones first.
    pub const ALL: [Self; 6] = [
        Self::Dda,
        Self::Pyramid,
        Self::Distance,
        Self::DistanceCorrected,
        Self::DistancePublished,
        Self::March,
    ];

    /// Whether the method reports the oracle's hit for every ray.
    pub fn is_exact(self) -> bool {
        !matches!(self, Self::DistancePublished | Self::March)
    }

    /// The kind of distance map that the method walks, if it walks one.
    pub fn distance_kind(self) -> Option<DistanceKind> {
        match self {
            Self::Distance => Some(DistanceKind::Boxes),
            Self::DistanceCorrected => Some(DistanceKind::Corrected),
            Self::DistancePublished => Some(DistanceKind::Published),
            Self::Dda | Self::Pyramid | Self::March => None,
        }
    }

    /// The name used in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Dda => "dda",
            Self::Pyramid => "pyramid",
            Self::Distance => "distance",
            Self::DistanceCorrected => "distance-corrected",
            Self::DistancePublished => "distance-published",
            Self::March => "march",
        }
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Method {
    type Err = UnknownMethod;

    fn from_str(name: &str) -> Result<Self, UnknownMethod> {
        let found = Self::ALL.into_iter().find(|m| m.name() == name);
        found.ok_or_else(|| UnknownMethod(name.to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_back() {
        for method in Method::ALL {
            assert_eq!(method.name().parse(), Ok(method));
        }
        let error = "relief".parse::<Method>().unwrap_err().to_string();
        assert!(error.contains("distance-published"), "{error}");
    }
}

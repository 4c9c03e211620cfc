//! [`Aov`]: named images of the first hit, beside the colour.

use std::fmt;
use std::str::FromStr;

/// A quantity of the first hit of a camera ray. Vectors are in world space.
///
/// A pixel holds the mean over those of its samples that hit something and have no negative weight. Where none does, `P` is
/// NaN, `Z` is infinite and the others are 0. `Steps` is the mean over all samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Aov {
    /// Position, scene units.
    P,
    /// Geometric normal, towards the surface's front.
    N,
    /// Shading normal, towards the surface's front.
    Ns,
    /// Surface parameters.
    Uv,
    /// Map height `H`; 0 without displacement.
    Height,
    /// Work: pyramid or BVH nodes, cells and steps, added up.
    Steps,
    /// Depth along the view axis, of a panorama the distance; scene units.
    Z,
    /// Diffuse reflectance plus `reflective`.
    Albedo,
}

impl Aov {
    /// All layers.
    pub const ALL: [Self; 8] =
        [Self::P, Self::N, Self::Ns, Self::Uv, Self::Height, Self::Steps, Self::Z, Self::Albedo];

    /// The name on the command line: `P`, `N`, `Ns`, `UV`, `Height`, `Steps`, `Z` or `Albedo`.
    pub fn name(self) -> &'static str {
        match self {
            Self::P => "P",
            Self::N => "N",
            Self::Ns => "Ns",
            Self::Uv => "UV",
            Self::Height => "Height",
            Self::Steps => "Steps",
            Self::Z => "Z",
            Self::Albedo => "Albedo",
        }
    }

    /// The names of its channels in a file, in the order in which a pixel stores them: pbrt's
    /// (`GBufferFilm`), where it has such a layer.
    pub fn channels(self) -> &'static [&'static str] {
        match self {
            Self::P => &["P.X", "P.Y", "P.Z"],
            Self::N => &["N.X", "N.Y", "N.Z"],
            Self::Ns => &["Ns.X", "Ns.Y", "Ns.Z"],
            Self::Uv => &["u", "v"],
            Self::Height => &["Height.Y"],
            Self::Steps => &["Steps.Y"],
            Self::Z => &["Z"],
            Self::Albedo => &["Albedo.R", "Albedo.G", "Albedo.B"],
        }
    }

    /// What a channel holds where no sample hit anything.
    pub fn without_hit(self) -> f32 {
        match self {
            Self::P => f32::NAN,
            Self::Z => f32::INFINITY,
            _ => 0.0,
        }
    }
}

impl fmt::Display for Aov {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A name that no layer has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no layer is called \"{0}\"; there are P, N, Ns, UV, Height, Steps, Z and Albedo")]
pub struct UnknownAov(pub String);

impl FromStr for Aov {
    type Err = UnknownAov;

    fn from_str(name: &str) -> Result<Self, UnknownAov> {
        let found = Self::ALL.into_iter().find(|aov| aov.name() == name);
        found.ok_or_else(|| UnknownAov(name.to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_back_and_head_their_channels() {
        for aov in Aov::ALL {
            assert_eq!(aov.name().parse(), Ok(aov));
            // pbrt names the parameters by their letters alone.
            match aov {
                Aov::Uv => assert_eq!(aov.channels(), ["u", "v"]),
                _ => assert!(aov.channels().iter().all(|channel| channel.starts_with(aov.name()))),
            }
        }
        assert!("Depth".parse::<Aov>().is_err());
    }
}

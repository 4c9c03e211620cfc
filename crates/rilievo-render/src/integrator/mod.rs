//! [`Integrator`]: what a render estimates.

mod aov;
mod distributed;
mod path;
mod pixel;
mod trees;
mod wave;

pub(crate) use path::spread as path_spread;
pub(crate) use pixel::PixelTracer;
pub(crate) use wave::{OFFSPRING, Wave};

use std::fmt;
use std::ops::AddAssign;
use std::str::FromStr;

/// What a render estimates. Named in scene files and on the command line by its [`fmt::Display`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Integrator {
    /// Whitted's recursion with Cook's distributed samples: emission, direct light with soft
    /// shadows, glossy reflection. Diffuse interreflection only where a scene asks for it, so
    /// biased by design.
    Distributed,
    /// Paths with next event estimation and multiple importance sampling: all light, unbiased.
    Path,
    /// The first hit's geometry only; colour is the albedo under a headlight.
    Aov,
}

impl Integrator {
    /// All integrators.
    pub const ALL: [Self; 3] = [Self::Distributed, Self::Path, Self::Aov];

    /// Whether its pixels are sums of independent samples, which may be taken bit by bit: see
    /// [`mod@crate::render`].
    pub fn sums(self) -> bool {
        match self {
            Self::Path => true,
            Self::Distributed | Self::Aov => false,
        }
    }

    /// The name in scene files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Distributed => "distributed",
            Self::Path => "path",
            Self::Aov => "aov",
        }
    }
}

impl fmt::Display for Integrator {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Rays traced, by kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RayCounts {
    /// From the camera.
    pub camera: u64,
    /// Towards a light.
    pub shadow: u64,
    /// From a glossy surface or a mirror.
    pub reflection: u64,
    /// From a diffuse surface, to what lights it indirectly.
    pub diffuse: u64,
}

impl RayCounts {
    /// All rays.
    pub fn total(&self) -> u64 {
        self.camera + self.shadow + self.reflection + self.diffuse
    }
}

impl AddAssign for RayCounts {
    fn add_assign(&mut self, other: Self) {
        self.camera += other.camera;
        self.shadow += other.shadow;
        self.reflection += other.reflection;
        self.diffuse += other.diffuse;
    }
}

/// A name that no integrator has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no integrator is called \"{0}\"; there are \"distributed\", \"path\" and \"aov\"")]
pub struct UnknownIntegrator(pub String);

impl FromStr for Integrator {
    type Err = UnknownIntegrator;

    fn from_str(name: &str) -> Result<Self, UnknownIntegrator> {
        let found = Self::ALL.into_iter().find(|integrator| integrator.name() == name);
        found.ok_or_else(|| UnknownIntegrator(name.to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_back() {
        for integrator in Integrator::ALL {
            assert_eq!(integrator.to_string().parse(), Ok(integrator));
        }
        assert!("photon".parse::<Integrator>().is_err());
    }
}

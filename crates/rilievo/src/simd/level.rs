//! [`SimdLevel`]: proof that the processor has what a level needs.

use std::fmt;
use std::str::FromStr;
use std::sync::OnceLock;

use super::Kernel;
use super::portable::Portable;

/// A set of vector instructions that this processor has. All give the same bits.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct SimdLevel(Level);

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Level {
    Portable,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

/// A name that is no level's, or that of one this processor lacks.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no SIMD level {0:?} on this processor; there are {names}", names = names())]
pub struct UnknownSimdLevel(pub String);

fn names() -> String {
    let names: Vec<_> = SimdLevel::available().iter().map(|level| level.name()).collect();
    names.join(", ")
}

impl SimdLevel {
    /// The level that runs anywhere.
    pub const PORTABLE: Self = Self(Level::Portable);

    /// All levels that this processor has, slowest first.
    pub fn available() -> &'static [Self] {
        static FOUND: OnceLock<Vec<SimdLevel>> = OnceLock::new();
        FOUND.get_or_init(|| {
            let mut found = vec![Self::PORTABLE];
            found.extend(Self::of_x86());
            found
        })
    }

    /// The levels of this x86 processor.
    #[cfg(target_arch = "x86_64")]
    fn of_x86() -> Vec<Self> {
        let mut found = Vec::new();
        if std::arch::is_x86_feature_detected!("avx2")
            && std::arch::is_x86_feature_detected!("bmi1")
            && std::arch::is_x86_feature_detected!("bmi2")
            && std::arch::is_x86_feature_detected!("lzcnt")
            && std::arch::is_x86_feature_detected!("popcnt")
        {
            found.push(Self(Level::Avx2));
            if std::arch::is_x86_feature_detected!("avx512f")
                && std::arch::is_x86_feature_detected!("avx512bw")
                && std::arch::is_x86_feature_detected!("avx512dq")
                && std::arch::is_x86_feature_detected!("avx512vl")
            {
                found.push(Self(Level::Avx512));
            }
        }
        found
    }

    /// None: this is no x86 processor.
    #[cfg(not(target_arch = "x86_64"))]
    fn of_x86() -> Vec<Self> {
        Vec::new()
    }

    /// The fastest level of this processor.
    pub fn detect() -> Self {
        Self::available().last().copied().unwrap_or(Self::PORTABLE)
    }

    /// The name used on the command line.
    pub fn name(self) -> &'static str {
        match self.0 {
            Level::Portable => "portable",
            #[cfg(target_arch = "x86_64")]
            Level::Avx2 => "avx2",
            #[cfg(target_arch = "x86_64")]
            Level::Avx512 => "avx512",
        }
    }

    /// Runs a kernel at this level.
    #[inline]
    pub(super) fn enter<K: Kernel>(self, kernel: K) -> K::Output {
        match self.0 {
            Level::Portable => kernel.run::<Portable>(),
            #[cfg(target_arch = "x86_64")]
            // SAFETY: a level other than portable is made in `available` only, after the processor
            // was asked for every feature that the function is compiled with.
            Level::Avx2 => unsafe { super::avx2::enter(kernel) },
            #[cfg(target_arch = "x86_64")]
            // SAFETY: as above.
            Level::Avx512 => unsafe { super::avx512::enter(kernel) },
        }
    }
}

impl Default for SimdLevel {
    fn default() -> Self {
        Self::detect()
    }
}

impl fmt::Debug for SimdLevel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl fmt::Display for SimdLevel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for SimdLevel {
    type Err = UnknownSimdLevel;

    fn from_str(name: &str) -> Result<Self, UnknownSimdLevel> {
        let found = Self::available().iter().find(|level| level.name() == name);
        found.copied().ok_or_else(|| UnknownSimdLevel(name.to_owned()))
    }
}

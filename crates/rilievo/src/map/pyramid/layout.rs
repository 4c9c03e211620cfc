//! [`Layout`]: how a pyramid stores its bounds.

use std::fmt;
use std::str::FromStr;

/// How a pyramid stores its bounds. Every layout gives the same hits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Layout {
    /// `u16` codes: 0.27 byte a texel, exact for `u16` heights.
    #[default]
    Default,
    /// `u8` codes relative to the range of their node: 0.15 byte a texel.
    Tiny,
}

/// A name that is no layout's.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no layout is called {0:?}; there are {names}", names = Layout::ALL.map(Layout::name).join(", "))]
pub struct UnknownLayout(pub String);

impl Layout {
    /// All layouts.
    pub const ALL: [Self; 2] = [Self::Default, Self::Tiny];

    /// The name used in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Default => "default",
            Self::Tiny => "tiny",
        }
    }

    /// Bits of a stored bound.
    pub fn bits(self) -> u32 {
        match self {
            Self::Default => 16,
            Self::Tiny => 8,
        }
    }

    /// Bytes of a node.
    pub fn node_bytes(self) -> u64 {
        match self {
            Self::Default => 64,
            Self::Tiny => 36,
        }
    }
}

impl fmt::Display for Layout {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Layout {
    type Err = UnknownLayout;

    fn from_str(name: &str) -> Result<Self, UnknownLayout> {
        let found = Self::ALL.into_iter().find(|l| l.name() == name);
        found.ok_or_else(|| UnknownLayout(name.to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_back() {
        for layout in Layout::ALL {
            assert_eq!(layout.to_string().parse(), Ok(layout));
        }
        let error = "huge".parse::<Layout>().unwrap_err().to_string();
        assert!(error.contains("default, tiny"), "{error}");
    }
}

//! Names of closed sets that the library does not name itself, as printed and as typed.

use rilievo::map::{DistanceKind, Lattice, NormalConvention, Wrap};

pub fn lattice(lattice: Lattice) -> &'static str {
    match lattice {
        Lattice::Texel => "texel",
        Lattice::Vertex => "vertex",
    }
}

pub fn wrap(wrap: Wrap) -> &'static str {
    match wrap {
        Wrap::Repeat => "repeat",
        Wrap::Clamp => "clamp",
        Wrap::Mirror => "mirror",
    }
}

pub fn distance_kind(kind: DistanceKind) -> &'static str {
    match kind {
        DistanceKind::Published => "published",
        DistanceKind::Boxes => "boxes",
        DistanceKind::Corrected => "corrected",
    }
}

pub fn convention(convention: NormalConvention) -> &'static str {
    match convention {
        NormalConvention::OpenGl => "opengl",
        NormalConvention::DirectX => "directx",
    }
}

//! Images on surfaces, and the inputs of materials that they make.
//!
//! An image keeps the depth of its file ([`ColourImage`]); a [`Texture`] lays it over uv; an input
//! ([`ColourInput`], [`NumberInput`], [`NormalInput`]) is a constant, or a constant times a texture.
//! Whether codes are sRGB or linear is the image's to know: colours are sRGB, all else is linear. Images that memory is too small for
//! lie in tiles elsewhere, and a [`TileCache`] brings in those that are looked at.

mod cache;
mod coarser;
mod image;
mod input;
mod texels;
mod tiled;

pub use cache::{TileCache, TileSource};
pub use image::ColourImage;
pub use input::{Channel, ColourInput, NormalInput, NumberInput};
pub(crate) use texels::ImageLevel;
pub use texels::{Texels, TextureError};

use std::sync::Arc;

use glam::{DMat2, DVec2};
use rilievo::Hit;
use rilievo::map::Wrap;

use crate::colour::Rgb;

/// What one sample covers of a surface: where textures are looked up, how far around, and what of the relief
/// there is not shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Footprint {
    /// The place.
    pub uv: DVec2,
    /// Extent along u and v; 0 for a point.
    pub width: DVec2,
    /// Variance of slopes, along all directions together, that the surface does not show: it makes lobes
    /// wider.
    pub lost_slopes: f64,
}

impl Footprint {
    /// A point.
    pub fn point(uv: DVec2) -> Self {
        Self { uv, width: DVec2::ZERO, lost_slopes: 0.0 }
    }

    /// A square of side `width`, in scene units, at a hit: its extent along u and v is that on the
    /// base surface. That it is longer along the view at a grazing angle is left out: samples of
    /// neighbouring pixels take the mean there, and the picture stays sharp.
    pub fn of(hit: &Hit, width: f64) -> Self {
        let along = |tangent: glam::DVec3| {
            let length = tangent.length();
            if length > 0.0 { width / length } else { 0.0 }
        };
        Self { uv: hit.uv, width: DVec2::from(hit.tangents.map(along)), lost_slopes: 0.0 }
    }
}

/// An image laid over the uv square of a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// The image, shared by all materials that use it.
    pub image: Arc<ColourImage>,
    /// Repetitions of the image over `u` and `v` in `[0, 1]`.
    pub tile: DVec2,
    /// Cosine and sine of the angle by which `uv * tile` is turned about the origin, from u to v.
    pub turn: DVec2,
    /// Added to the turned `uv * tile`.
    pub shift: DVec2,
    /// What lies beyond the borders along u and v.
    pub wrap: [Wrap; 2],
}

impl Texture {
    /// The image laid over `[0, 1]^2` once, and repeated.
    pub fn new(image: Arc<ColourImage>) -> Self {
        let (tile, turn, shift) = (DVec2::ONE, DVec2::X, DVec2::ZERO);
        Self { image, tile, turn, shift, wrap: [Wrap::Repeat; 2] }
    }

    /// Whether every number is finite.
    pub fn is_finite(&self) -> bool {
        self.tile.is_finite() && self.turn.is_finite() && self.shift.is_finite()
    }

    /// Where `uv` lies on the image.
    fn place(&self, uv: DVec2) -> DVec2 {
        let p = uv * self.tile;
        self.turn.rotate(p) + self.shift
    }

    /// The linear colour at `uv`.
    pub fn lookup(&self, uv: DVec2) -> Rgb {
        self.image.lookup_wrapped(self.place(uv), self.wrap)
    }

    /// The mean linear colour over a footprint.
    pub fn mean(&self, at: &Footprint) -> Rgb {
        if at.width == DVec2::ZERO {
            return self.lookup(at.uv);
        }
        let spread = DMat2::from_cols(self.turn, self.turn.perp());
        let width = spread.abs() * (at.width * self.tile).abs();
        self.image.lookup_mean(self.place(at.uv), width, self.wrap)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corners() -> Arc<ColourImage> {
        let texels = vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 1.0, 1.0]];
        Arc::new(ColourImage::new(2, 2, Texels::Linear(texels)).unwrap())
    }

    #[test]
    fn it_repeats() {
        let shift = DVec2::new(-1.0, 3.0);
        let texture = Texture { tile: DVec2::splat(2.0), shift, ..Texture::new(corners()) };
        for uv in [DVec2::new(0.1, 0.2), DVec2::new(0.9, 0.4), DVec2::ZERO, DVec2::ONE] {
            let plain = texture.image.lookup(uv * 2.0);
            assert!((texture.lookup(uv) - plain).abs().max_element() < 1e-12);
        }
        assert_eq!(texture.lookup(DVec2::NAN), Rgb::ZERO);
    }

    #[test]
    fn it_turns() {
        // A quarter turn takes the u axis to the v axis.
        let turned = Texture { turn: DVec2::Y, ..Texture::new(corners()) };
        for uv in [DVec2::new(0.1, 0.2), DVec2::new(0.9, 0.4)] {
            let plain = turned.image.lookup(DVec2::new(-uv.y, uv.x));
            assert!((turned.lookup(uv) - plain).abs().max_element() < 1e-12);
        }
    }

    #[test]
    fn wide_footprints_show_the_mean() {
        let texture = Texture { tile: DVec2::splat(3.0), ..Texture::new(corners()) };
        let at = Footprint { width: DVec2::splat(2.0), ..Footprint::point(DVec2::splat(0.3)) };
        assert!((texture.mean(&at) - 0.5).abs().max_element() < 1e-6);
        let point = Footprint::point(at.uv);
        assert_eq!(texture.mean(&point), texture.lookup(at.uv));
    }
}

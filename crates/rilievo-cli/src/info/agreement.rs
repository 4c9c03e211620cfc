//! How a normal map agrees with heights, as `rilievo info` tells it.

use rilievo::map::NormalAgreement;
use serde::Serialize;

use crate::args::Talk;
use crate::name;

/// Part of a JSON object. Angles are degrees.
#[derive(Serialize)]
pub struct Report {
    /// Correlation of the slopes along u and v.
    correlation: [f64; 2],
    /// `opengl`, `directx`, or null where the slopes do not tell.
    convention: Option<&'static str>,
    /// Whether the normals take black for high.
    inverted: bool,
    /// The depth of heights 0 to 1 that fits best, in widths of the map.
    depth: f64,
    mean_degrees: f64,
    median_degrees: f64,
    percentile_95_degrees: f64,
    /// Mean angle of the author's normals to the flat face.
    flat_degrees: f64,
}

impl From<NormalAgreement> for Report {
    fn from(a: NormalAgreement) -> Self {
        Self {
            correlation: a.correlation,
            convention: a.convention.map(name::convention),
            inverted: a.inverted,
            depth: a.depth,
            mean_degrees: a.mean,
            median_degrees: a.median,
            percentile_95_degrees: a.percentile_95,
            flat_degrees: a.flat,
        }
    }
}

impl Report {
    /// Tells it in two lines.
    pub fn tell(&self, talk: Talk) {
        let green = match self.convention {
            Some("directx") => "DirectX, green points down",
            Some(_) => "OpenGL, green points up",
            None => "green cannot be told",
        };
        let [x, y] = self.correlation;
        let black = if self.inverted { "; black is high" } else { "" };
        talk.line(format_args!(
            "normals     {green}{black}; slopes correlate {x:.3} along u, {y:.3} along v"
        ));
        talk.line(format_args!(
            "agreement   at a depth of {:.4} of the width: mean {:.2}, median {:.2}, 95 % below {:.2} \
             degrees (flat: mean {:.2})",
            self.depth,
            self.mean_degrees,
            self.median_degrees,
            self.percentile_95_degrees,
            self.flat_degrees
        ));
    }
}

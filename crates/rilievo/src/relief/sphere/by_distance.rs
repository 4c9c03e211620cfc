//! [`by_distance`]: steps through the distance map of a face of the cube, the exact leaf near the
//! surface.
//!
//! A segment is straight in x and y. Its distance from the centre is `r(s) = N(s) / q(s)`, with N
//! convex and q linear, so `r` is not. It is cut into pieces and each is taken for its chord in `(x, y, raw
//! height)`: a line with an error in height alone, for the walk that meshes share (`corridor`).
//!
//! **Error of a chord.** Over a piece of length d the chord is off by at most `d^2 / 8 max |r''|`, and
//!
//! ```text
//! r'' = N''/q - 2 N' q'/q^2 + 2 N q'^2/q^3,    |N'| <= c,    0 <= N'' <= c^2 / n
//! ```
//!
//! with c the length of N's vector per s. Pieces are made so many that this is a sixteenth of the
//! depth of the relief, but at most [`MOST_PIECES`].
//!
//! **Error of the surface.** A distance map knows raw heights, and bounds them by columns. Between lattice
//! points the surface is `1/Q` with Q bilinear, not `r`: it sinks up to `1/n^2` below the lowest corner
//! of a cell and nowhere rises above the highest (`radii`), which the columns of boxes cover with that much
//! added. Distances of kind `Corrected` are measured to bilinear heights: a weighted
//! harmonic mean of radii from a to b is below the arithmetic one by at most `(b - a)^2 / 4a`, and
//! the weights of the corners, N over its sum, are off by at most `2 / n` of themselves.
//!
//! **No miss.** All this is in the line's error, with the leaf's rounding as `sweep` counts it. So a part
//! left out is clear of the surface by more than the leaf can err, and cells of which only a part was
//! left out are shown whole: the result is that of every cell, bit for bit.

use super::radii::Radii;
use super::segment::{Root, Segment};
use super::walk::among_cells;
use crate::map::{DistanceKind, DistanceMap, HeightMap};
use crate::probe::Probe;
use crate::relief::corridor::{Corridor, Line};

/// Pieces of a segment at most.
const MOST_PIECES: f64 = 64.0;

/// Errors of a chord wanted, as a share of the relief's depth.
const SHARE: f64 = 1.0 / 16.0;

/// By how much cells and stretches are widened for rounding, in cells and in s.
const BESIDE: f64 = 1e-9;

/// The first crossing under a segment, no farther than `end`.
#[inline(never)]
pub(super) fn by_distance<P: Probe>(
    segment: &Segment<'_>,
    (heights, distances, radii): (&HeightMap, &DistanceMap, &Radii),
    end: f64,
    probe: &mut P,
) -> Option<Root> {
    let curve = Curve::new(segment, radii);
    let surface = surface_error(heights, distances.kind(), radii);
    let pieces = curve.pieces(radii);
    for k in 0..pieces as u32 {
        let piece = [k, k + 1].map(|k| f64::from(k) / pieces);
        if piece[0] > end {
            return None;
        }
        let line = curve.line(piece, (radii, surface));
        let corridor = Corridor::new(distances, line, piece);
        let mut s = piece[0];
        while s < piece[1] {
            probe.step();
            let look = corridor.look(s, piece[1]);
            if corridor.leads_on(&look, s) {
                s = look.safe;
                continue;
            }
            let [from, to] = look.near;
            if from <= to {
                let part = [(from - BESIDE).max(0.0), (to + BESIDE).min(1.0)];
                if let Some(root) = among_cells(segment, radii.cells, part, probe) {
                    return Some(root);
                }
            }
            s = corridor.past(&look, s);
        }
    }
    None
}

/// By how much the surface is off what a distance map knows, as a distance from the centre.
fn surface_error(heights: &HeightMap, kind: DistanceKind, radii: &Radii) -> f64 {
    let n = f64::from(radii.cells);
    let sink = radii.highest / (n * n);
    let rounding = 4.0 * radii.roof * (radii.above - 1.0);
    let bend = match kind {
        DistanceKind::Boxes | DistanceKind::Published => 0.0,
        DistanceKind::Corrected => {
            let (low, high) = heights.raw_range();
            let depth = (radii.per_raw * (f64::from(high) - f64::from(low))).abs();
            0.25 * depth * depth / radii.lowest + 2.0 * depth / n
        }
    };
    sink + rounding + bend
}

/// The distance from the centre along a segment.
struct Curve<'a> {
    segment: &'a Segment<'a>,
    /// `N^2` by powers of s.
    square: [f64; 3],
    /// Bound on the second derivative over all of the segment.
    bend: f64,
}

impl<'a> Curve<'a> {
    fn new(segment: &'a Segment<'a>, radii: &Radii) -> Self {
        let square = segment.square();
        let n = f64::from(radii.cells);
        let (from, to) = (segment.q(0.0), segment.q(1.0));
        let (q, change) = (from.min(to), (to - from).abs());
        let across = square[2].sqrt();
        let farthest = square[0].max(square[0] + square[1] + square[2]).sqrt();
        let bend = across * across / (n * q)
            + 2.0 * across * change / (q * q)
            + 2.0 * farthest * change * change / (q * q * q);
        Self { segment, square, bend }
    }

    /// How many pieces the segment is cut into.
    fn pieces(&self, radii: &Radii) -> f64 {
        let wanted = SHARE * (radii.highest - radii.lowest);
        let pieces = (0.125 * self.bend / wanted).sqrt().ceil();
        if pieces < MOST_PIECES { pieces.max(1.0) } else { MOST_PIECES }
    }

    /// Raw height at s.
    fn raw(&self, s: f64, radii: &Radii) -> f64 {
        let [c, b, a] = self.square;
        let distance = ((a * s + b) * s + c).sqrt() / self.segment.q(s);
        (distance - radii.at_zero) / radii.per_raw
    }

    /// The chord of a piece.
    fn line(&self, [from, to]: [f64; 2], (radii, surface): (&Radii, f64)) -> Line {
        let (low, high) = (self.raw(from, radii), self.raw(to, radii));
        let speed = (high - low) / (to - from);
        let length = to - from;
        let error = 0.125 * length * length * self.bend + surface;
        let [x, y] = self.segment.origin;
        let [dx, dy] = self.segment.slope;
        Line {
            start: [x, y, low - from * speed],
            speed: [dx, dy, speed],
            error: [BESIDE, BESIDE, error / radii.per_raw.abs()],
        }
    }
}

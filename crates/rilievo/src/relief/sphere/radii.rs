//! [`Radii`]: raw heights as distances from the centre, and as the `q` of the projective frame.
//!
//! Over a face the surface is `q(x, y)`, bilinear in the cells' coordinates, with `q = n / Z` and
//! `q = |d| / r` at a lattice point: `d = (2 i - n, 2 j - n, n)` is its direction and `r` its distance
//! from the centre, radius plus offset. `|d|^2` is a sum of squares of whole numbers below 2^53,
//! exact in any order, so a lattice point has one `q`, whichever face asks.
//!
//! **Range (proof).** `N(x, y) = |(2 x - n, 2 y - n, n)|` is convex along x and along y, so its
//! bilinear interpolation is not below it, and not above it by more than `N / n^2`: its second
//! derivatives along x and y are at most `4 / n` each and an interpolation over a step of 1 errs by an
//! eighth of them, one after the other, together `1 / n <= N / n^2`. Let the corners of a cell lie
//! between `low` and `high`. Then `N / high <= q <= (N + N / n^2) / low` over the cell, so the surface,
//! `N / q` from the centre, lies between `low / (1 + 1 / n^2)` and `high`.

use crate::map::cube_direction;
use crate::relief::sphere::CubeRelief;

/// A relief's radii, and the slacks that go with them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Radii {
    /// Cells along a side of a face.
    pub cells: u32,
    /// Distance from the centre at raw height 0, and its change for one raw unit.
    pub at_zero: f64,
    pub per_raw: f64,
    /// Smallest and largest distance of a lattice point.
    pub lowest: f64,
    pub highest: f64,
    /// The middle between them, and the largest magnitude of a raw height.
    pub middle: f64,
    pub largest_raw: f64,
    /// Two balls between which the surface lies, clear of both by 2^-30 of their radius.
    pub floor: f64,
    pub roof: f64,
    /// By how much a squared radius counts more than it is when a ray is to pass above, relative;
    /// and less, by flat cells too, when it is to pass below.
    pub above: f64,
    pub below: f64,
    /// Largest relative change of q over a cell.
    pub variation: f64,
}

impl Radii {
    /// Those of heights laid on a sphere by `scale * (H - zero)`.
    pub fn new(relief: &CubeRelief, radius: f64, scale: f64, zero: f64) -> Self {
        let (at_zero, per_raw) = (radius - scale * zero, scale * relief.unit());
        let (low, high) = relief.raw_range();
        let [a, b] = [low, high].map(|raw| at_zero + per_raw * f64::from(raw));
        let (lowest, highest) = (a.min(b), a.max(b));
        let n = f64::from(relief.cells());
        let flat = 1.0 + 1.0 / (n * n);
        // |d| changes by at most 1 / n of itself from one end of a cell to the other, along x and
        // along y.
        let variation = (highest / lowest) * (1.0 + 2.0 / n) - 1.0;
        // The leaf's own rounding is some 2^-50 of q, and n 2^-52 of a cell where a coordinate is
        // set to the line nearby: 64 times that.
        let slack = 2.0f64.powi(-40) + 64.0 * f64::EPSILON * n * variation;
        let clear = 2.0f64.powi(-30);
        Self {
            cells: relief.cells(),
            at_zero,
            per_raw,
            lowest,
            highest,
            middle: 0.5 * (lowest + highest),
            largest_raw: f64::from(low.abs().max(high.abs())),
            floor: lowest / flat * (1.0 - clear),
            roof: highest * (1.0 + clear),
            above: 1.0 + slack,
            below: (1.0 - slack) / (flat * flat),
            variation,
        }
    }

    /// Whether the surface stays clear of the centre, and finite.
    pub fn are_valid(&self) -> bool {
        self.floor >= 1e-100 && self.roof <= 1e100
    }

    /// Distance from the centre of a raw height.
    #[inline(always)]
    pub fn radius(&self, raw: f64) -> f64 {
        self.at_zero + self.per_raw * raw
    }

    /// q at the corners h00, h10, h01, h11 of cell (i, j) of any face.
    #[inline(always)]
    pub fn corners(&self, [i, j]: [u32; 2], raw: [f32; 4]) -> [f64; 4] {
        let n = f64::from(self.cells);
        let [x, y, _] = cube_direction(self.cells, [i, j, 0]);
        let (x0, x1, y0, y1) = (x * x, (x + 2.0) * (x + 2.0), y * y, (y + 2.0) * (y + 2.0));
        let squares = [x0 + y0, x1 + y0, x0 + y1, x1 + y1];
        let mut q = [0.0; 4];
        for k in 0..4 {
            q[k] = (n * n + squares[k]).sqrt() / self.radius(f64::from(raw[k]));
        }
        q
    }
}

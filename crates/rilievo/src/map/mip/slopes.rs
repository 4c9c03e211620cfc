//! [`LostSlopes`]: how much the slopes of a map vary where a level of it shows none of that.
//!
//! Within a bilinear cell the slope along x goes evenly from that of its lower edge, `a`, to that of its upper,
//! `b`: its mean square is `(a^2 + a b + b^2) / 3`. The mean of that over the full map's cells under a cell of a
//! level, less that of the level's cell itself, is the variance lost there; less than nothing counts as nothing.
//! Slopes along x and along y are kept, their product is not: what is shaded is round.

use super::super::height::HeightMap;
use super::super::lattice::Axis;
use super::average::{Windows, averages};

/// Largest code.
const CODES: f64 = 255.0;

/// Variances of slopes that a level of a map lost, a pair for each of its stored cells; two bytes each.
#[derive(Clone, Debug)]
pub struct LostSlopes {
    axes: [Axis; 2],
    /// Standard deviations, as parts of the largest.
    codes: Vec<[u8; 2]>,
    /// Standard deviation of code 1.
    steps: [f64; 2],
}

impl LostSlopes {
    /// What maps lost that stand for the full one.
    pub(crate) fn of_levels(full: &HeightMap, levels: &[HeightMap]) -> Vec<Self> {
        let windows: Vec<[Windows; 2]> = (levels.iter())
            .map(|level| [under_cells(full.x(), level.x()), under_cells(full.y(), level.y())])
            .collect();
        let size = [full.x().cells(), full.y().cells()];
        let squares = [0, 1].map(|axis| {
            averages(size, &windows, |j, row| {
                for (i, square) in (0..).zip(row) {
                    *square = mean_square_slope(full, [i, j], axis);
                }
            })
        });
        let [along_x, along_y] = squares;
        let squares = along_x.into_iter().zip(along_y);
        levels.iter().zip(squares).map(|(level, (x, y))| Self::of(level, [x, y])).collect()
    }

    /// What one map lost that stands for the full one.
    pub(crate) fn of_level(full: &HeightMap, level: &HeightMap) -> Self {
        Self::of_levels(full, std::slice::from_ref(level)).swap_remove(0)
    }

    /// Of a level under whose cells the full map has these mean square slopes along x and y.
    fn of(level: &HeightMap, full: [Vec<f64>; 2]) -> Self {
        let axes = [*level.x(), *level.y()];
        let [width, height] = axes.map(|axis| axis.cells());
        let cells = (0..height).flat_map(|j| (0..width).map(move |i| [i, j]));
        let deviations: Vec<[f64; 2]> = (cells.enumerate())
            .map(|(at, cell)| {
                [0, 1].map(|axis| {
                    let lost = full[axis][at] - mean_square_slope(level, cell, axis);
                    lost.max(0.0).sqrt()
                })
            })
            .collect();
        let steps =
            [0, 1].map(|k| deviations.iter().fold(0.0, |most: f64, d| most.max(d[k])) / CODES);
        let code = |d: [f64; 2]| {
            [0, 1].map(|k| if steps[k] > 0.0 { (d[k] / steps[k]).round() as u8 } else { 0 })
        };
        Self { axes, codes: deviations.into_iter().map(code).collect(), steps }
    }

    /// Variances of `dH/du` and `dH/dv` lost at an unfolded cell of the level; right to a code of the largest
    /// standard deviation, of which there are 255.
    #[inline]
    pub fn at(&self, cell: [i32; 2]) -> [f64; 2] {
        let [x, y] = [0, 1].map(|k| self.axes[k].run(cell[k]).stored(cell[k]) as usize);
        let codes = self.codes[y * self.axes[0].cells() as usize + x];
        [0, 1].map(|k| {
            let deviation = f64::from(codes[k]) * self.steps[k];
            deviation * deviation
        })
    }

    /// Bytes held.
    pub fn bytes(&self) -> u64 {
        size_of_val(self.codes.as_slice()) as u64
    }
}

/// Mean square of `dH/du` or, for axis 1, `dH/dv` over a stored cell.
pub(super) fn mean_square_slope(map: &HeightMap, [i, j]: [u32; 2], axis: usize) -> f64 {
    let [h00, h10, h01, h11] = map.stored_corners(i, j).map(f64::from);
    let (a, b, period) = match axis {
        0 => (h10 - h00, h11 - h01, map.x().period()),
        _ => (h01 - h00, h11 - h10, map.y().period()),
    };
    let per_cell = map.unit() * f64::from(period);
    per_cell * per_cell * (a * a + a * b + b * b) / 3.0
}

/// The stored cells of one axis under each stored cell of another that spans the same.
fn under_cells(full: &Axis, level: &Axis) -> Windows {
    let first = f64::from(full.first_cell());
    let border = |cell: u32| {
        let at = level.parameter(f64::from(level.first_cell()) + f64::from(cell));
        full.coordinate(at) - first
    };
    // Where a map repeats, its stored cells are one repetition.
    let wraps = full.cells() == full.period();
    Windows::new(full.cells(), wraps, (0..level.cells()).map(|c| [border(c), border(c + 1)]))
}

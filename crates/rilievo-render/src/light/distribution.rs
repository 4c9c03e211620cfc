//! [`Distribution`]: a piecewise constant density over the cells of a grid, drawn by inverting
//! cumulative sums: first the row, then the cell in it. Neighbouring numbers give neighbouring cells,
//! so what is even about the numbers stays even on the grid; an alias table would lose that.

use glam::DVec2;

/// A density over the cells of a grid. The share of a cell is the difference of its stored sums,
/// rounding included, so that drawing and density agree to the last bit.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Distribution {
    pub(super) columns: usize,
    /// Shares of the rows before each, and 1.
    pub(super) rows: Vec<f32>,
    /// For each row the shares of its cells before each, and 1: `columns + 1` numbers a row.
    pub(super) cells: Vec<f32>,
}

impl Distribution {
    /// The density in proportion to `weights`, row by row, finite and at least 0; nothing where all
    /// are 0.
    pub(super) fn new(columns: usize, weights: &[f64]) -> Option<Self> {
        let rows = weights.chunks_exact(columns);
        let mut cells = Vec::with_capacity(weights.len() + rows.len());
        let mut sums = Vec::with_capacity(rows.len());
        for row in rows {
            sums.push(row.iter().sum());
            append(row, &mut cells);
        }
        let mut rows = Vec::with_capacity(sums.len() + 1);
        let total: f64 = sums.iter().sum();
        append(&sums, &mut rows);
        (total > 0.0).then_some(Self { columns, rows, cells })
    }

    /// The cell (column, row) for `u` in `[0, 1)^2`, the place in it, and its share.
    pub(super) fn sample(&self, u: DVec2) -> ([usize; 2], DVec2, f64) {
        let (row, y, row_share) = invert(&self.rows, u.y);
        let (column, x, share) = invert(self.row(row), u.x);
        ([column, row], DVec2::new(x, y), row_share * share)
    }

    /// The share of a cell.
    pub(super) fn share(&self, [column, row]: [usize; 2]) -> f64 {
        let part = |sums: &[f32], k: usize| f64::from(sums[k + 1]) - f64::from(sums[k]);
        part(&self.rows, row) * part(self.row(row), column)
    }

    /// Bytes held.
    pub(super) fn bytes(&self) -> u64 {
        4 * (self.rows.len() + self.cells.len()) as u64
    }

    fn row(&self, row: usize) -> &[f32] {
        &self.cells[row * (self.columns + 1)..][..=self.columns]
    }
}

/// Appends the shares of `weights` before each, and 1.
fn append(weights: &[f64], sums: &mut Vec<f32>) {
    let total: f64 = weights.iter().sum();
    let mut sum = 0.0;
    sums.push(0.0);
    for weight in weights {
        sum += weight;
        // Of a row without weight anything will do: it is never drawn.
        sums.push(if total > 0.0 { (sum / total) as f32 } else { 1.0 });
    }
    if let Some(last) = sums.last_mut() {
        *last = 1.0;
    }
}

/// The part of `sums` in which `u` falls, the place in it, and its share, above 0.
fn invert(sums: &[f32], u: f64) -> (usize, f64, f64) {
    // The first sum is 0 and the last 1: the part lies between.
    let after = sums.partition_point(|&sum| f64::from(sum) <= u).clamp(1, sums.len() - 1);
    let (low, high) = (f64::from(sums[after - 1]), f64::from(sums[after]));
    let share = high - low;
    (after - 1, ((u - low) / share).clamp(0.0, 1.0), share)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::chi_square::{chi_square_z, independent_points};

    #[test]
    fn cells_are_drawn_by_their_weight() {
        let weights: Vec<f64> =
            (0..12 * 7).map(|k| if k / 12 == 3 { 0.0 } else { f64::from(k % 5) }).collect();
        let total: f64 = weights.iter().sum();
        let distribution = Distribution::new(12, &weights).unwrap();
        let mut observed = vec![0.0; weights.len()];
        for u in independent_points(200_000) {
            let ([column, row], place, share) = distribution.sample(u);
            assert!(place.min_element() >= 0.0 && place.max_element() <= 1.0);
            assert_eq!(share, distribution.share([column, row]));
            assert!((share - weights[row * 12 + column] / total).abs() < 1e-6);
            observed[row * 12 + column] += 1.0;
        }
        let expected: Vec<f64> = weights.iter().map(|w| w / total * 200_000.0).collect();
        let z = chi_square_z(&observed, &expected);
        assert!(z < 4.0, "{z}");
        assert!(Distribution::new(2, &[0.0; 4]).is_none());
    }

    #[test]
    fn the_ends_of_the_square_stay_on_the_grid() {
        let distribution = Distribution::new(3, &[0.0, 1.0, 0.0, 0.0, 0.0, 0.0]).unwrap();
        for u in [0.0, 0.5, 1.0 - f64::EPSILON / 2.0] {
            assert_eq!(distribution.sample(DVec2::splat(u)).0, [1, 0]);
        }
    }
}

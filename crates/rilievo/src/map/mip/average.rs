//! Box averages of a grid onto coarser ones, all in one pass over its rows.
//!
//! A row is added up from its start once; the sum over a window is then the difference of two of these sums,
//! whatever its length. So the pass costs one addition a cell and about two more for all levels together.

/// Intervals of a row of cells, over each of which a mean is taken.
pub(super) struct Windows {
    /// Cells of the row.
    cells: u32,
    all: Vec<Window>,
}

/// An interval: a part of the row, perhaps one more at its other end.
struct Window {
    parts: [[f64; 2]; 2],
    /// 1 over the length; 0 for nothing.
    weight: f64,
}

impl Windows {
    /// Intervals in cells, not longer than the row, which they may leave: what lies beyond comes from the other
    /// side if the row `wraps`, and counts for nothing if it does not.
    pub fn new(cells: u32, wraps: bool, intervals: impl Iterator<Item = [f64; 2]>) -> Self {
        let n = f64::from(cells);
        let window = |[low, high]: [f64; 2]| {
            let parts = match wraps {
                false => [[low.max(0.0), high.min(n)], [0.0; 2]],
                true => {
                    let turn = n * (low / n).floor();
                    let [low, high] = [low - turn, high - turn];
                    [[low, high.min(n)], [0.0, (high - n).max(0.0)]]
                }
            };
            let length: f64 = parts.iter().map(|[low, high]| (high - low).max(0.0)).sum();
            if length > 0.0 {
                Window { parts, weight: length.recip() }
            } else {
                Window { parts: [[0.0; 2]; 2], weight: 0.0 }
            }
        };
        Self { cells, all: intervals.map(window).collect() }
    }

    /// The means over all windows of a row whose first `k` cells add up to `sums[k]`.
    fn means(&self, sums: &[f64], means: &mut Vec<f64>) {
        let sum_to = |end: f64| {
            let cell = (end as usize).min(sums.len() - 2);
            sums[cell] + (end - cell as f64) * (sums[cell + 1] - sums[cell])
        };
        means.clear();
        means.extend(self.all.iter().map(|Window { parts, weight }| {
            let sum: f64 = parts.iter().map(|[low, high]| sum_to(*high) - sum_to(*low)).sum();
            weight * sum
        }));
    }

    /// For each cell, the windows it counts in and how much.
    fn shares(&self) -> Vec<Vec<(usize, f64)>> {
        let mut all = vec![Vec::new(); self.cells as usize];
        for (index, Window { parts, weight }) in self.all.iter().enumerate() {
            for &[low, high] in parts {
                for cell in low as usize..(high.ceil() as usize).min(all.len()) {
                    let start = cell as f64;
                    let inside = high.min(start + 1.0) - low.max(start);
                    if inside > 0.0 {
                        all[cell].push((index, weight * inside));
                    }
                }
            }
        }
        all
    }
}

/// The means of a grid of `size` cells over the windows of each level, along x and y; row by row. `row` writes the
/// cells of a row.
pub(super) fn averages(
    size: [u32; 2],
    levels: &[[Windows; 2]],
    mut row: impl FnMut(u32, &mut [f64]),
) -> Vec<Vec<f64>> {
    let mut all: Vec<Vec<f64>> =
        levels.iter().map(|[x, y]| vec![0.0; x.all.len() * y.all.len()]).collect();
    let shares: Vec<_> = levels.iter().map(|[_, y]| y.shares()).collect();
    let mut cells = vec![0.0; size[0] as usize];
    let mut sums = vec![0.0; cells.len() + 1];
    let mut means = Vec::new();
    for j in 0..size[1] {
        row(j, &mut cells);
        for (k, cell) in cells.iter().enumerate() {
            sums[k + 1] = sums[k] + cell;
        }
        for ((total, [x, _]), shares) in all.iter_mut().zip(levels).zip(&shares) {
            x.means(&sums, &mut means);
            for &(index, share) in &shares[j as usize] {
                let row = &mut total[index * means.len()..][..means.len()];
                for (total, mean) in row.iter_mut().zip(&means) {
                    *total += share * mean;
                }
            }
        }
    }
    all
}

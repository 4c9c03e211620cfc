//! The filter over a band of rows.

use super::input::{Input, Pixel};

/// Rows of a band.
pub(super) const ROWS: usize = 16;

/// Neighbours are looked for this far away along an axis, pixels.
const REACH: isize = 8;

/// Half the side of a patch, rounded down.
const PATCH: isize = 2;

/// How far colours may differ, in standard deviations: the paper's `k`, squared.
const COLOUR_SCALE: f32 = 0.5 * 0.5;

/// Least variance: where there is no noise only equal colours are averaged.
const QUIET: f32 = 1e-10;

/// Filters the rows from `top` on and writes them to `out`.
pub(super) fn denoise_rows(input: &Input, top: usize, out: &mut [[f32; 3]]) {
    let width = input.size[0];
    let rows = out.len() / width;
    let mut sums = vec![[0.0_f32; 4]; out.len()];
    let mut band = Band::new(input, top, rows);
    for dy in -REACH..=REACH {
        for dx in -REACH..=REACH {
            if (dx, dy) == (0, 0) {
                sums.iter_mut().for_each(|sum| sum[3] += 1.0);
                continue;
            }
            band.compare(dx, dy);
            for row in 0..rows {
                let (y, other) = (top + row, (top + row) as isize + dy);
                if !(0..input.size[1] as isize).contains(&other) {
                    continue;
                }
                let first = (-dx).max(0) as usize;
                let end = (width as isize - dx).clamp(0, width as isize) as usize;
                for x in first..end {
                    let p = &input.pixels[y * width + x];
                    let q = &input.pixels[other as usize * width + (x as isize + dx) as usize];
                    let distance = band.patch(x, row).max(Input::feature_distance(p, q)).max(0.0);
                    // exp(-14) is below a millionth.
                    if distance < 14.0 && q.finished {
                        let (weight, sum) = ((-distance).exp(), &mut sums[row * width + x]);
                        for ((sum, q), p) in sum.iter_mut().zip(q.light).zip(p.light) {
                            *sum += weight * (q - p);
                        }
                        sum[3] += weight;
                    }
                }
            }
        }
    }
    for (k, (out, sum)) in out.iter_mut().zip(&sums).enumerate() {
        let pixel = &input.pixels[top * width + k];
        if pixel.finished {
            for c in 0..3 {
                out[c] += pixel.factor[c] * sum[c] / sum[3];
            }
        }
    }
}

/// Distances of the pixels of a band, and a patch around it, to those some steps away.
struct Band<'a> {
    input: &'a Input,
    top: isize,
    /// Rows with a patch above and below.
    rows: usize,
    /// Along each row, sums over the width of a patch.
    sums: Vec<f32>,
    line: Vec<f32>,
    /// Sums over patches.
    patches: Vec<f32>,
}

impl<'a> Band<'a> {
    fn new(input: &'a Input, top: usize, rows: usize) -> Self {
        let (width, tall) = (input.size[0], rows + 2 * PATCH as usize);
        Self {
            input,
            top: top as isize,
            rows: tall,
            sums: vec![0.0; width * tall],
            line: vec![0.0; width + 2 * PATCH as usize],
            patches: vec![0.0; width * rows],
        }
    }

    /// Compares with what is `dx` to the right and `dy` below.
    fn compare(&mut self, dx: isize, dy: isize) {
        let width = self.input.size[0];
        let side = 2 * PATCH as usize + 1;
        for row in 0..self.rows {
            let y = self.top + row as isize - PATCH;
            for (k, to) in self.line.iter_mut().enumerate() {
                let x = k as isize - PATCH;
                *to = difference(self.input.at(x, y), self.input.at(x + dx, y + dy));
            }
            let sums = &mut self.sums[row * width..][..width];
            for (sum, window) in sums.iter_mut().zip(self.line.windows(side)) {
                *sum = window.iter().sum();
            }
        }
        for (row, patches) in self.patches.chunks_exact_mut(width).enumerate() {
            for (x, patch) in patches.iter_mut().enumerate() {
                *patch = (row..row + side).map(|row| self.sums[row * width + x]).sum();
            }
        }
    }

    /// Mean distance over the patch around a pixel of the band.
    #[inline]
    fn patch(&self, x: usize, row: usize) -> f32 {
        let side = (2 * PATCH + 1) as f32;
        self.patches[row * self.input.size[0] + x] / (side * side)
    }
}

/// The squared difference of two colours beyond what noise explains, in variances.
#[inline]
fn difference(p: &Pixel, q: &Pixel) -> f32 {
    let mut sum = 0.0;
    for c in 0..3 {
        let (step, v, w) = (p.light[c] - q.light[c], p.variance[c], q.variance[c]);
        sum += (step * step - v - v.min(w)) / (QUIET + COLOUR_SCALE * (v + w));
    }
    sum / 3.0
}

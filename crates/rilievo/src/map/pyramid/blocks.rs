//! Codes of blocks of 4 x 4 cells from samples: the inner loop of a build.
//!
//! A *line* is what bounds a cell: cell `c` of an axis lies between lines `c` and `c + 1`, and each
//! line shows one sample. A row of blocks spans five lines, and so does each of its blocks. Lowest
//! and highest are taken over the five rows first, then over windows of five neighbours, all in
//! plain loops over contiguous memory that a compiler turns into vectors; only every fourth
//! window is a block, but windows that nobody asked for are cheaper than loads one by one.
//!
//! Vectors of the smallest x86-64 compare 16-bit integers only with their sign, so codes are
//! folded as signed *keys* in the same order.

use super::code::Code;
use super::level::Wide;
use crate::map::height::HeightMap;
use crate::map::lattice::Axis;

/// A sample of a height map.
pub(super) trait Sample: Copy + Sync {
    /// What is compared in its place.
    type Key: Copy + PartialOrd + Default;

    /// The key of a sample; order is kept.
    fn key(self) -> Self::Key;

    /// Codes of blocks from the keys of their lowest and highest samples.
    fn encode(code: &Code, keys: [&[Self::Key]; 2], codes: [&mut [u16]; 2]);
}

impl Sample for u16 {
    type Key = i16;

    #[inline(always)]
    fn key(self) -> i16 {
        (self ^ 0x8000) as i16
    }

    fn encode(_: &Code, keys: [&[i16]; 2], codes: [&mut [u16]; 2]) {
        for (keys, codes) in keys.into_iter().zip(codes) {
            for (key, code) in keys.iter().zip(codes) {
                *code = *key as u16 ^ 0x8000;
            }
        }
    }
}

impl Sample for f32 {
    type Key = Self;

    #[inline(always)]
    fn key(self) -> Self {
        self
    }

    fn encode(code: &Code, [low, high]: [&[Self]; 2], [min, max]: [&mut [u16]; 2]) {
        code.encode(low, high, min, max);
    }
}

#[inline(always)]
fn lower<T: PartialOrd>(a: T, b: T) -> T {
    if a < b { a } else { b }
}

#[inline(always)]
fn higher<T: PartialOrd>(a: T, b: T) -> T {
    if a > b { a } else { b }
}

/// The sample that line `line` of an axis shows.
fn sample_of(axis: &Axis, line: u32) -> usize {
    let sample = if line < axis.cells() { axis.corners(line).0 } else { axis.corners(line - 1).1 };
    sample as usize
}

/// Fills runs of level-0 nodes, all from column `first` on; holds the memory this takes.
pub(super) struct Blocks<'a, S: Sample> {
    heights: &'a HeightMap,
    samples: &'a [S],
    code: &'a Code,
    first: u32,
    /// Lowest and highest key over five rows, by line.
    lines: [Vec<S::Key>; 2],
    /// The same over windows of five lines, by the first of them.
    windows: [Vec<S::Key>; 2],
    /// Codes of the blocks of a row.
    codes: [Vec<u16>; 2],
}

impl<'a, S: Sample> Blocks<'a, S> {
    /// For runs of `count` nodes.
    pub fn new(
        (heights, samples): (&'a HeightMap, &'a [S]),
        code: &'a Code,
        (first, count): (u32, usize),
    ) -> Self {
        let keys = |count| [vec![S::Key::default(); count], vec![S::Key::default(); count]];
        Self {
            heights,
            samples,
            code,
            first,
            lines: keys(16 * count + 4),
            windows: keys(16 * count),
            codes: [vec![0; 4 * count], vec![0; 4 * count]],
        }
    }

    /// Writes all lanes of the nodes of row `node_y`.
    pub fn fill(&mut self, node_y: u32, max: &mut [Wide], min: &mut [Wide]) {
        let (x, y) = (self.heights.x(), self.heights.y());
        let width = self.heights.width() as usize;
        let across = (x.cells() - self.first * 16).div_ceil(4) as usize;
        for lane_y in 0..4 {
            let from = node_y * 16 + lane_y * 4;
            if from < y.cells() {
                // A block cut short by the end of the map shows its last line again.
                let row = |k: u32| sample_of(y, (from + k).min(y.cells())) * width;
                let rows = [0, 1, 2, 3, 4].map(|k| &self.samples[row(k)..row(k) + width]);
                self.fold(rows);
            } else {
                self.codes[0].fill(u16::MAX);
                self.codes[1].fill(0);
            }
            // Blocks beyond the map are empty.
            let end = across.min(self.codes[0].len());
            self.codes[0][end..].fill(u16::MAX);
            self.codes[1][end..].fill(0);
            let lane = 4 * lane_y as usize;
            for (codes, nodes) in self.codes.iter().zip([&mut *min, &mut *max]) {
                for (codes, node) in codes.as_chunks::<4>().0.iter().zip(nodes) {
                    node[lane..lane + 4].copy_from_slice(codes);
                }
            }
        }
    }

    /// Codes of the blocks between five rows of samples.
    fn fold(&mut self, rows: [&[S]; 5]) {
        self.fold_rows(rows);
        let [low, high] = &mut self.windows;
        fold_windows(&self.lines[0], low, lower);
        fold_windows(&self.lines[1], high, higher);
        let blocks = self.codes[0].len();
        for keys in &mut self.windows {
            // To the front of the same memory.
            for block in 0..blocks {
                keys[block] = keys[4 * block];
            }
        }
        let [low, high] = &self.windows;
        let [min, max] = &mut self.codes;
        S::encode(self.code, [&low[..blocks], &high[..blocks]], [min, max]);
    }

    /// Lowest and highest of five rows of samples, by line.
    fn fold_rows(&mut self, rows: [&[S]; 5]) {
        let (x, start) = (self.heights.x(), 16 * self.first as usize);
        // Line k shows sample k - pad; the few that do not come after.
        let pad = usize::from(x.first_cell() < 0);
        let (count, samples) = (self.lines[0].len(), rows[0].len());
        let run = pad.saturating_sub(start)..count.min(pad + samples - start);
        let first = start + run.start - pad;
        let part = rows.map(|row| &row[first..first + run.len()]);
        let [low, high] = &mut self.lines;
        fold_samples(part, &mut low[run.clone()], &mut high[run.clone()]);
        let wraps = pad == 0 && x.cells() as usize == samples;
        let column = rows.map(|row| row[0].key());
        let ends = [column.iter().copied().reduce(lower), column.iter().copied().reduce(higher)];
        for (lines, end) in self.lines.iter_mut().zip(ends) {
            if run.start > 0 {
                lines[0] = lines[1];
            }
            if run.end < count {
                // Past the last line it shows again, so that blocks cut short need no other code.
                let last = if wraps { end.unwrap_or_default() } else { lines[run.end - 1] };
                lines[run.end..].fill(last);
            }
        }
    }
}

/// Lowest and highest key of five rows, at every place.
#[inline(never)]
fn fold_samples<S: Sample>(rows: [&[S]; 5], low: &mut [S::Key], high: &mut [S::Key]) {
    let n = low.len();
    let ([a, b, c, d, e], high) = (rows.map(|row| &row[..n]), &mut high[..n]);
    for i in 0..n {
        let [a, b, c, d, e] = [a[i], b[i], c[i], d[i], e[i]].map(S::key);
        low[i] = lower(a, lower(b, lower(c, lower(d, e))));
        high[i] = higher(a, higher(b, higher(c, higher(d, e))));
    }
}

/// The pick of each five neighbouring lines.
#[inline(never)]
fn fold_windows<K: Copy>(lines: &[K], windows: &mut [K], pick: impl Fn(K, K) -> K) {
    let n = windows.len();
    let [a, b, c, d, e] = [0, 1, 2, 3, 4].map(|k| &lines[k..k + n]);
    for i in 0..n {
        windows[i] = pick(pick(pick(a[i], b[i]), pick(c[i], d[i])), e[i]);
    }
}

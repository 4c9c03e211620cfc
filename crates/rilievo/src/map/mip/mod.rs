//! [`MipLevel`]: a height map at half the samples along each side, at a quarter, and so on, with what each level
//! no longer shows.
//!
//! A level is a height map like any other, to be laid and traced like any other. Its samples are *box averages*
//! of the full map, not of the level before it, so no error adds up:
//!
//! | lattice | a sample of a level is the mean of | over, in samples of the level |
//! |---|---|---|
//! | texel | the full map's samples, each counted by the part of its texel that lies inside | its texel, 1 x 1 |
//! | vertex | the full map's cells, each by its own mean and the part that lies inside | 1 x 1 around it |
//!
//! What reaches beyond the map is taken from its other side where it repeats and left out where it does not, so
//! the mean height is kept: exactly on texels, by the trapezoid rule on vertices. A repeated vertex map whose
//! sides differ has a jump there; its levels do not.
//!
//! A side of `n` texels has `n / 2` of them a level on, rounded up; one of `n` vertices has `n - 1` cells, of which
//! that is said. The last level has two samples or three a side. All levels together take a third of the full map and
//! a third of two bytes a sample.
//!
//! What a level leaves out is kept as variances of slopes, cell by cell: [`LostSlopes`]. That is what LEAN maps
//! keep \[Olano2010\]; they count slopes around the mean of the footprint, we around those that the level
//! still has, so that nothing counts twice and nothing is lost: mean square slopes of a level and what it lost add
//! up to those of the full map, but where a cell of a level is steeper than what it stands for.

mod average;
mod slopes;

pub use slopes::LostSlopes;

use super::height::{HeightMap, Samples};
use super::lattice::{Axis, Lattice, Wrap};
use average::{Windows, averages};

/// A height map that stands for a finer one, and what it leaves out.
#[derive(Clone, Debug)]
pub struct MipLevel {
    heights: HeightMap,
    lost: LostSlopes,
}

impl MipLevel {
    /// The levels above a height map, finest first. It takes the time of a few passes over the map, and 8 bytes
    /// for each sample of the levels while it lasts.
    pub fn chain(full: &HeightMap) -> Vec<Self> {
        let heights = filtered_levels(full);
        let lost = LostSlopes::of_levels(full, &heights);
        heights.into_iter().zip(lost).map(|(heights, lost)| Self { heights, lost }).collect()
    }

    /// The heights.
    pub fn heights(&self) -> &HeightMap {
        &self.heights
    }

    /// What the heights do not show of the full map.
    pub fn lost(&self) -> &LostSlopes {
        &self.lost
    }

    /// Both, to be kept apart.
    pub fn into_parts(self) -> (HeightMap, LostSlopes) {
        (self.heights, self.lost)
    }
}

/// Samples along x and y of all levels above a map with these axes.
fn sizes(axes: [&Axis; 2]) -> Vec<[u32; 2]> {
    let halved = |axis: &Axis, samples: u32| match axis.lattice() {
        Lattice::Vertex => (samples - 1).div_ceil(2) + 1,
        Lattice::Texel => samples.div_ceil(2).max(2),
    };
    let mut all = Vec::new();
    let mut size = axes.map(Axis::samples);
    loop {
        let next = [halved(axes[0], size[0]), halved(axes[1], size[1])];
        if next == size {
            return all;
        }
        all.push(next);
        size = next;
    }
}

/// The heights of all levels above a map.
pub(super) fn filtered_levels(full: &HeightMap) -> Vec<HeightMap> {
    let sizes = sizes([full.x(), full.y()]);
    let axes = [full.x(), full.y()];
    let windows: Vec<[Windows; 2]> =
        sizes.iter().map(|size| [0, 1].map(|k| around_samples(axes[k], size[k]))).collect();
    let means = match full.x().lattice() {
        Lattice::Texel => averages([full.width(), full.height()], &windows, |j, row| {
            for (i, mean) in (0..).zip(row) {
                *mean = f64::from(full.raw(i, j));
            }
        }),
        Lattice::Vertex => averages([full.width() - 1, full.height() - 1], &windows, |j, row| {
            for (i, mean) in (0..).zip(row) {
                let raw = |i, j| f64::from(full.raw(i, j));
                *mean = 0.25 * (raw(i, j) + raw(i + 1, j) + raw(i, j + 1) + raw(i + 1, j + 1));
            }
        }),
    };
    let map = |([width, height], means): (&[u32; 2], Vec<f64>)| {
        let samples = match full.samples() {
            Samples::U16(_) => Samples::U16(means.iter().map(|raw| raw.round() as u16).collect()),
            Samples::F32(_) => Samples::F32(means.iter().map(|&raw| raw as f32).collect()),
        };
        HeightMap::new(*width, *height, samples, full.x().lattice(), full.x().wrap())
            .expect("means of heights are heights")
    };
    sizes.iter().zip(means).map(map).collect()
}

/// What each of a number of samples along an axis stands for: in texels, or in the cells between vertices.
fn around_samples(axis: &Axis, samples: u32) -> Windows {
    let ratio = |numerator: u32, denominator: u32| f64::from(numerator) / f64::from(denominator);
    match axis.lattice() {
        Lattice::Texel => {
            let n = axis.samples();
            let border = |i: u32| f64::from(i) * f64::from(n) / f64::from(samples);
            Windows::new(n, false, (0..samples).map(|i| [border(i), border(i + 1)]))
        }
        Lattice::Vertex => {
            let cells = axis.period();
            let half = ratio(cells, 2 * (samples - 1));
            let around = (0..samples).map(|i| [2.0 * f64::from(i) - 1.0, 2.0 * f64::from(i) + 1.0]);
            let wraps = axis.wrap() == Wrap::Repeat;
            Windows::new(cells, wraps, around.map(|ends| ends.map(|end| end * half)))
        }
    }
}

#[cfg(test)]
mod tests;

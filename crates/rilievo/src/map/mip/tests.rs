//! Levels against averages by the book, and slopes against closed forms.

use super::*;
use crate::map::{Metric, Procedural};

const WRAPS: [Wrap; 3] = [Wrap::Repeat, Wrap::Clamp, Wrap::Mirror];

fn noise(size: [u32; 2], codes: bool, lattice: Lattice, wrap: Wrap) -> HeightMap {
    let noise = Procedural::Fbm { octaves: 5, seed: 11 };
    match codes {
        true => noise.height_map(size, lattice, wrap).unwrap(),
        false => noise.height_map_f32(size, lattice, wrap).unwrap(),
    }
}

/// How much each sample of the full map counts in sample `index` of `samples`: from the definition, by adding up
/// pieces so small that each lies in one cell.
fn weights(axis: &Axis, samples: u32, index: u32) -> Vec<f64> {
    let texel = axis.lattice() == Lattice::Texel;
    let (cells, others) =
        if texel { (axis.samples(), samples) } else { (axis.period(), samples - 1) };
    let mut weights = vec![0.0; axis.samples() as usize];
    // A cell of either has a whole number of pieces; those of vertices are halved.
    let centre = if texel { 2 * index + 1 } else { 2 * index };
    let total = i64::from(cells * others);
    for piece in 0..2 * i64::from(cells) {
        let at = i64::from(centre * cells) - i64::from(cells) + piece;
        let inside = (0..2 * total).contains(&at);
        if !inside && axis.wrap() != Wrap::Repeat {
            continue;
        }
        let cell = (at.rem_euclid(2 * total) / (2 * i64::from(others))) as usize;
        let corners = if texel { [cell, cell] } else { [cell, cell + 1] };
        corners.iter().for_each(|&corner| weights[corner] += 1.0);
    }
    let sum: f64 = weights.iter().sum();
    weights.iter().map(|weight| weight / sum).collect()
}

#[test]
fn samples_of_levels_are_box_averages_of_the_full_map() {
    for lattice in [Lattice::Vertex, Lattice::Texel] {
        for wrap in WRAPS {
            for (size, codes) in
                [([16, 8], true), ([17, 9], true), ([13, 22], false), ([2, 7], false)]
            {
                let full = noise(size, codes, lattice, wrap);
                let levels = MipLevel::chain(&full);
                let least = levels.last().unwrap().heights();
                assert!(least.width() <= 3 && least.height() <= 3);
                for level in &levels {
                    let heights = level.heights();
                    let rounding = if codes { 0.5 + 1e-9 } else { 1e-7 };
                    let [width, height] = [heights.width(), heights.height()];
                    for j in 0..height {
                        let along_y = weights(full.y(), height, j);
                        for i in 0..width {
                            let along_x = weights(full.x(), width, i);
                            let mut mean = 0.0;
                            for (y, b) in (0..).zip(&along_y) {
                                for (x, a) in (0..).zip(&along_x) {
                                    mean += a * b * f64::from(full.raw(x, y));
                                }
                            }
                            let found = f64::from(heights.raw(i, j));
                            let about = format!("{lattice:?} {wrap:?} {size:?} {width} {height}");
                            assert!((found - mean).abs() <= rounding, "{found} {mean}: {about}");
                        }
                    }
                }
            }
        }
    }
}

/// Mean height over one repetition.
fn mean(map: &HeightMap) -> f64 {
    let (x, y) = (map.x(), map.y());
    let texel = x.lattice() == Lattice::Texel;
    let share = |axis: &Axis, k: u32| match texel {
        true => 1.0 / f64::from(axis.samples()),
        false if k == 0 || k == axis.period() => 0.5 / f64::from(axis.period()),
        false => 1.0 / f64::from(axis.period()),
    };
    let samples = (0..map.height()).flat_map(|j| (0..map.width()).map(move |i| (i, j)));
    samples.map(|(i, j)| share(x, i) * share(y, j) * f64::from(map.raw(i, j))).sum()
}

#[test]
fn levels_keep_the_mean_height() {
    for lattice in [Lattice::Vertex, Lattice::Texel] {
        for wrap in WRAPS {
            for size in [[33, 65], [40, 23]] {
                let full = noise(size, false, lattice, wrap);
                for level in MipLevel::chain(&full) {
                    assert!((mean(level.heights()) - mean(&full)).abs() < 1e-6);
                }
            }
        }
    }
}

/// `periods` waves of amplitude 1 along u, on texels.
fn waves(samples: u32, periods: u32) -> HeightMap {
    let wave = |i: u32| {
        let u = (f64::from(i) + 0.5) / f64::from(samples);
        (std::f64::consts::TAU * f64::from(periods) * u).sin() as f32
    };
    let row: Vec<f32> = (0..samples).map(wave).collect();
    let rows = (0..samples).flat_map(|_| row.iter().copied()).collect();
    HeightMap::new(samples, samples, Samples::F32(rows), Lattice::Texel, Wrap::Repeat).unwrap()
}

#[test]
fn a_wave_that_is_averaged_away_leaves_half_its_steepest_slope_squared() {
    let (samples, periods) = (256, 16);
    let full = waves(samples, periods);
    let turn = std::f64::consts::TAU * f64::from(periods);
    // Chords of the wave are less steep than it: by the sine of half a sample's angle over that angle.
    let half = 0.5 * turn / f64::from(samples);
    let exact = 0.5 * turn * turn * (half.sin() / half).powi(2);
    assert!((exact / (0.5 * turn * turn) - 1.0).abs() < 0.02);
    let levels = MipLevel::chain(&full);
    // From the level on in which a sample is a whole wave.
    for level in &levels[3..] {
        let n = level.heights().width() as i32;
        assert!(level.heights().raw_range().1.abs() < 1e-6);
        for (i, j) in [(0, 0), (-1, 5), (n, n - 1), (3 * n + 1, -7)] {
            let [x, y] = level.lost().at([i, j]);
            // Half a code of the standard deviation is a share of 1/255 of the variance.
            assert!((x / exact - 1.0).abs() < 1.0 / 255.0 && y == 0.0, "{x} {exact} {y}");
        }
    }
    // The finest level still shows nearly all of it.
    let [x, _] = levels[0].lost().at([4, 4]);
    assert!(x < 0.2 * exact, "{x}");
}

#[test]
fn slopes_that_a_level_has_and_those_it_lost_add_up() {
    for (lattice, wrap) in [(Lattice::Texel, Wrap::Repeat), (Lattice::Vertex, Wrap::Mirror)] {
        let full = noise([129, 128], false, lattice, wrap);
        let squares = |map: &HeightMap, axis: usize| {
            let cells = [map.x().cells(), map.y().cells()];
            let all = (0..cells[1]).flat_map(|j| (0..cells[0]).map(move |i| [i, j]));
            let sum: f64 = all.map(|cell| slopes::mean_square_slope(map, cell, axis)).sum();
            sum / f64::from(cells[0] * cells[1])
        };
        for level in MipLevel::chain(&full) {
            let heights = level.heights();
            let cells = [heights.x().cells(), heights.y().cells()];
            for axis in [0, 1] {
                let all =
                    (0..cells[1] as i32).flat_map(|j| (0..cells[0] as i32).map(move |i| [i, j]));
                let lost: f64 = all.map(|cell| level.lost().at(cell)[axis]).sum();
                let kept = squares(heights, axis);
                let sum = kept + lost / f64::from(cells[0] * cells[1]);
                let all = squares(&full, axis);
                // Cells that are steeper than what they stand for make it more.
                assert!(sum > 0.99 * all && sum < 1.1 * all, "{cells:?} {axis}: {sum} {all}");
            }
        }
    }
}

#[test]
fn levels_take_a_third_of_the_map_and_two_bytes_a_sample() {
    let full = noise([256, 256], true, Lattice::Texel, Wrap::Repeat);
    let levels = MipLevel::chain(&full);
    assert_eq!(levels.len(), 7);
    let heights: u64 = levels.iter().map(|level| level.heights().bytes()).sum();
    let lost: u64 = levels.iter().map(|level| level.lost().bytes()).sum();
    assert_eq!((3 * heights).next_multiple_of(256), full.bytes());
    assert_eq!(lost, heights, "two bytes each");
}

#[test]
fn a_level_has_the_metric_of_its_larger_cells() {
    let full = noise([64, 32], true, Lattice::Texel, Wrap::Repeat);
    let first = &MipLevel::chain(&full)[0];
    let [fine, coarse] = [&full, first.heights()].map(|map| Metric::of_face(map, [1.0; 2], 1.0));
    assert_eq!([coarse.x, coarse.y, coarse.z], [2.0 * fine.x, 2.0 * fine.y, fine.z]);
}

//! Pearson's chi-square test, for the tests of samplers and warps.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use super::{Dimension, Sampler};

/// How many standard deviations the chi-square statistic of `observed` counts lies above what
/// `expected` counts allow, by the cube-root approximation of \[Wilson1931\]. Cells that expect
/// fewer than five are pooled.
pub(crate) fn chi_square_z(observed: &[f64], expected: &[f64]) -> f64 {
    let (mut statistic, mut cells) = (0.0, 0.0);
    let (mut rest_observed, mut rest_expected) = (0.0, 0.0);
    for (&o, &e) in observed.iter().zip(expected) {
        if e < 5.0 {
            rest_observed += o;
            rest_expected += e;
        } else {
            statistic += (o - e) * (o - e) / e;
            cells += 1.0;
        }
    }
    if rest_expected >= 5.0 {
        statistic += (rest_observed - rest_expected).powi(2) / rest_expected;
        cells += 1.0;
    } else {
        assert!(rest_observed <= 40.0, "{rest_observed} samples where next to none belong");
    }
    let freedom: f64 = cells - 1.0;
    let spread = 2.0 / (9.0 * freedom);
    ((statistic / freedom).cbrt() - (1.0 - spread)) / spread.sqrt()
}

/// Independent uniform points: one from each of `count` pixels.
pub(crate) fn independent_points(count: u32) -> impl Iterator<Item = DVec2> {
    let point = |i| Sampler::new(7, [i, 3]).strata(Dimension::Pixel, 1).point(0);
    (0..count).map(point)
}

/// Tests a warp to unit vectors against its density over 20 x 20 cells of z and azimuth, and that
/// the density integrates to 1.
pub(crate) fn check_directions(
    name: &str,
    warp: impl Fn(DVec2) -> DVec3,
    pdf: impl Fn(DVec3) -> f64,
) {
    const CELLS: usize = 20;
    const FINE: usize = 64;
    const SAMPLES: u32 = 200_000;
    let mut observed = vec![0.0; CELLS * CELLS];
    for u in independent_points(SAMPLES) {
        let d = warp(u);
        assert!((d.length() - 1.0).abs() < 1e-9, "{name}: {d}");
        let turn = (d.y.atan2(d.x) / TAU).rem_euclid(1.0);
        let cell = |x: f64| ((x * CELLS as f64) as usize).min(CELLS - 1);
        observed[cell(0.5 + 0.5 * d.z) * CELLS + cell(turn)] += 1.0;
    }
    let n = CELLS * FINE;
    let mut expected = vec![0.0; CELLS * CELLS];
    let turns: Vec<(f64, f64)> =
        (0..n).map(|column| (TAU * (column as f64 + 0.5) / n as f64).sin_cos()).collect();
    for row in 0..n {
        let z = -1.0 + 2.0 * (row as f64 + 0.5) / n as f64;
        let r = (1.0 - z * z).sqrt();
        for (column, (sin, cos)) in turns.iter().enumerate() {
            let density = pdf(DVec3::new(r * cos, r * sin, z));
            expected[row / FINE * CELLS + column / FINE] +=
                density * 2.0 * TAU / (n * n) as f64 * f64::from(SAMPLES);
        }
    }
    let total = expected.iter().sum::<f64>() / f64::from(SAMPLES);
    assert!((total - 1.0).abs() < 2e-3, "{name}: density integrates to {total}");
    let z = chi_square_z(&observed, &expected);
    assert!(z < 4.0, "{name}: chi-square is {z} deviations too large");
}

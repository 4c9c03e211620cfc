//! Samplers: strata, independence, and the order of errors.

use std::collections::HashSet;

use super::super::chi_square::chi_square_z;
use super::*;

fn sampler(kind: SamplerKind, pixel: [u32; 2], sample: u64) -> PathSampler {
    PathSampler::new(kind, 11, pixel, sample, 64)
}

/// The pair of dimension `dimension` of a sample.
fn pair(kind: SamplerKind, pixel: [u32; 2], sample: u64, dimension: u32) -> DVec2 {
    let mut sampler = sampler(kind, pixel, sample);
    sampler.seek(dimension);
    sampler.two()
}

#[test]
fn every_aligned_run_of_sobol_points_fills_every_elementary_box() {
    for (pixel, dimension, first) in
        [([0, 0], 0, 0), ([7, 3], 5, 0), ([7, 3], 6, 3 << 10), ([1, 2], 900, (1 << 32) - 1024)]
    {
        for k in 0..=10 {
            let points: Vec<DVec2> = (first..first + (1 << k))
                .map(|sample| pair(SamplerKind::Sobol, pixel, sample, dimension))
                .collect();
            for a in 0..=k {
                let boxes = DVec2::new((1 << a) as f64, (1 << (k - a)) as f64);
                let box_of = |p: &DVec2| (*p * boxes).to_array().map(|x| x as u32);
                let hit: HashSet<_> = points.iter().map(box_of).collect();
                assert_eq!(hit.len(), 1 << k, "2^-{a} x 2^-{}", k - a);
            }
        }
    }
}

#[test]
fn single_numbers_fill_every_interval() {
    for kind in [SamplerKind::Sobol, SamplerKind::Jittered] {
        let hit: HashSet<_> = (64..128)
            .map(|sample| {
                let mut sampler = sampler(kind, [4, 9], sample);
                sampler.seek(3);
                (sampler.one() * 64.0) as u64
            })
            .collect();
        assert_eq!(hit.len(), 64, "{kind}");
    }
}

#[test]
fn a_point_is_uniform_over_pixels() {
    for kind in SamplerKind::ALL {
        for (sample, dimension) in [(0, 0), (1, 0), (5, 7), (63, 40), (1000, 3)] {
            let mut observed = vec![0.0; 1024];
            let mut single = vec![0.0; 256];
            for i in 0..200_000 {
                let mut sampler = sampler(kind, [i % 500, i / 500], sample);
                sampler.seek(dimension);
                let p = sampler.two();
                assert!(p.min_element() >= 0.0 && p.max_element() < 1.0);
                observed[(p.y * 32.0) as usize * 32 + (p.x * 32.0) as usize] += 1.0;
                single[(sampler.one() * 256.0) as usize] += 1.0;
            }
            let z = chi_square_z(&observed, &[200_000.0 / 1024.0; 1024]);
            assert!(z < 4.0, "{kind}, sample {sample}: {z}");
            let z = chi_square_z(&single, &[200_000.0 / 256.0; 256]);
            assert!(z < 4.0, "{kind}, number of sample {sample}: {z}");
        }
    }
}

#[test]
fn dimensions_coordinates_and_pixels_are_independent() {
    type Pair<'a> = &'a dyn Fn(SamplerKind, u32, u32) -> [f64; 2];
    let x = |kind, pixel, dimension| pair(kind, pixel, 5, dimension).x;
    let pairs: [(&str, Pair<'_>); 5] = [
        ("dimensions", &|kind, i, j| [x(kind, [i, j], 0), x(kind, [i, j], 1)]),
        ("far dimensions", &|kind, i, j| [x(kind, [i, j], 2), x(kind, [i, j], 66)]),
        ("columns", &|kind, i, j| [x(kind, [2 * i, j], 3), x(kind, [2 * i + 1, j], 3)]),
        ("rows", &|kind, i, j| [x(kind, [i, 2 * j], 3), x(kind, [i, 2 * j + 1], 3)]),
        ("coordinates", &|kind, i, j| pair(kind, [i, j], 21, 4).to_array()),
    ];
    for kind in SamplerKind::ALL {
        for (name, pair) in pairs {
            let mut observed = vec![0.0; 256];
            for i in 0..100_000 {
                let [a, b] = pair(kind, i % 400, i / 400).map(|x| (x * 16.0) as usize);
                observed[a * 16 + b] += 1.0;
            }
            let z = chi_square_z(&observed, &[100_000.0 / 256.0; 256]);
            assert!(z < 4.0, "{kind}, {name}: {z}");
        }
    }
}

/// Two samples whose first differing binary digit is the k-th: the digits before agree, this one
/// differs, and all after are independent \[Owen1995\].
#[test]
fn pairs_of_scrambled_numbers_are_as_independent_as_can_be() {
    for (a, b) in [(0, 1_u32), (1, 2), (2, 6), (5, 13), (3, 0x8000_0003)] {
        let split = (a ^ b).trailing_zeros();
        let mut observed = vec![0.0; 1024];
        for i in 0..200_000 {
            let key = hash(9, i);
            let [p, q] = [a, b].map(|x| scrambled(x, key).reverse_bits());
            assert_eq!((p ^ q).leading_zeros(), split);
            // Below 2^32 for every split but the last, of which one digit is left.
            let [p, q] = [p, q].map(|x| (x << split << 1 >> 27) as usize);
            observed[p * 32 + q] += 1.0;
        }
        let cells = 1_usize << (2 * 5.min(31 - split));
        let expected = [200_000.0 / cells as f64; 1024];
        let used: Vec<f64> = observed.into_iter().filter(|&n| n > 0.0).collect();
        assert_eq!(used.len(), cells, "{a} and {b}");
        if cells > 1 {
            let z = chi_square_z(&used, &expected[..cells]);
            assert!(z < 4.0, "{a} and {b}: {z}");
        }
    }
}

/// Mean over 1000 pixels of the square of the error of the mean of `samples` samples.
fn mean_square_error(kind: SamplerKind, samples: u64) -> f64 {
    // The integral of a smooth function of two pairs.
    let f = |p: DVec2, q: DVec2| (p.x + 2.0 * p.y * q.x).exp() * (1.0 + q.y * p.x);
    let one = |pixel| {
        let sum: f64 = (0..samples)
            .map(|sample| {
                let mut sampler = PathSampler::new(kind, 1, [pixel, 0], sample, samples);
                f(sampler.two(), sampler.two())
            })
            .sum();
        sum / samples as f64
    };
    let means: Vec<f64> = (0..1000).map(one).collect();
    let mean = means.iter().sum::<f64>() / 1000.0;
    means.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / 999.0
}

#[test]
fn variance_falls_faster_than_one_over_the_number_of_samples() {
    // What each pair explains on its own vanishes as N^-3; what two pairs make together falls
    // as 1/N, as with independent numbers.
    let [few, many] = [16, 256].map(|n| mean_square_error(SamplerKind::Sobol, n));
    let [plain, more] = [16, 256].map(|n| mean_square_error(SamplerKind::Independent, n));
    assert!((plain / more / 16.0 - 1.0).abs() < 0.2, "{}", plain / more);
    assert!(few < 0.4 * plain && many < 0.35 * more, "{} {}", few / plain, many / more);
    let strata = mean_square_error(SamplerKind::Jittered, 256);
    assert!(strata < 0.35 * more, "{}", strata / more);
    // One pair alone.
    let alone = |samples: u64| {
        let error = |pixel| {
            let sum: f64 = (0..samples)
                .map(|sample| {
                    let p = pair(SamplerKind::Sobol, [pixel, 5], sample, 2);
                    (p.x * p.y).sqrt() * (1.0 + p.y)
                })
                .sum();
            sum / samples as f64 - 4.0 / 9.0 - 4.0 / 15.0
        };
        (0..1000).map(|pixel| error(pixel).powi(2)).sum::<f64>() / 1000.0
    };
    // 1/N would be 64, strata 4096; scrambled nets promise nearly N^-3.
    let ratio = alone(16) / alone(1024);
    assert!(ratio > 64.0 * 64.0, "{ratio}");
}

#[test]
fn numbers_are_those_of_their_index_whatever_was_taken_before() {
    for kind in SamplerKind::ALL {
        let mut whole = sampler(kind, [3, 4], 77);
        let numbers: Vec<f64> = (0..20).map(|_| whole.one()).collect();
        let mut later = sampler(kind, [3, 4], 77);
        later.seek(12);
        assert_eq!(later.one(), numbers[12]);
        assert_eq!(later.one(), numbers[13]);
        assert_ne!(sampler(kind, [3, 4], 77 + (1 << 33)).one(), numbers[0]);
    }
}

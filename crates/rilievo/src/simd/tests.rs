//! Every level against plain arithmetic, lane by lane and bit by bit.

use super::{Kernel, Lanes, Mirror, Quad, SimdLevel, WIDTH, run};

/// Runs the same checks at whatever level it is entered.
struct Checks;

/// The same for quads.
struct QuadChecks;

impl Kernel for QuadChecks {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        const A: [[f64; 4]; 2] = [[0.0, -0.0, 1.0, -1.5], [3.5, 1e300, -1e-310, -7.0]];
        const B: [[f64; 4]; 2] = [[-0.0, 0.0, -1.0, 2.25], [-3.5, 1e-300, 1e300, -7.0]];
        for (from, with) in A.into_iter().zip(B) {
            let each = |f: fn(f64, f64) -> f64| {
                let mut out = [0; 4];
                for k in 0..4 {
                    out[k] = f(from[k], with[k]).to_bits();
                }
                out
            };
            let (a, b) = (L::Quad::of(from), L::Quad::of(with));
            let bits = |q: L::Quad| q.array().map(f64::to_bits);
            assert_eq!(bits(a.plus(b)), each(|a, b| a + b));
            assert_eq!(bits(a.minus(b)), each(|a, b| a - b));
            assert_eq!(bits(a.times(b)), each(|a, b| a * b));
            assert_eq!(bits(a.over(L::Quad::splat(3.0))), each(|a, _| a / 3.0));
            assert_eq!(bits(a.scaled(0.1)), each(|a, _| a * 0.1));
            assert_eq!(bits(a.size()), each(|a, _| a.abs()));
            assert_eq!(bits(a.larger(b)), each(|a, b| if a > b { a } else { b }));
            assert_eq!(bits(a.smaller(b)), each(|a, b| if a < b { a } else { b }));
            let turned = each(|a, b| if b.is_sign_negative() { -a } else { a });
            assert_eq!(bits(a.turned_by(b)), turned);
            assert_eq!(a.rounded().map(f32::to_bits), from.map(|x| (x as f32).to_bits()));
        }
        let places = L::Quad::of([-1.0, -0.25, 2.75, 2_147_483_646.5]);
        assert_eq!(places.floors(), [-1, -1, 2, 2_147_483_646]);
    }
}

const A: [f32; WIDTH] =
    [0.0, -0.0, 1.0, -1.0, 3.5, 1e30, -1e30, 1e-40, 7.0, 65535.0, 0.1, -0.1, 2.0, 4.0, 8.0, 16.0];
const B: [f32; WIDTH] =
    [-0.0, 0.0, 1.0, 2.0, -3.5, 1e-30, 1e30, -1e-40, 6.9, 65535.0, 0.2, -0.2, 2.5, 3.5, 8.5, -16.0];

fn bits(v: [f32; WIDTH]) -> [u32; WIDTH] {
    v.map(f32::to_bits)
}

fn each(f: impl Fn(f32, f32) -> f32) -> [u32; WIDTH] {
    std::array::from_fn(|k| f(A[k], B[k]).to_bits())
}

fn truth(f: impl Fn(f32, f32) -> bool) -> u16 {
    (0..WIDTH).map(|k| u16::from(f(A[k], B[k])) << k).sum()
}

impl Kernel for Checks {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let (a, b) = (L::load(&A), L::load(&B));
        assert_eq!(bits(a.plus(b).store()), each(|a, b| a + b));
        assert_eq!(bits(a.minus(b).store()), each(|a, b| a - b));
        assert_eq!(bits(a.times(b).store()), each(|a, b| a * b));
        let (third, square) = (L::splat(3.0), a.times(a));
        assert_eq!(bits(a.over(third).store()), each(|a, _| a / 3.0));
        assert_eq!(bits(square.root().store()), each(|a, _| (a * a).sqrt()));
        assert_eq!((a.least(), a.greatest()), (-1e30, 1e30));
        assert_eq!((b.least(), L::splat(-2.0).greatest()), (-16.0, -2.0));
        let steps: [i32; WIDTH] = std::array::from_fn(|k| 1_048_577 * k as i32);
        let want = std::array::from_fn(|k| (steps[k] - 8_388_607) as f32);
        assert_eq!(L::wholes(-8_388_607, &steps).store(), want);
        assert_eq!(bits(a.larger(b).store()), each(|a, b| if a > b { a } else { b }));
        assert_eq!(bits(a.smaller(b).store()), each(|a, b| if a < b { a } else { b }));
        let turned = each(|a, b| if b.is_sign_negative() { -a } else { a });
        assert_eq!(bits(a.turned_by(b).store()), turned);
        let (below, at_most) = (a.below(b), a.at_most(b));
        assert_eq!(L::bits(below), truth(|a, b| a < b));
        assert_eq!(L::bits(at_most), truth(|a, b| a <= b));
        assert_eq!(L::bits(L::and(below, L::all(true))), truth(|a, b| a < b));
        assert_eq!(L::bits(L::or(below, L::all(false))), truth(|a, b| a < b));
        assert_eq!(L::bits(L::and(at_most, L::all(false))), 0);
        let chosen = each(|a, b| if a < b { a } else { b });
        assert_eq!(bits(a.where_else(below, b).store()), chosen);
        assert_eq!(L::splat(2.5).store(), [2.5; WIDTH]);
        let words: [u16; WIDTH] = std::array::from_fn(|k| 65535 - 999 * k as u16);
        let bytes: [u8; WIDTH] = std::array::from_fn(|k| 255 - 13 * k as u8);
        for mirror in Mirror::ALL {
            let want = std::array::from_fn(|k| f32::from(words[mirror.source(k)]));
            assert_eq!(L::from_u16(&words, mirror).store(), want);
            let want = std::array::from_fn(|k| f32::from(bytes[mirror.source(k)]));
            assert_eq!(L::from_u8(&bytes, mirror).store(), want);
        }
        let codes: [[u16; 8]; 5] =
            std::array::from_fn(|y| std::array::from_fn(|x| 40_000 + (100 * y + x) as u16));
        let floats = codes.map(|row| row.map(|code| f32::from(code) - 0.5));
        for backward in [false, true] {
            let sample = |x: usize, y: usize| codes[y][if backward { 4 - x } else { x }];
            let want = |dx: usize, dy: usize| {
                std::array::from_fn(|k| f32::from(sample(k % 4 + dx, k / 4 + dy)))
            };
            let want: [[f32; WIDTH]; 4] = [want(0, 0), want(1, 0), want(0, 1), want(1, 1)];
            let rows = std::array::from_fn(|k| &codes[k]);
            assert_eq!(L::corners_u16(rows, backward).map(L::store), want);
            let rows = std::array::from_fn(|k| &floats[k]);
            let want = want.map(|corner| corner.map(|h| h - 0.5));
            assert_eq!(L::corners_f32(rows, backward).map(L::store), want);
        }
    }
}

#[test]
fn every_level_does_plain_arithmetic() {
    for &level in SimdLevel::available() {
        run(level, Checks);
        run(level, QuadChecks);
    }
}

#[test]
fn levels_are_read_back_by_name() {
    for &level in SimdLevel::available() {
        assert_eq!(level.name().parse(), Ok(level));
    }
    let error = "mmx".parse::<SimdLevel>().unwrap_err().to_string();
    assert!(error.contains("portable"), "{error}");
}

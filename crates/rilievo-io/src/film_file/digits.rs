//! Sums as digits that f32 holds exactly, and the names of the channels that hold them.

use rilievo_render::film::{Counts, Film};

/// Digits of a sum.
pub(super) const DIGITS: usize = 5;

/// Bits of a digit.
const DIGIT_BITS: u32 = 24;

/// Digit `k` of a sum, from the least.
pub(super) fn digit(sum: i128, k: usize) -> f32 {
    let mask = (1 << DIGIT_BITS) - 1;
    let rest = sum >> (DIGIT_BITS * k as u32);
    (if k + 1 < DIGITS { rest & mask } else { rest }) as f32
}

/// What digit `k` adds to a sum; `None` if it is no whole number or too large.
pub(super) fn share(digit: f32, k: usize) -> Option<i128> {
    let (least, most) =
        if k + 1 < DIGITS { (0.0, 16_777_215.0) } else { (-8_388_608.0, 8_388_607.0) };
    let whole = (least..=most).contains(&digit) && digit.fract() == 0.0;
    whole.then(|| i128::from(digit as i32) << (DIGIT_BITS * k as u32))
}

/// A count of a pixel: as it is written, and as it is read back.
pub(super) struct Count {
    pub name: &'static str,
    pub get: fn(&Counts) -> i32,
    pub set: fn(&mut Counts, i32) -> Option<()>,
}

/// A count that is not negative.
fn put(to: &mut u32, count: i32) -> Option<()> {
    *to = u32::try_from(count).ok()?;
    Some(())
}

/// The counts: none is above 2^20.
pub(super) const COUNTS: [Count; 5] = [
    Count { name: "taken", get: |c| c.taken as i32, set: |c, n| put(&mut c.taken, n) },
    Count { name: "refused", get: |c| c.refused as i32, set: |c, n| put(&mut c.refused, n) },
    Count {
        name: "weight",
        get: |c| c.weight,
        set: |c, n| {
            c.weight = n;
            Some(())
        },
    },
    Count { name: "seen", get: |c| c.seen as i32, set: |c, n| put(&mut c.seen, n) },
    Count { name: "hits", get: |c| c.hits as i32, set: |c, n| put(&mut c.hits, n) },
];

/// The names of a film's sums, in the order in which a pixel keeps them.
pub(super) fn sum_names(film: &Film) -> Vec<&'static str> {
    let layers = film.layers().iter().flat_map(|layer| layer.aov().channels());
    ["R", "G", "B", "square"].into_iter().chain(layers.copied()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn whole(digits: [f32; DIGITS]) -> Option<i128> {
        digits.into_iter().enumerate().map(|(k, value)| share(value, k)).sum()
    }

    #[test]
    fn sums_are_their_digits() {
        let split = |sum| std::array::from_fn(|k| digit(sum, k));
        let edge = 1_i128 << 119;
        for sum in [0, 1, -1, 1 << 24, -(1 << 24), (1 << 96) - 1, -(1 << 96), edge - 1, -edge] {
            assert_eq!(whole(split(sum)), Some(sum), "{sum}");
        }
        let mut sum = 1_i128;
        for _ in 0..300 {
            sum = sum.wrapping_mul(0x1e37_79b9_7f4a_7c15_6a09_e667_f3bc_c909);
            let sum = sum >> 8;
            assert_eq!(whole(split(sum)), Some(sum));
        }
        for digits in [[0.5, 0.0, 0.0, 0.0, 0.0], [0.0, -1.0, 0.0, 0.0, 0.0]] {
            assert_eq!(whole(digits), None);
        }
        assert_eq!(whole([f32::NAN; DIGITS]), None);
        assert_eq!(whole([0.0, 0.0, 0.0, 0.0, 1e9]), None);
    }
}

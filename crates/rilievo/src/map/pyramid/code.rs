//! [`Code`]: raw heights to `u16` codes, rounded outward, and back.

use crate::map::height::{HeightMap, Samples};

/// `1.5 * 2^23`: adding it leaves no room for a fraction, and the low bits count wholes.
const WHOLE: f32 = 12_582_912.0;

/// The whole number nearest to one below 2^22 in size. Unlike a cast, for which SSE2 has no vector
/// that saturates, this is two additions.
#[inline(always)]
pub(super) fn nearest(x: f32) -> f32 {
    x + WHOLE - WHOLE
}

/// The low bits of the whole number nearest to one below 2^22 in size.
#[inline(always)]
pub(super) fn whole(x: f32) -> u32 {
    (x + WHOLE).to_bits()
}

/// The affine code of a bound.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Code {
    /// Value of code 0.
    pub base: f32,
    /// Value of one code step; 1 for `u16` heights, at least 0.
    pub step: f32,
}

impl Code {
    /// The code for a map's range of raw values.
    pub(super) fn for_heights(heights: &HeightMap) -> Self {
        let (lo, hi) = heights.raw_range();
        match heights.samples() {
            Samples::U16(_) => Self { base: 0.0, step: 1.0 },
            Samples::F32(_) => {
                let mut step = (hi - lo) / 65535.0;
                while lo + 65535.0 * step < hi {
                    step = step.next_up();
                }
                Self { base: lo, step }
            }
        }
    }

    /// The raw value of a code.
    #[inline]
    pub fn value(&self, code: u16) -> f32 {
        self.value_f32(f32::from(code))
    }

    /// The raw value of a code given as a whole number from 0 to 2^24, which `f32` holds exactly;
    /// it may lie above the codes of `u16`. Monotone in the code, as multiplication by a step that
    /// is not negative and addition are in floating point.
    #[inline]
    pub fn value_f32(&self, code: f32) -> f32 {
        self.base + code * self.step
    }

    /// The largest codes whose values are not above `low` and the smallest whose values are not
    /// below `high`, at every place; `low <= high`, both in the map's range. Where values are so
    /// close that both codes stand for the same one, the lower is taken for both.
    pub(super) fn encode(&self, low: &[f32], high: &[f32], min: &mut [u16], max: &mut [u16]) {
        let n = low.len();
        let (high, min, max) = (&high[..n], &mut min[..n], &mut max[..n]);
        // A first guess is right nearly always; comparisons prove it.
        let mut right = true;
        for i in 0..n {
            let (codes, proven) = self.guess(low[i], high[i]);
            (min[i], max[i]) = codes;
            right &= proven;
        }
        if right {
            return;
        }
        for i in 0..n {
            if !self.guess(low[i], high[i]).1 {
                let last = self.first_code(|value| value >= high[i]);
                // The first value is the map's lowest, so some code is not above.
                let first = self.first_code(|value| value > low[i]).saturating_sub(1);
                (min[i], max[i]) = (first.min(last) as u16, last as u16);
            }
        }
    }

    /// Codes for a lowest and a highest value, and whether they are those of [`Code::encode`].
    #[inline(always)]
    fn guess(&self, low: f32, high: f32) -> ((u16, u16), bool) {
        let near = |raw: f32| nearest(((raw - self.base) / self.step).clamp(0.0, 65535.0));
        let (down, up) = (near(low), near(high));
        let down = if self.value_f32(down) > low { down - 1.0 } else { down };
        let up = if self.value_f32(up) < high { up + 1.0 } else { up };
        let down_right = (self.value_f32(down) <= low) & (self.value_f32(down + 1.0) > low);
        let up_right = (self.value_f32(up) >= high) & (self.value_f32(up - 1.0) < high);
        ((whole(down) as u16, whole(up) as u16), down_right & (up_right | (up == 0.0)))
    }

    /// The first code, up to 65536, whose value `passes`; later ones pass too.
    fn first_code(&self, passes: impl Fn(f32) -> bool) -> u32 {
        let (mut from, mut to) = (0, 65536);
        while from < to {
            let middle = (from + to) / 2;
            if passes(self.value_f32(middle as f32)) {
                to = middle;
            } else {
                from = middle + 1;
            }
        }
        from
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::lattice::{Lattice, Wrap};

    fn code(samples: &[f32]) -> Code {
        let (n, samples) = (samples.len() as u32 / 2, Samples::F32(samples.to_vec()));
        let map = HeightMap::new(n, 2, samples, Lattice::Vertex, Wrap::Clamp).unwrap();
        Code::for_heights(&map)
    }

    /// Every range of the values given, by trying codes one by one.
    fn check(values: &[f32]) {
        let code = code(&[values, values].concat());
        for (k, &low) in values.iter().enumerate() {
            for &high in values[k..].iter().filter(|&&high| high >= low) {
                let (mut min, mut max) = ([0], [0]);
                code.encode(&[low], &[high], &mut min, &mut max);
                let last = (0..=u16::MAX).find(|&c| code.value(c) >= high).unwrap();
                let first = (0..=u16::MAX).rfind(|&c| code.value(c) <= low).unwrap();
                assert_eq!((min[0], max[0]), (first.min(last), last), "{low} to {high}");
            }
        }
    }

    #[test]
    fn codes_of_floats_are_the_tightest() {
        check(&[-1.0, -0.3, 0.1, 0.10001, 0.7, 2.0]);
        // On codes exactly.
        check(&[0.0, 1.0, 2.0, 300.0, 65534.0, 65535.0]);
        check(&[0.0, 1.0 / 255.0, 2.0 / 255.0, 254.0 / 255.0, 1.0]);
    }

    #[test]
    fn codes_of_floats_that_hardly_differ_do_not_cross() {
        check(&[3e6, 3e6 + 0.25, 3e6 + 0.5, 3e6 + 1.0]);
        check(&[-7.25, -7.25]);
        check(&[0.0, f32::from_bits(1), f32::from_bits(3)]);
    }
}

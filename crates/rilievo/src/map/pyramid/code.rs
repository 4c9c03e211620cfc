//! [`Code`]: raw heights to `u16` codes, rounded outward, and back.

use crate::map::height::{HeightMap, Samples};

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

    /// The smallest code whose value is not below `raw`.
    pub(super) fn above(&self, raw: f32) -> u16 {
        let mut code = self.estimate(raw);
        while code > 0 && self.value(code - 1) >= raw {
            code -= 1;
        }
        while code < u16::MAX && self.value(code) < raw {
            code += 1;
        }
        code
    }

    /// The largest code whose value is not above `raw`.
    pub(super) fn below(&self, raw: f32) -> u16 {
        let mut code = self.estimate(raw);
        while code < u16::MAX && self.value(code + 1) <= raw {
            code += 1;
        }
        while code > 0 && self.value(code) > raw {
            code -= 1;
        }
        code
    }

    fn estimate(&self, raw: f32) -> u16 {
        if self.step > 0.0 { ((raw - self.base) / self.step).clamp(0.0, 65535.0) as u16 } else { 0 }
    }
}

//! An image at half its width and height.

use super::texels::{Decoder, Level, Texels};
use crate::colour::{Rgb, srgb_from_linear};

/// The sRGB codes of linear values, in steps fine enough that a code is at most one off.
const STEPS: usize = 1 << 14;

/// `level` with half the texels along each axis, at least one. Each is the mean over the texels it
/// covers, by area.
pub(super) fn coarser(level: &Level, decoder: &Decoder) -> Level {
    let [width, height] = [level.width, level.height].map(|n| (n / 2).max(1));
    let columns: Vec<_> = (0..width).map(|i| cover(i, level.width, width)).collect();
    let mean = |i: u32, j: u32| {
        let (across, up) = (&columns[i as usize], cover(j, level.height, height));
        let mut sum = Rgb::ZERO;
        for (row, weight) in up.parts() {
            for (column, share) in across.parts() {
                sum += weight * share * decoder.texel(level, column, row);
            }
        }
        sum
    };
    let all = (0..height).flat_map(|j| (0..width).map(move |i| (i, j)));
    let means = all.map(|(i, j)| mean(i, j));
    let byte = |x: f64| (x * 255.0).round() as u8;
    let word = |x: f64| (x * 65535.0).round() as u16;
    let texels = match &level.texels {
        Texels::Srgb8(_) => {
            let codes: Vec<u8> = (0..=STEPS)
                .map(|step| byte(srgb_from_linear(step as f64 / STEPS as f64)))
                .collect();
            let code = |x: f64| codes[((x * STEPS as f64).round() as usize).min(STEPS)];
            Texels::Srgb8(means.map(|m| m.to_array().map(code)).collect())
        }
        Texels::Srgb16(_) => {
            let code = |x| word(srgb_from_linear(x));
            Texels::Srgb16(means.map(|m| m.to_array().map(code)).collect())
        }
        Texels::Linear8(_) => Texels::Linear8(means.map(|m| m.to_array().map(byte)).collect()),
        Texels::Linear16(_) => Texels::Linear16(means.map(|m| m.to_array().map(word)).collect()),
        Texels::Linear(_) => {
            Texels::Linear(means.map(|m| m.to_array().map(|x| x as f32)).collect())
        }
    };
    Level { width, height, texels }
}

/// The texels that a coarser one covers along an axis: at most four, with their shares.
struct Cover {
    first: u32,
    shares: [f64; 4],
    count: u32,
}

impl Cover {
    fn parts(&self) -> impl Iterator<Item = (u32, f64)> {
        (0..self.count).map(|k| (self.first + k, self.shares[k as usize]))
    }
}

/// What texel `i` of `to` covers of `from`, which are at most three times as many.
fn cover(i: u32, from: u32, to: u32) -> Cover {
    let length = f64::from(from) / f64::from(to);
    let (start, end) = (f64::from(i) * length, f64::from(i + 1) * length);
    let first = start.floor() as u32;
    let mut cover = Cover { first, shares: [0.0; 4], count: 0 };
    for (k, share) in cover.shares.iter_mut().enumerate() {
        let left = f64::from(first) + k as f64;
        let overlap = end.min(left + 1.0) - start.max(left);
        if overlap <= 1e-9 || first + k as u32 >= from {
            break;
        }
        *share = overlap / length;
        cover.count += 1;
    }
    cover
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_add_up_to_one() {
        for from in 1..200 {
            let to = (from / 2).max(1);
            for i in 0..to {
                let parts: Vec<_> = cover(i, from, to).parts().collect();
                let sum: f64 = parts.iter().map(|(_, share)| share).sum();
                assert!((sum - 1.0).abs() < 1e-9, "{from}: {i} covers {sum}");
                assert!(parts.iter().all(|&(k, _)| k < from));
            }
        }
    }
}

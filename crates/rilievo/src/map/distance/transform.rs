//! Lower envelope of parabolas \[Felzenszwalb2012\], with the kernel of boxes, without rounding.
//!
//! For a line `f(0..n)` the transform is `out(q) = min_v w max(|q - v| - 1, 0)^2 + f(v)`. For
//! integers `max(|m| - 1, 0)^2 = min over e in {-1, 0, 1} of (m - e)^2`: the kernel of boxes is the
//! parabola's after a 3-tap minimum. What is left is the ordinary lower envelope, in linear time,
//! here in the form of \[Meijster2000\]: two scans with integer separators.
//!
//! **No rounding.** `w` and all `f(v)` are integers held in f64, with `w n^2 + max f <= 2^51`.
//! Sums, differences and products below are integers under `2^53`, hence exact. The separator of
//! sites `s < u` is `floor(a / b)` with `b = 2 w (u - s)`. Let `x < n` be an integer that the
//! rounded quotient reaches although `a / b < x`; then `b x - a >= 1`, so `a / b` lies at least
//! `1 / b` under `x`, while rounding moves it by at most `x 2^-53`. That needs `b x >= 2^53`, but
//! `b x <= 2 w n^2 <= 2^52`. So the floor is right for every separator that matters (those below
//! `n`) and the result is the minimum itself, not an approximation of it. An f64 envelope of
//! unrounded squares may pick the wrong parabola and err upwards, the unsafe direction.

/// Working memory of the transform for lines up to some length.
#[derive(Debug)]
pub(super) struct Envelope {
    line: Vec<f64>,
    pieces: Vec<Piece>,
}

/// A piece of the lower envelope: from `start` on, the parabola over `site` is the lowest.
#[derive(Clone, Copy, Debug)]
struct Piece {
    start: f64,
    site: f64,
    /// Height of the parabola at its site.
    base: f64,
}

impl Piece {
    #[inline]
    fn at(&self, weight: f64, q: f64) -> f64 {
        let d = q - self.site;
        weight * d * d + self.base
    }
}

impl Envelope {
    /// For lines of at most `longest` entries.
    pub fn new(longest: usize) -> Self {
        Self { line: vec![0.0; longest], pieces: Vec::with_capacity(longest) }
    }

    /// Replaces `f` by its transform. `weight` and `f` hold integers, bounded as the module head
    /// says; `f` is not empty and not longer than the envelope was made for.
    pub fn transform(&mut self, weight: f64, f: &mut [f64]) {
        let n = f.len();
        let line = &mut self.line[..n];
        line.copy_from_slice(f);
        for (low, next) in line.iter_mut().zip(&f[1..]) {
            *low = low.min(*next);
        }
        for (low, before) in line[1..].iter_mut().zip(&*f) {
            *low = low.min(*before);
        }
        if weight == 0.0 {
            let least = line.iter().copied().fold(f64::INFINITY, f64::min);
            f.fill(least);
            return;
        }
        self.pieces.clear();
        let mut top = Piece { start: 0.0, site: 0.0, base: line[0] };
        for (u, &base) in line.iter().enumerate().skip(1) {
            let site = u as f64;
            let mut new = Piece { start: 0.0, site, base };
            let covered = loop {
                if top.at(weight, top.start) <= new.at(weight, top.start) {
                    break false;
                }
                match self.pieces.pop() {
                    Some(below) => top = below,
                    None => break true,
                }
            };
            if covered {
                top = new;
                continue;
            }
            let rise = base - top.base + weight * (site * site - top.site * top.site);
            // Not negative and below 2^53: the cast is the floor, without a call.
            new.start = (rise / (2.0 * weight * (site - top.site))) as i64 as f64 + 1.0;
            if new.start < n as f64 {
                self.pieces.push(top);
                top = new;
            }
        }
        self.pieces.push(top);
        let mut end = n;
        for piece in self.pieces.iter().rev() {
            let start = piece.start as usize;
            for (q, out) in f[start..end].iter_mut().enumerate() {
                *out = piece.at(weight, (start + q) as f64);
            }
            end = start;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn brute(weight: f64, f: &[f64]) -> Vec<f64> {
        let at = |q: usize, v: usize| {
            let gap = (q.abs_diff(v) as f64 - 1.0).max(0.0);
            weight * gap * gap + f[v]
        };
        (0..f.len()).map(|q| (0..f.len()).map(|v| at(q, v)).fold(f64::INFINITY, f64::min)).collect()
    }

    proptest! {
        #[test]
        fn the_envelope_is_the_brute_force_minimum(
            f in prop::collection::vec(0u64..1 << 50, 1..60),
            shift in 0u32..50,
            weight_bits in 0u32..38,
        ) {
            let weight = (1u64 << weight_bits) as f64 - 1.0;
            let mut line: Vec<f64> = f.iter().map(|v| (v >> shift) as f64).collect();
            let want = brute(weight, &line);
            Envelope::new(60).transform(weight, &mut line);
            prop_assert_eq!(line, want);
        }
    }

    #[test]
    fn one_site_spreads_as_a_parabola_with_a_flat_middle() {
        let mut f = vec![1e15; 9];
        f[4] = 0.0;
        Envelope::new(16).transform(2.0, &mut f);
        assert_eq!(f, [18.0, 8.0, 2.0, 0.0, 0.0, 0.0, 2.0, 8.0, 18.0]);
    }
}

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
    site: Vec<u32>,
    start: Vec<u32>,
}

impl Envelope {
    /// For lines of at most `longest` entries.
    pub fn new(longest: usize) -> Self {
        Self { line: vec![0.0; longest], site: vec![0; longest], start: vec![0; longest] }
    }

    /// Replaces `f` by its transform. `weight` and `f` hold integers, bounded as the module head
    /// says.
    pub fn transform(&mut self, weight: f64, f: &mut [f64]) {
        let n = f.len();
        let line = &mut self.line[..n];
        for v in 0..n {
            let (a, b) = (f[v.saturating_sub(1)], f[(v + 1).min(n - 1)]);
            line[v] = f[v].min(a).min(b);
        }
        if weight == 0.0 {
            let least = line.iter().copied().fold(f64::INFINITY, f64::min);
            f.fill(least);
            return;
        }
        let value = |q: u32, v: u32| {
            let d = f64::from(q) - f64::from(v);
            weight * d * d + line[v as usize]
        };
        let (site, start) = (&mut self.site[..n], &mut self.start[..n]);
        (site[0], start[0]) = (0, 0);
        let mut top = 0usize;
        for u in 1..n as u32 {
            while value(start[top], site[top]) > value(start[top], u) {
                if top == 0 {
                    site[0] = u;
                    break;
                }
                top -= 1;
            }
            let s = site[top];
            if s == u {
                continue;
            }
            let (us, uu) = (f64::from(s), f64::from(u));
            let a = line[u as usize] - line[s as usize] + weight * (uu * uu - us * us);
            let next = (a / (2.0 * weight * (uu - us))).floor() + 1.0;
            if next < n as f64 {
                top += 1;
                (site[top], start[top]) = (u, next as u32);
            }
        }
        for q in (0..n as u32).rev() {
            f[q as usize] = value(q, site[top]);
            if q == start[top] && top > 0 {
                top -= 1;
            }
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

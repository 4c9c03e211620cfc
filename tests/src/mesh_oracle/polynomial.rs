//! Polynomials by their coefficients, lowest first, and their roots in [0, 1].

/// The product of two, of `N` coefficients.
pub fn times<const A: usize, const B: usize, const N: usize>(
    a: &[f64; A],
    b: &[f64; B],
) -> [f64; N] {
    let mut product = [0.0; N];
    for (i, a) in a.iter().enumerate() {
        for (j, b) in b.iter().enumerate() {
            product[i + j] += a * b;
        }
    }
    product
}

/// Adds a multiple.
pub fn add<const N: usize, const M: usize>(to: &mut [f64; N], other: &[f64; M], factor: f64) {
    for (to, x) in to.iter_mut().zip(other) {
        *to += factor * x;
    }
}

/// Bernstein coefficients over [0, 1]: values there lie between the smallest and the largest.
pub fn bernstein<const N: usize>(coefficients: &[f64; N]) -> [f64; N] {
    let choose = |n: usize, k: usize| (0..k).fold(1.0, |c, i| c * (n - i) as f64 / (i + 1) as f64);
    std::array::from_fn(|i| {
        (0..=i).map(|k| choose(i, k) / choose(N - 1, k) * coefficients[k]).sum()
    })
}

/// Roots are known to this.
const WIDTH: f64 = 1e-15;

/// Roots in [0, 1].
pub fn roots<const N: usize>(coefficients: &[f64; N]) -> Vec<f64> {
    let mut found = Vec::new();
    separate(bernstein(coefficients), 0.0, 1.0, &mut found);
    found
}

/// Adds the roots between `from` and `to` of a polynomial by its Bernstein coefficients there.
fn separate<const N: usize>(b: [f64; N], from: f64, to: f64, found: &mut Vec<f64>) {
    if b[0] == 0.0 {
        found.push(from);
    }
    if b.iter().all(|&b| b >= 0.0) || b.iter().all(|&b| b <= 0.0) {
        return;
    }
    if to - from < WIDTH {
        found.push(0.5 * (from + to));
        return;
    }
    // One change of sign is one root.
    let changes = b.windows(2).filter(|pair| (pair[0] < 0.0) != (pair[1] < 0.0)).count();
    if changes == 1
        && let Some(at) = bracketed(&b, WIDTH / (to - from))
    {
        found.push(from + at * (to - from));
        return;
    }
    let (mut low, mut high) = ([0.0; N], [0.0; N]);
    let mut row = b;
    for k in 0..N {
        low[k] = row[0];
        high[N - 1 - k] = row[N - 1 - k];
        for i in 0..N - 1 - k {
            row[i] = 0.5 * (row[i] + row[i + 1]);
        }
    }
    let middle = 0.5 * (from + to);
    separate(low, from, middle, found);
    separate(high, middle, to, found);
}

/// The value at `s` by Bernstein coefficients.
fn value<const N: usize>(b: &[f64; N], s: f64) -> f64 {
    let (mut power, mut choose, mut sum) = (1.0, 1.0, b[0]);
    for (i, b) in b.iter().enumerate().skip(1) {
        power *= s;
        choose *= (N - i) as f64 / i as f64;
        sum = sum * (1.0 - s) + choose * power * b;
    }
    sum
}

/// The only root in [0, 1], to `width`, by chords: values on both sides of what is returned, half a width away,
/// differ in sign. None if chords do not get there soon.
fn bracketed<const N: usize>(b: &[f64; N], width: f64) -> Option<f64> {
    let ([mut low, mut high], [mut at_low, mut at_high]) = ([0.0, 1.0], [b[0], b[N - 1]]);
    let mut last_low = None;
    for _ in 0..24 {
        if (at_low < 0.0) == (at_high < 0.0) {
            return None;
        }
        let s: f64 = low + (high - low) * (at_low / (at_low - at_high));
        let ends = [(s - 0.5 * width).max(low), (s + 0.5 * width).min(high)];
        let at_ends = ends.map(|end| value(b, end));
        if (at_ends[0] < 0.0) != (at_ends[1] < 0.0) {
            return Some(s);
        }
        // A side that stays twice counts half, so that it does not stay for long.
        let is_low = (at_ends[0] < 0.0) == (at_low < 0.0);
        let again = if last_low == Some(is_low) { 0.5 } else { 1.0 };
        last_low = Some(is_low);
        if is_low {
            (low, at_low, at_high) = (ends[1], at_ends[1], again * at_high);
        } else {
            (high, at_high, at_low) = (ends[0], at_ends[0], again * at_low);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roots_of_known_polynomials() {
        // (s - 1/4)(s - 1/2)(s - 3/4), and with a double root at 1/3.
        let square: [f64; 3] = times(&[-0.25, 1.0], &[-0.5, 1.0]);
        let cubic: [f64; 4] = times(&square, &[-0.75, 1.0]);
        let found = roots(&cubic);
        assert_eq!(found.len(), 3);
        assert!(found.iter().zip([0.25, 0.5, 0.75]).all(|(a, b)| (a - b).abs() < 1e-12));
        assert!(roots(&[1.0, 0.0, 1.0]).is_empty());
        assert_eq!(roots(&[0.0, 1.0]), [0.0]);
        // Flat and steep, at many places.
        for k in 1..400 {
            let root = f64::from(k) / 400.0;
            for rest in [[1.0, 0.0, 1e-6], [1e-3, 0.2, 5.0], [3.0, -5.0, 2.1]] {
                let quartic: [f64; 4] = times(&[-root, 1.0], &rest);
                let found = roots(&quartic);
                assert_eq!(found.len(), 1, "{root} {rest:?}");
                assert!((found[0] - root).abs() < 1e-12, "{found:?} {root} {rest:?}");
            }
        }
    }
}

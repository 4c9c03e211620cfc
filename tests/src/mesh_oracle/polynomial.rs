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
    if to - from < 1e-15 {
        found.push(0.5 * (from + to));
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
    }
}

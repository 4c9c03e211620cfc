//! Rounding error of `f64` arithmetic.

/// Bound on the relative error of a product of `n` factors `(1 + e)`, `|e| <= u = 2^-53`:
/// `n u / (1 - n u)` \[Higham2002, lemma 3.1\].
pub(crate) const fn gamma(n: u32) -> f64 {
    let nu = n as f64 * (0.5 * f64::EPSILON);
    nu / (1.0 - nu)
}

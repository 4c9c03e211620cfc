//! What slopes that a level of detail does not show make of a lobe; why so, see `level_of_detail::roughness`.
//!
//! Nothing is lost but with level of detail, and then all is as it was to the last bit.

/// The GGX width of facets of width `alpha` that stand on slopes of the variance `lost`, at most 1.
pub(crate) fn widened(alpha: f64, lost: f64) -> f64 {
    if lost > 0.0 { (alpha * alpha + lost).sqrt().min(1.0) } else { alpha }
}

/// The roughness of a diffuser of roughness `own` whose facets stand on slopes of the variance `lost`.
pub(super) fn dulled(own: f64, lost: f64) -> f64 {
    if lost <= 0.0 {
        return own;
    }
    let angle = lost.sqrt().atan();
    let square = angle * angle;
    let steady = 1.0 - 0.5 * square / (square + 0.33);
    let turning = 0.45 * square / (square + 0.09);
    own + (1.0 - own) * (turning / steady).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lobes_grow_with_what_is_lost_and_stay_in_range() {
        assert_eq!((widened(0.3, 0.0), dulled(0.3, 0.0)), (0.3, 0.3));
        // Variances of slopes add up: alpha^2 / 2 is that of facets along each axis.
        let both = widened(widened(0.2, 0.05), 0.01);
        assert!((both - widened(0.2, 0.06)).abs() < 1e-15);
        let (mut wide, mut dull) = (0.1, 0.1);
        for lost in [1e-6, 0.01, 0.1, 0.5, 2.0, 1e9] {
            let next = (widened(0.1, lost), dulled(0.1, lost));
            assert!(next.0 >= wide && next.1 >= dull && next.0 <= 1.0 && next.1 <= 1.0);
            (wide, dull) = next;
        }
        assert!(wide == 1.0 && dull > 0.6);
    }
}

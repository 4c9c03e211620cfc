//! Random numbers by place: a hash of what is asked for, so that no order matters.

/// A number in `[0, 1)` with 24 bits, for draw `draw` of ray `ray`.
pub fn unit(ray: u64, draw: u32) -> f64 {
    let bits = mix(ray.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ mix(u64::from(draw) + 1));
    (bits >> 40) as f64 / (1u64 << 24) as f64
}

/// The finaliser of SplitMix64 \[Steele2014\].
fn mix(mut z: u64) -> u64 {
    z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ z >> 31
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn draws_are_spread_and_independent() {
        let n = 10_000;
        for draw in 0..4 {
            let mean = (0..n).map(|ray| unit(ray, draw)).sum::<f64>() / n as f64;
            assert!((mean - 0.5).abs() < 0.02, "{mean}");
        }
        let product = (0..n).map(|ray| (unit(ray, 0) - 0.5) * (unit(ray, 1) - 0.5));
        assert!(product.sum::<f64>().abs() / (n as f64) < 0.005);
    }
}

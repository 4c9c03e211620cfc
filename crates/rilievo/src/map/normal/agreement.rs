//! [`NormalAgreement`]: how well a normal map and a height map describe the same relief.
//!
//! Both give slopes. Those of the heights are central differences over one sample, times an unknown
//! depth; those of the normals are `-n.x / n.z` and `-n.y / n.z`. Their correlation along u tells
//! whether black is high, the sign of that along v against it which way green points. The depth is
//! the one that makes the mean angle between the two smallest: a search over its logarithm, first
//! coarse, then by golden section. At most about 2^16 texels on a regular grid are compared.

use glam::DVec3;

use super::{NormalConvention, NormalMap};
use crate::map::HeightMap;

/// Texels compared along an axis, about.
const TEXELS: u32 = 256;
/// Depths tried, in widths of the map.
const DEPTHS: [f64; 2] = [1e-4, 2.0];
/// Coarse steps between them.
const STEPS: u32 = 48;
/// Steps of the golden section: the depth is then known to about 1e-4 of itself.
const SECTIONS: u32 = 16;
/// A correlation below this says nothing about a sign.
const CLEAR: f64 = 0.15;

/// How well a normal map agrees with heights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalAgreement {
    /// Correlation of the slopes along u and v, -1 to 1, of the normals read with green up.
    pub correlation: [f64; 2],
    /// Whether the normals take black for high.
    pub inverted: bool,
    /// Which way green points; none if the slopes along v do not tell.
    pub convention: Option<NormalConvention>,
    /// The depth that fits best: the height of a full range from 0 to 1, in widths of the map.
    pub depth: f64,
    /// Mean angle between the normals at that depth, degrees.
    pub mean: f64,
    /// The angle that half of the texels stay below, degrees.
    pub median: f64,
    /// The angle that 95 of 100 texels stay below, degrees.
    pub percentile_95: f64,
    /// Mean angle of the author's normals to the flat face: what depth 0 would give.
    pub flat: f64,
}

/// Slopes of one texel: of the heights, for a depth of one width, and the author's normal.
struct Texel {
    slopes: [f64; 2],
    normal: DVec3,
}

impl NormalAgreement {
    /// Compares `normals`, read as [`NormalConvention::OpenGl`], with `heights`. Sizes may differ.
    /// The shape of a texel is taken as square.
    pub fn of(heights: &HeightMap, normals: &NormalMap) -> Self {
        let texels = texels(heights, normals);
        let correlation = [0, 1].map(|axis| correlation(&texels, axis));
        let clear = correlation.map(|c| c.abs() >= CLEAR);
        let inverted = match clear {
            [true, _] => correlation[0] < 0.0,
            [false, _] => false,
        };
        let upright = (correlation[1] < 0.0) == inverted;
        let convention = clear[1].then_some(match upright {
            true => NormalConvention::OpenGl,
            false => NormalConvention::DirectX,
        });
        let signs = [
            if inverted { -1.0 } else { 1.0 },
            if (correlation[1] < 0.0) && clear[1] { -1.0 } else { 1.0 },
        ];
        let depth = best_depth(|depth| mean(&texels, depth, signs));
        let mut angles: Vec<f64> = texels.iter().map(|t| t.angle(depth, signs)).collect();
        angles.sort_unstable_by(f64::total_cmp);
        let at = |share: f64| angles[(share * (angles.len() - 1) as f64) as usize].to_degrees();
        Self {
            correlation,
            inverted,
            convention,
            depth,
            mean: mean(&texels, depth, signs).to_degrees(),
            median: at(0.5),
            percentile_95: at(0.95),
            flat: mean(&texels, 0.0, signs).to_degrees(),
        }
    }
}

impl Texel {
    /// Radians between the author's normal and that of the heights.
    fn angle(&self, depth: f64, signs: [f64; 2]) -> f64 {
        let [x, y] = [0, 1].map(|axis| -self.slopes[axis] * depth * signs[axis]);
        DVec3::new(x, y, 1.0).angle_between(self.normal)
    }
}

fn texels(heights: &HeightMap, normals: &NormalMap) -> Vec<Texel> {
    let size = [normals.x().samples(), normals.y().samples()];
    let step = size.map(|n| n.div_ceil(TEXELS));
    let reach = [1.0 / f64::from(heights.width()), 1.0 / f64::from(heights.height())];
    // Texels are square, so v runs over height / width widths.
    let aspect = f64::from(heights.height()) / f64::from(heights.width());
    let along = |axis: usize| {
        (step[axis] / 2..size[axis])
            .step_by(step[axis] as usize)
            .map(move |i| (f64::from(i) + 0.5) / f64::from(size[axis]))
    };
    let mut all = Vec::new();
    for v in along(1) {
        for u in along(0) {
            let [du, dv] = reach;
            let across = heights.height_at(u + du, v) - heights.height_at(u - du, v);
            let up = heights.height_at(u, v + dv) - heights.height_at(u, v - dv);
            let slopes = [across / (2.0 * du), up / (2.0 * dv) / aspect];
            all.push(Texel { slopes, normal: normals.normal_at(u, v) });
        }
    }
    all
}

/// Pearson's coefficient of the two slopes along an axis; 0 where one of them is constant.
fn correlation(texels: &[Texel], axis: usize) -> f64 {
    let pair = |t: &Texel| {
        let n = t.normal.to_array();
        (t.slopes[axis], -n[axis] / n[2])
    };
    let count = texels.len() as f64;
    let (a, b) = texels.iter().map(pair).fold((0.0, 0.0), |s, (a, b)| (s.0 + a, s.1 + b));
    let (a, b) = (a / count, b / count);
    let (mut aa, mut bb, mut ab) = (0.0, 0.0, 0.0);
    for (x, y) in texels.iter().map(pair) {
        aa += (x - a) * (x - a);
        bb += (y - b) * (y - b);
        ab += (x - a) * (y - b);
    }
    let scale = (aa * bb).sqrt();
    if scale > 0.0 { ab / scale } else { 0.0 }
}

/// Mean angle, radians.
fn mean(texels: &[Texel], depth: f64, signs: [f64; 2]) -> f64 {
    texels.iter().map(|t| t.angle(depth, signs)).sum::<f64>() / texels.len() as f64
}

/// The depth in [`DEPTHS`] with the smallest `error`.
fn best_depth(error: impl Fn(f64) -> f64) -> f64 {
    let [low, high] = DEPTHS.map(f64::ln);
    let step = (high - low) / f64::from(STEPS);
    let place = |k: u32| low + step * f64::from(k);
    let errors: Vec<f64> = (0..=STEPS).map(|k| error(place(k).exp())).collect();
    let best = (0..=STEPS).min_by(|&a, &b| errors[a as usize].total_cmp(&errors[b as usize]));
    let (mut from, mut to) = (place(best.unwrap_or(0)) - step, place(best.unwrap_or(0)) + step);
    let golden = 0.5 * (5f64.sqrt() - 1.0);
    for _ in 0..SECTIONS {
        let (a, b) = (to - golden * (to - from), from + golden * (to - from));
        if error(a.exp()) < error(b.exp()) { to = b } else { from = a }
    }
    (0.5 * (from + to)).exp()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::{Lattice, Metric, NormalKind, NormalTexels, Procedural, Samples, Wrap};

    fn noise() -> HeightMap {
        let shape = Procedural::Fbm { octaves: 4, seed: 3 };
        shape.height_map([64, 32], Lattice::Texel, Wrap::Repeat).unwrap()
    }

    /// Normals of `map` at depth 0.1, through 16-bit texels of one convention, read as OpenGL.
    fn normals(map: &HeightMap, convention: NormalConvention) -> NormalMap {
        let metric = Metric::of_face(map, [1.0, 0.5], 0.1);
        let baked = NormalMap::from_height(map, NormalKind::Smooth, metric);
        let texels = NormalTexels::U16(baked.to_texels(convention));
        let lattice = (Lattice::Texel, Wrap::Repeat);
        NormalMap::from_texels([64, 32], &texels, NormalConvention::OpenGl, lattice).unwrap()
    }

    #[test]
    fn a_map_agrees_with_its_own_normals_at_its_own_depth() {
        let map = noise();
        for convention in [NormalConvention::OpenGl, NormalConvention::DirectX] {
            let found = NormalAgreement::of(&map, &normals(&map, convention));
            assert_eq!((found.convention, found.inverted), (Some(convention), false));
            assert!((found.depth / 0.1 - 1.0).abs() < 1e-3, "{found:?}");
            assert!(found.percentile_95 < 0.05 && found.flat > 5.0, "{found:?}");
            assert!(found.correlation[0] > 0.999, "{found:?}");
        }
    }

    #[test]
    fn a_map_of_depths_is_found_out() {
        let map = noise();
        let Samples::U16(codes) = map.samples() else { panic!("codes") };
        let turned = Samples::U16(codes.iter().map(|c| 65535 - c).collect());
        let turned = HeightMap::new(64, 32, turned, Lattice::Texel, Wrap::Repeat).unwrap();
        for convention in [NormalConvention::OpenGl, NormalConvention::DirectX] {
            let found = NormalAgreement::of(&turned, &normals(&map, convention));
            assert_eq!((found.convention, found.inverted), (Some(convention), true));
            assert!(found.mean < 0.05, "{found:?}");
        }
    }

    #[test]
    fn normals_of_something_else_agree_badly_and_a_flat_map_not_at_all() {
        let map = noise();
        let other = Procedural::Fbm { octaves: 4, seed: 9 };
        let other = other.height_map([64, 32], Lattice::Texel, Wrap::Repeat).unwrap();
        let found = NormalAgreement::of(&map, &normals(&other, NormalConvention::OpenGl));
        assert!(found.mean > 0.9 * found.flat, "{found:?}");
        let flat = Procedural::Flat { value: 0.5 };
        let flat = flat.height_map([64, 32], Lattice::Texel, Wrap::Repeat).unwrap();
        let found = NormalAgreement::of(&flat, &normals(&map, NormalConvention::OpenGl));
        assert_eq!((found.correlation, found.convention), ([0.0; 2], None));
        assert!((found.mean - found.flat).abs() < 1e-9);
    }
}

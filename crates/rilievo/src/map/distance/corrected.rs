//! Kind `corrected`: exact distances at nodes, read with the correction that interpolation needs.
//!
//! **Nodes.** Each node holds the largest code that is not above its true distance to the
//! continuous bilinear surface, less the margin of the domain. The distance comes from branch and
//! bound ([`exact_distance`](super::exact_distance)), narrowed until both bounds give one code, so
//! that a code is as high as it may be and does not depend on how it was found.
//!
//! **Reading.** The distance `d` to a set is 1-Lipschitz: `d(p) >= d(x) - |p - x|`. Let the nodes
//! `x_i` of the voxel that holds `p` store `d_i <= d(x_i)`, let `w_i` be the trilinear weights of
//! `p`, `u` its local coordinates and `s` the voxel's sides in scene units. Then
//!
//! ```text
//! d(p) >= max_i (d_i - |p - x_i|)                                              (1)
//!      >= sum_i w_i d_i - sum_i w_i |p - x_i|                                  (2)
//!      >= I(p) - sqrt(sum_i w_i |p - x_i|^2) = I(p) - sqrt(sum_k s_k^2 u_k (1 - u_k))   (3)
//! ```
//!
//! (2) holds because a mean is at most the maximum, (3) by Jensen's inequality for the concave
//! square root; the mean of `|p - x_i|^2` is the variance of the weights, which separates by axes.
//! (3) is the trilinear interpolation `I` less a correction that is 0 at nodes and half the voxel's
//! diagonal in its middle. We read (1): the same eight codes, never a shorter step, and no mixing
//! of a stored 0 (which may be the true distance itself, without margin) into a positive result.
//!
//! The seed interpolates upper bounds without a correction, see [`published`](super::published).
//! Conservative readings of cone maps are due to \[Ban2024\]; this is the same thought for distances.

use rayon::prelude::*;

use super::codes::{Code, Quantiser};
use super::domain::Domain;
use super::exact::Nearest;
use crate::map::{HeightMap, Pyramid};

/// Exact node codes of one height map.
#[derive(Clone, Copy, Debug)]
pub(super) struct Nodes<'a> {
    pub heights: &'a HeightMap,
    pub pyramid: &'a Pyramid,
    pub domain: &'a Domain,
    pub size: [u32; 3],
    pub quantiser: Quantiser,
}

impl<'a> Nodes<'a> {
    /// A search for [`Nodes::code`].
    pub fn search(&self) -> Nearest<'a> {
        Nearest::new(self.heights, self.pyramid, self.domain.metric)
    }

    /// The highest safe code of node (i, j, k).
    pub fn code(&self, node: [u32; 3], search: &mut Nearest<'_>) -> u32 {
        let p = std::array::from_fn(|a| self.domain.division(a, node[a], self.size[a] - 1));
        // The margin keeps exact multiples of the quantum clear of the decision, so a quarter of
        // it is a tolerance that always decides the same way there.
        let tolerance = self.domain.margin() * 0.25;
        let (lower, _) = search.bounds(p, |lower, upper| {
            upper - lower <= tolerance || self.quantiser.code(lower) == self.quantiser.code(upper)
        });
        self.quantiser.code(lower)
    }

    /// The codes of all nodes; rows of nodes in parallel.
    pub fn codes<C: Code>(&self) -> Vec<C> {
        let [nx, ny, nz] = self.size;
        let mut codes = vec![C::default(); nx as usize * ny as usize * nz as usize];
        codes.par_chunks_mut(nx as usize).enumerate().for_each_init(
            || self.search(),
            |search, (row, out)| {
                search.forget();
                let (j, k) = (row as u32 % ny, row as u32 / ny);
                for (i, code) in out.iter_mut().enumerate() {
                    *code = C::store(self.code([i as u32, j, k], search));
                }
            },
        );
        codes
    }
}

/// Bound (1) of the module head: `nodes[4 k + 2 j + i]` are the stored distances of a voxel's
/// corners, `local` the position in it, `sides` its sides in scene units. At least 0.
#[inline]
pub(super) fn safe(nodes: [f64; 8], local: [f64; 3], sides: [f64; 3]) -> f64 {
    let square = |a: usize| {
        let (near, far) = (local[a] * sides[a], (1.0 - local[a]) * sides[a]);
        [near * near, far * far]
    };
    let (x, y, z) = (square(0), square(1), square(2));
    let mut best = 0.0f64;
    for (at, d) in nodes.into_iter().enumerate() {
        let away = x[at & 1] + y[at >> 1 & 1] + z[at >> 2];
        best = best.max(d - away.sqrt());
    }
    best
}

/// Trilinear interpolation; arguments as for [`safe`].
#[inline]
pub(super) fn trilinear(nodes: [f64; 8], [u, v, w]: [f64; 3]) -> f64 {
    let lerp = |a: f64, b: f64, t: f64| a + (b - a) * t;
    let plane = |n: [f64; 4]| lerp(lerp(n[0], n[1], u), lerp(n[2], n[3], u), v);
    let [a, b, c, d, e, f, g, h] = nodes;
    lerp(plane([a, b, c, d]), plane([e, f, g, h]), w)
}

#[cfg(test)]
mod tests {
    use super::super::fixtures::{Random, cases};
    use super::*;
    use crate::map::{DistanceBits, DistanceKind, DistanceMap, DistanceOptions, exact_distance};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_reading_is_at_least_the_corrected_interpolation(
            nodes in prop::array::uniform8(0.0..2.0f64),
            local in prop::array::uniform3(0.0..=1.0f64),
            sides in prop::array::uniform3(0.01..3.0f64),
        ) {
            let variance: f64 = (0..3)
                .map(|k| sides[k] * sides[k] * local[k] * (1.0 - local[k]))
                .sum();
            let corrected = trilinear(nodes, local) - variance.sqrt();
            prop_assert!(safe(nodes, local, sides) >= corrected - 1e-12);
        }
    }

    #[test]
    fn no_reading_is_above_the_true_distance_and_node_codes_are_tight() {
        let mut random = Random(2);
        for (map, metric) in cases() {
            let pyramid = Pyramid::build(&map);
            for (size, bits) in [
                ([4, 5, 6], DistanceBits::U16),
                ([2, 2, 2], DistanceBits::U8),
                ([9, 7, 4], DistanceBits::U16),
            ] {
                let options = DistanceOptions { size, metric, bits };
                let kind = DistanceKind::Corrected;
                let stored = DistanceMap::from_height(&map, kind, &options).unwrap();
                let domain = Domain::of(&map, metric).unwrap();
                for at in 0..size.iter().product() {
                    let node = [at % size[0], at / size[0] % size[1], at / size[0] / size[1]];
                    let p = std::array::from_fn(|a| domain.division(a, node[a], size[a] - 1));
                    let (lower, upper) = exact_distance(&map, &pyramid, metric, p, 0.0);
                    let d = stored.at(node[0], node[1], node[2]);
                    assert!(d <= upper && d + stored.quantum() * (1.0 + 1e-9) + 1e-12 > lower);
                }
                let [low, high] = [domain.low(), domain.high()];
                for _ in 0..60 {
                    let p = random.point((low, high));
                    let (_, upper) = exact_distance(&map, &pyramid, metric, p, 0.0);
                    let d = stored.safe_distance(p);
                    assert!(d <= upper, "{size:?} {p:?}: {d} over {upper}");
                }
            }
        }
    }

    #[test]
    fn uncorrected_interpolation_of_exact_nodes_overshoots() {
        let (map, metric) = cases().swap_remove(0);
        let pyramid = Pyramid::build(&map);
        let options = DistanceOptions { size: [7, 5, 8], metric, bits: DistanceBits::U16 };
        let stored = DistanceMap::from_height(&map, DistanceKind::Corrected, &options).unwrap();
        let domain = Domain::of(&map, metric).unwrap();
        let mut random = Random(8);
        let over = (0..400)
            .filter(|_| {
                let p = random.point((domain.low(), domain.high()));
                let (nodes, local) = stored.corners_at(p);
                let (_, upper) = exact_distance(&map, &pyramid, metric, p, 0.0);
                trilinear(nodes, local) > upper
            })
            .count();
        // 180 when written.
        assert!(over > 120, "{over} of 400");
    }

    #[test]
    fn a_node_reads_as_it_is_stored() {
        let nodes = [0.5, 0.1, 0.2, 0.3, 0.4, 0.1, 0.2, 0.3];
        assert_eq!(safe(nodes, [0.0; 3], [1.0; 3]), 0.5);
        assert_eq!(trilinear(nodes, [0.0, 0.0, 1.0]), 0.4);
    }
}

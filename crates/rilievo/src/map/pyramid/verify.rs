//! [`Pyramid::verify`]: whether stored bounds, from a file say, enclose the surface.

use super::level::LANES;
use super::{Layout, Level, LevelBounds, Pyramid};
use crate::map::HeightMap;

/// A stored bound that cuts the surface, or does not fit it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PyramidViolation {
    /// The pyramid was built for another grid of cells or another code.
    #[error("the pyramid was made for another height map")]
    Shape,
    /// An upper bound below the surface.
    #[error("level {level}, node {node}, lane {lane}: maximum {stored} is below {needed}")]
    Maximum {
        /// Level, node index within it and lane.
        level: u32,
        /// Index of the node, row-major.
        node: u32,
        /// Lane within the node.
        lane: u32,
        /// The stored code.
        stored: u32,
        /// The smallest safe code.
        needed: u32,
    },
    /// A lower bound above the surface.
    #[error("level {level}, node {node}, lane {lane}: minimum {stored} is above {needed}")]
    Minimum {
        /// Level, node index within it and lane.
        level: u32,
        /// Index of the node, row-major.
        node: u32,
        /// Lane within the node.
        lane: u32,
        /// The stored code.
        stored: u32,
        /// The largest safe code.
        needed: u32,
    },
    /// The range of a tiny node, from which the level above is made, cuts the surface.
    #[error("level {level}, node {node}: range {stored:?} does not hold {needed:?}")]
    Range {
        /// Level of the node.
        level: u32,
        /// Index of the node, row-major.
        node: u32,
        /// The stored codes.
        stored: [u16; 2],
        /// The exact codes.
        needed: [u16; 2],
    },
}

impl Pyramid {
    /// Checks that no stored bound cuts the surface.
    ///
    /// # Errors
    /// The first bound that does. Any bound of a freshly built pyramid that is moved inward by one
    /// step is such a bound.
    pub fn verify(&self, heights: &HeightMap) -> Result<(), PyramidViolation> {
        let sound = Self::build(heights);
        let fits = |have: &Level, want: &Level| {
            let nodes = want.nodes[0] as usize * want.nodes[1] as usize;
            have.nodes == want.nodes && have.bounds.fits(nodes, self.layout)
        };
        if self.cells != sound.cells
            || self.code != sound.code
            || self.levels.len() != sound.levels.len()
            || !self.levels.iter().zip(&sound.levels).all(|(a, b)| fits(a, b))
        {
            return Err(PyramidViolation::Shape);
        }
        for (level, (have, want)) in (0..).zip(self.levels.iter().zip(&sound.levels)) {
            verify_level(level, &have.bounds, &want.bounds)?;
        }
        Ok(())
    }
}

/// Compares the bounds of a level with the exact ones.
fn verify_level(
    level: u32,
    have: &LevelBounds,
    want: &LevelBounds,
) -> Result<(), PyramidViolation> {
    let nodes = (want.bytes() / Layout::Default.node_bytes()) as u32;
    for node in 0..nodes {
        let at = node as usize;
        let [stored_max, stored_min] = have.node(at).codes().map(|codes| codes.map(|c| c as u32));
        let [max, min] = want.node(at).codes().map(|codes| codes.map(|c| c as u32));
        let occupied = (0..LANES).filter(|&k| min[k] <= max[k]);
        for (k, lane) in occupied.map(|k| (k, k as u32)) {
            let (stored, needed) = (stored_max[k], max[k]);
            if stored < needed {
                return Err(PyramidViolation::Maximum { level, node, lane, stored, needed });
            }
            let (stored, needed) = (stored_min[k], min[k]);
            if stored > needed {
                return Err(PyramidViolation::Minimum { level, node, lane, stored, needed });
            }
        }
        let (stored, needed) = (have.range(at), want.range(at));
        if stored[0] > needed[0] || stored[1] < needed[1] {
            return Err(PyramidViolation::Range { level, node, stored, needed });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::NodeBounds;
    use super::super::tests::maps;
    use super::*;

    /// What is found after `change` of a level of a copy.
    fn found(
        (sound, map): (&Pyramid, &HeightMap),
        level: usize,
        change: impl FnOnce(&mut LevelBounds),
    ) -> PyramidViolation {
        let mut cut = sound.clone();
        change(&mut cut.levels[level].bounds);
        cut.verify(map).expect_err("a bound that cuts")
    }

    #[test]
    fn every_bound_moved_inward_by_one_step_is_caught() {
        for (map, layout) in maps().iter().flat_map(|map| Layout::ALL.map(|layout| (map, layout))) {
            let sound = Pyramid::build_as(map, layout);
            assert_eq!(sound.verify(map), Ok(()));
            for (level, nodes) in sound.levels.iter().map(|l| l.nodes).enumerate() {
                for node in 0..(nodes[0] * nodes[1]) as usize {
                    for lane in 0..LANES {
                        check_lane((&sound, map), level, (node, lane));
                    }
                    check_range((&sound, map), level, node);
                }
            }
        }
    }

    fn check_lane(sound: (&Pyramid, &HeightMap), level: usize, (node, lane): (usize, usize)) {
        let bounds = &sound.0.levels[level].bounds;
        let [max, min] = match bounds.node(node) {
            NodeBounds::Wide { max, min } => [max[lane], min[lane]],
            NodeBounds::Tiny { max, min, .. } => [max[lane], min[lane]].map(u16::from),
        };
        let most = if bounds.layout() == Layout::Tiny { 255 } else { 65535 };
        if max > 0 {
            let why = found(sound, level, |bounds| match bounds {
                LevelBounds::Wide { max, .. } => max[node][lane] -= 1,
                LevelBounds::Tiny { max, .. } => max[node][lane] -= 1,
            });
            assert!(matches!(why, PyramidViolation::Maximum { .. }), "{why}");
        }
        if min < most {
            let why = found(sound, level, |bounds| match bounds {
                LevelBounds::Wide { min, .. } => min[node][lane] += 1,
                LevelBounds::Tiny { min, .. } => min[node][lane] += 1,
            });
            assert!(matches!(why, PyramidViolation::Minimum { .. }), "{why}");
        }
    }

    fn check_range(sound: (&Pyramid, &HeightMap), level: usize, node: usize) {
        let bounds = &sound.0.levels[level].bounds;
        let [lo, hi] = bounds.range(node);
        if bounds.layout() == Layout::Tiny && lo < hi {
            for inward in [[lo + 1, hi], [lo, hi - 1]] {
                found(sound, level, |bounds| {
                    if let LevelBounds::Tiny { range, .. } = bounds {
                        range[node] = inward;
                    }
                });
            }
        }
    }
}

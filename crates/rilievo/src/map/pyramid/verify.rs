//! [`Pyramid::verify`]: whether stored bounds, from a file say, enclose the surface.

use super::{LANES, Level, Pyramid};
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
        stored: u16,
        /// The smallest safe code.
        needed: u16,
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
        stored: u16,
        /// The largest safe code.
        needed: u16,
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
        let fits = |a: &Level, b: &Level| {
            a.nodes == b.nodes && a.max.len() == b.max.len() && a.min.len() == b.min.len()
        };
        if self.cells != sound.cells
            || self.code != sound.code
            || self.levels.len() != sound.levels.len()
            || !self.levels.iter().zip(&sound.levels).all(|(a, b)| fits(a, b))
        {
            return Err(PyramidViolation::Shape);
        }
        for (level, (have, want)) in (0..).zip(self.levels.iter().zip(&sound.levels)) {
            verify_level(level, have, want)?;
        }
        Ok(())
    }
}

/// Compares the bounds of a level with the tight ones.
fn verify_level(level: u32, have: &Level, want: &Level) -> Result<(), PyramidViolation> {
    for at in 0..have.max.len() * LANES {
        let (index, k) = (at / LANES, at % LANES);
        let (node, lane) = (index as u32, k as u32);
        let (stored, needed) = (have.max[index][k], want.max[index][k]);
        if stored < needed {
            return Err(PyramidViolation::Maximum { level, node, lane, stored, needed });
        }
        let (stored, needed) = (have.min[index][k], want.min[index][k]);
        if stored > needed {
            return Err(PyramidViolation::Minimum { level, node, lane, stored, needed });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::tests::maps;
    use super::*;

    #[test]
    fn every_bound_moved_inward_by_one_step_is_caught() {
        for map in maps() {
            let sound = Pyramid::build(&map);
            for level in 0..sound.levels.len() {
                for node in 0..sound.levels[level].max.len() {
                    for lane in 0..LANES {
                        let mut cut = sound.clone();
                        let max = &mut cut.levels[level].max[node][lane];
                        if *max > 0 {
                            *max -= 1;
                            assert!(matches!(
                                cut.verify(&map),
                                Err(PyramidViolation::Maximum { .. })
                            ));
                        }
                        let mut cut = sound.clone();
                        let min = &mut cut.levels[level].min[node][lane];
                        if *min < u16::MAX {
                            *min += 1;
                            assert!(matches!(
                                cut.verify(&map),
                                Err(PyramidViolation::Minimum { .. })
                            ));
                        }
                    }
                }
            }
        }
    }
}

//! [`BoxSteps`]: what another backend needs to make a map of kind `boxes`, code for code, as the CPU does.
//!
//! Squared distances are whole numbers of steps (see `boxes`), so that any machine finds the same minimum. Two
//! things are made in `f64`: a vertical gap in steps, which is three products and a difference that a backend has to
//! round as `f64` does, and the code of a distance. That never falls as steps rise, so it is told by the least number of steps
//! of each code.

use super::boxes::Boxes;
use super::codes::{Quantiser, quantum};
use super::columns::Columns;
use super::domain::Domain;
use super::{DistanceKind, DistanceMapError, DistanceOptions};
use crate::map::HeightMap;

/// No squared distance has more steps.
const MOST: u64 = 1 << 52;

/// How a map of kind [`DistanceKind::Boxes`] counts.
#[derive(Clone, Debug, PartialEq)]
pub struct BoxSteps {
    /// Raw heights where slabs begin, and where the last one ends.
    pub slabs: Vec<f64>,
    /// Scene units of one raw unit of height.
    pub height: f64,
    /// Steps of one squared scene unit.
    pub per_unit: f64,
    /// Steps across one voxel along x and y.
    pub weights: [u64; 2],
    /// The fewest steps that get code 1, 2 and so on; past all steps for codes that none gets.
    pub least: Vec<u64>,
    /// Scene units of one code step.
    pub quantum: f64,
}

impl BoxSteps {
    /// How the distance map of `heights` with these options counts.
    ///
    /// # Errors
    /// As [`DistanceMap::from_height`](super::DistanceMap::from_height).
    pub fn new(heights: &HeightMap, options: &DistanceOptions) -> Result<Self, DistanceMapError> {
        let DistanceOptions { size, metric, bits } = *options;
        DistanceKind::Boxes.check_size(size)?;
        let domain = Domain::of(heights, metric)?;
        let boxes = Boxes::over(&domain, size, Columns::default());
        let quantum = quantum(&domain, bits);
        let quantiser = Quantiser::new(&domain, quantum, bits);
        let code = |steps: u64| quantiser.code(boxes.distance(steps as f64));
        let least = (1..=bits.max_code()).map(|wanted| {
            let near = boxes.steps(quantiser.clear_distance(wanted)).min(MOST as f64) as u64;
            first_from(near, |steps| code(steps) >= wanted)
        });
        Ok(Self {
            slabs: (0..=size[2]).map(|k| domain.division(2, k, size[2])).collect(),
            height: metric.z,
            per_unit: boxes.per_unit,
            weights: boxes.weights.map(|weight| weight as u64),
            least: least.collect(),
            quantum,
        })
    }
}

/// The least number up to [`MOST`] that passes, if all that follow pass too; the search begins at `near`. One past
/// [`MOST`] if none does.
fn first_from(near: u64, passes: impl Fn(u64) -> bool) -> u64 {
    let (mut low, mut high) = (near, near);
    let mut stride = 16;
    while passes(low) {
        if low == 0 {
            return 0;
        }
        (low, high) = (low.saturating_sub(stride), low);
        stride *= 4;
    }
    while !passes(high) {
        if high > MOST {
            return high;
        }
        (low, high) = (high, (high + stride).min(MOST + 1));
        stride *= 4;
        if high > MOST {
            break;
        }
    }
    while low + 1 < high {
        let middle = low + (high - low) / 2;
        if passes(middle) { high = middle } else { low = middle }
    }
    high
}

#[cfg(test)]
mod tests {
    use super::super::fixtures::cases;
    use super::*;
    use crate::map::{DistanceBits, DistanceMap};

    #[test]
    fn whole_numbers_make_the_codes() {
        let bits = [DistanceBits::U16, DistanceBits::U8];
        for ((map, metric), bits) in cases().into_iter().zip(bits.into_iter().cycle()) {
            for size in [[3, 4, 5], [17, 13, 4]] {
                let options = DistanceOptions { size, metric, bits };
                let steps = BoxSteps::new(&map, &options).unwrap();
                let stored = DistanceMap::from_height(&map, DistanceKind::Boxes, &options).unwrap();
                assert_eq!(steps.quantum, stored.quantum());
                let domain = Domain::of(&map, metric).unwrap();
                let boxes = Boxes::new(&map, &domain, size);
                for at in 0..(size[0] * size[1] * size[2]) as usize {
                    let [x, y] = [size[0], size[1]].map(|n| n as usize);
                    let slab = (steps.slabs[at / x / y], steps.slabs[at / x / y + 1]);
                    let across = |a: usize, b: usize, axis: usize| {
                        (a.abs_diff(b).saturating_sub(1) as u64).pow(2) * steps.weights[axis]
                    };
                    let columns = boxes.columns.bounds().iter().enumerate();
                    let all = columns.map(|(c, &column)| {
                        across(c % x, at % x, 0)
                            + across(c / x, at / x % y, 1)
                            + boxes.vertical(slab, column) as u64
                    });
                    let found = all.min().unwrap();
                    let code = steps.least.partition_point(|&least| least <= found);
                    assert_eq!(code as u32, stored.codes().get(at), "{size:?} {at}");
                }
            }
        }
    }

    #[test]
    fn the_first_number_is_found_from_anywhere() {
        for want in [0, 1, 77, 5_000, MOST - 3, MOST] {
            for near in [0, 70, 100_000, MOST] {
                assert_eq!(first_from(near, |x| x >= want), want, "{near}");
            }
        }
        assert_eq!(first_from(9, |_| false), MOST + 1);
    }
}

//! [`NodeSearch`]: what another backend needs to make a map of a kind with nodes, code for code, as the CPU does.
//!
//! The code of a node follows from a distance that the CPU finds to within [`NodeSearch::error`] scene units. So a backend
//! that encloses the distance, less and plus that error, between two with one code knows the code, whatever it computes with; for the
//! few nodes that it cannot tell it asks for [`NodeSearch::codes`].

use rayon::prelude::*;

use super::codes::{Quantiser, quantum};
use super::corrected::Nodes;
use super::domain::Domain;
use super::published::Texels;
use super::{DistanceKind, DistanceMapError, DistanceOptions};
use crate::map::{HeightMap, Metric, Pyramid};

/// The nodes of a distance map of kind [`DistanceKind::Corrected`] or [`DistanceKind::Published`], and how they are
/// coded. For [`DistanceKind::Boxes`] see [`BoxSteps`](super::BoxSteps).
#[derive(Debug)]
pub struct NodeSearch<'a> {
    heights: &'a HeightMap,
    pyramid: &'a Pyramid,
    kind: DistanceKind,
    domain: Domain,
    size: [u32; 3],
    quantiser: Quantiser,
    /// Scene units of one code step.
    pub quantum: f64,
    /// What is taken off a distance before it is coded, scene units.
    pub margin: f64,
    /// How far the distance that the CPU codes may be from the true one, scene units.
    pub error: f64,
    /// Sum of the sizes of all numbers a distance is computed from, scene units.
    pub scale: f64,
    /// The depth of the domain: no distance of a node is larger. Scene units.
    pub depth: f64,
}

impl<'a> NodeSearch<'a> {
    /// The nodes of the distance map of `heights` with these options; `pyramid` is that of `heights`.
    ///
    /// # Errors
    /// As [`DistanceMap::from_height`](super::DistanceMap::from_height).
    pub fn new(
        heights: &'a HeightMap,
        pyramid: &'a Pyramid,
        kind: DistanceKind,
        options: &DistanceOptions,
    ) -> Result<Self, DistanceMapError> {
        let DistanceOptions { size, metric, bits } = *options;
        kind.check_size(size)?;
        let domain = Domain::of(heights, metric)?;
        let quantum = quantum(&domain, bits);
        let margin = domain.margin();
        Ok(Self {
            heights,
            pyramid,
            kind,
            domain,
            size,
            quantiser: Quantiser::new(&domain, quantum, bits),
            quantum,
            margin,
            // A quarter is what a search leaves open; what is rounded lies far below.
            error: if kind == DistanceKind::Corrected { 0.26 } else { 0.02 } * margin,
            scale: domain.scale(),
            depth: domain.depth(),
        })
    }

    /// Where nodes lie along an axis: stored cells, or raw heights.
    pub fn places(&self, axis: usize) -> Vec<f64> {
        let last = self.size[axis] - 1;
        (0..=last).map(|i| self.domain.division(axis, i, last)).collect()
    }

    /// The kind of the map.
    pub fn kind(&self) -> DistanceKind {
        self.kind
    }

    /// The metric of distances.
    pub fn metric(&self) -> Metric {
        self.domain.metric
    }

    /// The codes of some nodes, as the CPU finds them; a node is its place in the order of the codes.
    pub fn codes(&self, nodes: &[usize]) -> Vec<u32> {
        let [nx, ny, _] = self.size.map(|n| n as usize);
        let place = |at: usize| [at % nx, at / nx % ny, at / nx / ny].map(|i| i as u32);
        let Self { heights, pyramid, domain, size, quantiser, .. } = self;
        if self.kind == DistanceKind::Published {
            let texels = Texels::new(heights, domain);
            let code = |&at: &usize| {
                let node = place(at);
                let p = std::array::from_fn(|a| domain.division(a, node[a], size[a] - 1));
                quantiser.code(texels.distance(p))
            };
            return nodes.par_iter().map(code).collect();
        }
        let nodes_of = Nodes { heights, pyramid, domain, size: *size, quantiser: *quantiser };
        let mut codes = vec![0; nodes.len()];
        nodes.par_iter().zip(&mut codes).for_each_init(
            || nodes_of.search(),
            |search, (&at, code)| {
                search.forget();
                *code = nodes_of.code(place(at), search);
            },
        );
        codes
    }
}

#[cfg(test)]
mod tests {
    use super::super::fixtures::cases;
    use super::*;
    use crate::map::{DistanceBits, DistanceMap};

    #[test]
    fn codes_of_any_nodes_are_those_of_the_map() {
        for (map, metric) in cases() {
            let pyramid = Pyramid::build(&map);
            for kind in [DistanceKind::Corrected, DistanceKind::Published] {
                let options = DistanceOptions { size: [5, 4, 6], metric, bits: DistanceBits::U16 };
                let stored = DistanceMap::from_height(&map, kind, &options).unwrap();
                let search = NodeSearch::new(&map, &pyramid, kind, &options).unwrap();
                assert_eq!(search.quantum, stored.quantum());
                let nodes: Vec<usize> = (0..120).filter(|at| at % 7 != 3).rev().collect();
                let want: Vec<u32> = nodes.iter().map(|&at| stored.codes().get(at)).collect();
                assert_eq!(search.codes(&nodes), want);
            }
        }
    }
}

//! [`PixelTable`]: the points of one pixel, kept while its paths go by.
//!
//! The strata of a dimension are the same for all paths of a pixel, and finding a point in them
//! costs more than what is done with it. So the first path that asks for a dimension has the points
//! of all made, in loops that a compiler turns into vectors; the numbers are those of
//! [`Strata::point`].

use glam::DVec2;

use super::{Dimension, Sampler, Strand, Strata};

/// Points of a dimension that are made at once; more are made one by one.
const MOST_POINTS: u64 = 64;

/// Dimensions that are kept; those of later bounces are made anew each time.
const MOST_SLOTS: usize = 48;

/// The points of one pixel after the other.
pub(crate) struct PixelTable {
    sampler: Sampler,
    lights: usize,
    slots: Vec<Slot>,
}

/// What is kept of a dimension.
#[derive(Clone)]
struct Slot {
    /// The strata in use; none before the pixel's first path comes by.
    strata: Option<(u64, Strata)>,
    /// All points, if they are few.
    points: Vec<DVec2>,
}

impl PixelTable {
    /// A table for scenes of so many lights.
    pub(crate) fn new(lights: usize) -> Self {
        Self { sampler: Sampler::new(0, [0; 2]), lights, slots: Vec::new() }
    }

    /// Goes on to another pixel.
    pub(crate) fn start(&mut self, sampler: Sampler) {
        self.sampler = sampler;
        for slot in &mut self.slots {
            slot.strata = None;
        }
    }

    /// The point of a path in a dimension, in `[0, 1)^2`.
    #[inline]
    pub(crate) fn point(&mut self, dimension: Dimension, strand: Strand) -> DVec2 {
        let Strand { index, count } = strand;
        let at = self.slot_of(dimension);
        let Some(slot) = self.slots.get_mut(at) else { return self.rare(at, dimension, strand) };
        match &slot.strata {
            Some((of, strata)) if *of == count => match slot.points.get(index as usize) {
                Some(point) => *point,
                None => strata.point(index),
            },
            _ => slot.fill(self.sampler.strata(dimension, count), count, index),
        }
    }

    /// [`PixelTable::point`] where there is no slot yet, or never will be.
    #[cold]
    fn rare(&mut self, at: usize, dimension: Dimension, strand: Strand) -> DVec2 {
        if at >= MOST_SLOTS {
            return self.sampler.strata(dimension, strand.count).point(strand.index);
        }
        self.slots.resize(at + 1, Slot { strata: None, points: Vec::new() });
        self.point(dimension, strand)
    }

    fn slot_of(&self, dimension: Dimension) -> usize {
        let at = |depth: u32, place: usize| 4 + depth as usize * (self.lights + 2) + place;
        match dimension {
            Dimension::Pixel => 0,
            Dimension::Lens => 1,
            Dimension::Time => 2,
            Dimension::Level => 3,
            Dimension::Bounce { depth } => at(depth, 0),
            Dimension::Gloss { depth } => at(depth, 1),
            Dimension::Light { depth, light } => at(depth, 2 + light as usize),
        }
    }
}

impl Slot {
    /// Takes in the strata of a dimension and says one of their points.
    #[inline(never)]
    fn fill(&mut self, strata: Strata, count: u64, index: u64) -> DVec2 {
        self.points.clear();
        if count <= MOST_POINTS {
            strata.extend(count, &mut self.points);
        }
        self.strata = Some((count, strata));
        self.points.get(index as usize).copied().unwrap_or_else(|| strata.point(index))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn says_what_the_sampler_says() {
        let dimensions = [
            Dimension::Pixel,
            Dimension::Light { depth: 0, light: 1 },
            Dimension::Light { depth: 1, light: 0 },
            Dimension::Gloss { depth: 3 },
            Dimension::Bounce { depth: 3 },
            Dimension::Bounce { depth: 200 },
        ];
        let mut table = PixelTable::new(2);
        for pixel in [[0, 0], [5, 7], [6, 7]] {
            let sampler = Sampler::new(3, pixel);
            table.start(sampler);
            // Counts with empty cells, counts that change on the way, and one too large to keep.
            for count in [16, 1, 16, 7, 13, 64, 100] {
                for index in 0..count {
                    for dimension in dimensions {
                        let point = table.point(dimension, Strand { index, count });
                        assert_eq!(point, sampler.strata(dimension, count).point(index));
                    }
                }
            }
        }
    }
}

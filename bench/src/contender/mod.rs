//! [`Contender`]: who is measured, and [`Built`]: one of them, ready to trace.
//!
//! Everything the commands know of a contender is here; what differs between them is in the files
//! beside.

#[cfg(feature = "embree")]
mod embree;
mod rilievo;

use std::collections::BTreeMap;

use ::rilievo::SimdLevel;
use ::rilievo::map::{HeightMap, Layout};
use clap::ValueEnum;

use crate::clock::Took;
use crate::rays::Batch;
use crate::tally::Tally;

/// A contender by its name on the command line and in records.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Contender {
    /// rilievo on the default layout of its pyramid.
    RilievoDefault,
    /// rilievo on the layout tiny.
    RilievoTiny,
    /// Embree, two triangles a cell.
    EmbreeTri,
    /// Embree, a quad a cell.
    EmbreeQuad,
    /// Embree, one GRID in a compact scene.
    EmbreeGrid,
}

/// What a contender needs to be built and traced.
pub struct Task<'a> {
    pub heights: &'a HeightMap,
    /// Scene units of height 1.
    pub depth: f64,
    /// The level of rilievo's kernel.
    pub simd: SimdLevel,
    /// Embree's configuration string.
    #[cfg(feature = "embree")]
    pub embree_config: &'a str,
}

/// Facts about a contender that its figures depend on.
pub type Facts = BTreeMap<&'static str, String>;

/// A contender that is ready to trace.
pub struct Built {
    pub contender: Contender,
    /// From the heights to the first ray.
    pub took: Took,
    /// Bytes held beyond the heights; now, and at most while it was built.
    pub bytes: (u64, u64),
    pub facts: Facts,
    tracer: Tracer,
}

enum Tracer {
    Rilievo(Box<rilievo::Tracer>),
    #[cfg(feature = "embree")]
    Embree(Box<embree::Tracer>),
}

/// A batch in a contender's own format, made before the clock starts.
pub enum Loaded<'a> {
    Rilievo(rilievo::Loaded<'a>),
    #[cfg(feature = "embree")]
    Embree(embree::Loaded<'a>),
}

impl Contender {
    /// In the order in which they are built: the small ones first.
    pub const ALL: [Self; 5] = [
        Self::RilievoDefault,
        Self::RilievoTiny,
        Self::EmbreeGrid,
        Self::EmbreeQuad,
        Self::EmbreeTri,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Self::RilievoDefault => "rilievo-default",
            Self::RilievoTiny => "rilievo-tiny",
            Self::EmbreeTri => "embree-tri",
            Self::EmbreeQuad => "embree-quad",
            Self::EmbreeGrid => "embree-grid",
        }
    }

    /// The layout of the pyramid; none for peers.
    pub fn layout(self) -> Option<Layout> {
        match self {
            Self::RilievoDefault => Some(Layout::Default),
            Self::RilievoTiny => Some(Layout::Tiny),
            Self::EmbreeTri | Self::EmbreeQuad | Self::EmbreeGrid => None,
        }
    }

    /// Whether it is part of this build.
    pub fn is_compiled(self) -> bool {
        self.layout().is_some() || cfg!(feature = "embree")
    }

    /// Most bytes it will hold at once on a map of `cells` cells: beyond the heights, and for rilievo
    /// beyond one more copy of them.
    pub fn peak_bytes(self, cells: u64) -> u64 {
        match self.layout() {
            Some(_) => 3 * cells,
            #[cfg(feature = "embree")]
            None => embree::peak_bytes(self, cells),
            #[cfg(not(feature = "embree"))]
            None => 0,
        }
    }

    /// Builds it, on one thread.
    ///
    /// # Errors
    /// When the contender refuses, or is not compiled in.
    pub fn build(self, task: &Task<'_>) -> Result<Built, String> {
        match self.layout() {
            Some(layout) => rilievo::build((self, layout), task),
            #[cfg(feature = "embree")]
            None => embree::build(self, task),
            #[cfg(not(feature = "embree"))]
            None => Err(format!("{} needs the feature embree", self.name())),
        }
    }
}

impl Built {
    /// The numbers of rays a call that are measured on a batch; the first is the plainest.
    pub fn widths(&self, batch: &Batch) -> Vec<usize> {
        match &self.tracer {
            Tracer::Rilievo(_) => rilievo::widths(batch),
            #[cfg(feature = "embree")]
            Tracer::Embree(_) => embree::widths(batch),
        }
    }

    /// The batch in the contender's own format, to be traced `width` rays a call, one of
    /// [`Built::widths`].
    pub fn load(&self, batch: &Batch, width: usize) -> Loaded<'_> {
        match &self.tracer {
            Tracer::Rilievo(tracer) => Loaded::Rilievo(tracer.load(batch, width)),
            #[cfg(feature = "embree")]
            Tracer::Embree(tracer) => Loaded::Embree(tracer.load(batch, width)),
        }
    }
}

impl Loaded<'_> {
    /// Traces the batch once.
    pub fn trace(&self) -> Tally {
        match self {
            Self::Rilievo(loaded) => loaded.trace(),
            #[cfg(feature = "embree")]
            Self::Embree(loaded) => loaded.trace(),
        }
    }

    /// How the contender is called.
    pub fn call(&self) -> &'static str {
        match self {
            Self::Rilievo(loaded) => loaded.call(),
            #[cfg(feature = "embree")]
            Self::Embree(loaded) => loaded.call(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ::rilievo::relief::Relief;

    use crate::map::MapName;
    use crate::rays::{Row, Scene};

    fn task(heights: &HeightMap, depth: f64) -> Task<'_> {
        Task {
            heights,
            depth,
            simd: SimdLevel::detect(),
            #[cfg(feature = "embree")]
            embree_config: "threads=1",
        }
    }

    #[test]
    fn contenders_agree_on_what_is_hit() {
        let heights = MapName::Gaussian.load(257).unwrap();
        let task = task(&heights, 0.8);
        let scene = Scene::new(Relief::new(heights.clone()), 0.8, 48).unwrap();
        let compiled = || Contender::ALL.into_iter().filter(|c| c.is_compiled());
        let built: Vec<Built> = compiled().map(|c| c.build(&task).unwrap()).collect();
        for row in Row::ALL {
            let batch = scene.batch(row);
            let mut first: Option<Tally> = None;
            for contender in &built {
                for width in contender.widths(&batch) {
                    let tally = contender.load(&batch, width).trace();
                    let first = *first.get_or_insert(tally);
                    // The surfaces differ inside of cells, and rays that graze the border too.
                    let most = 3 + batch.rays.len() as u64 / 200;
                    let name = contender.contender.name();
                    assert!(
                        tally.hits.abs_diff(first.hits) <= most,
                        "{name} {row:?} {width}: {tally:?} {first:?}"
                    );
                    let mean = |t: Tally| t.mean_t().unwrap_or(0.0);
                    assert!((mean(tally) - mean(first)).abs() < 1e-2, "{name} {row:?} {width}");
                }
            }
            assert!(first.is_some_and(|tally| tally.hits > 0), "{row:?}");
        }
    }

    #[test]
    fn memory_is_counted() {
        let heights = MapName::Gaussian.load(257).unwrap();
        let task = task(&heights, 0.1);
        for contender in Contender::ALL.into_iter().filter(|c| c.is_compiled()) {
            let built = contender.build(&task).unwrap();
            let (held, peak) = built.bytes;
            assert!(held > 0 && held <= peak, "{}: {held} {peak}", contender.name());
            // The forecast is for large maps; small ones carry fixed costs.
            assert!(peak <= contender.peak_bytes(256 * 256) + (8 << 20), "{}", contender.name());
        }
    }
}

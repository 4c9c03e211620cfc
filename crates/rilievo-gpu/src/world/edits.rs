//! Edits of maps that lie on a GPU: what they touch is brought over and made anew, nothing else.

use std::ops::Range;

use rilievo::relief::Relief;
use rilievo::surface::World;

use super::{GpuWorld, anchor_of};
use crate::device::Gpu;
use crate::error::GpuError;
use crate::maps::Maps;
use crate::upload::Upload;

/// Heights and bounds on a GPU, of the maps of a world.
pub struct GpuMaps(pub(super) Maps);

/// An edit of a map that a [`GpuWorld`] holds.
#[derive(Clone, Debug)]
pub struct MapEdit<'a> {
    /// The relief after the edit.
    pub relief: &'a Relief,
    /// Columns and rows of the samples that may have changed.
    pub samples: [Range<u32>; 2],
}

impl<'a> GpuWorld<'a> {
    /// The maps alone, for a world after edits of them: they hold nothing of this one.
    pub fn into_maps(self) -> GpuMaps {
        GpuMaps(self.maps)
    }

    /// The surfaces of a world whose maps differ from `maps`, which lie on this GPU, in what `edits` name alone: only
    /// that is brought over and made anew. All other surfaces may differ. If there are other maps, or maps of another
    /// size, everything is brought over.
    ///
    /// # Errors
    /// As [`GpuWorld::new`].
    pub fn edited(
        gpu: &'a Gpu,
        world: &'a World,
        GpuMaps(mut maps): GpuMaps,
        edits: &[MapEdit<'_>],
    ) -> Result<Self, GpuError> {
        let anchor = anchor_of(world);
        let words = Upload::new(world, anchor)?;
        if !maps.fits(&words.maps) {
            return Self::new(gpu, world);
        }
        let number = |edit: &MapEdit<'_>| {
            words.maps.number(edit.relief).map(|number| (number, edit.samples.clone()))
        };
        let edits: Vec<_> = edits.iter().filter_map(number).collect();
        maps.edit(gpu, &words.maps, &edits)?;
        Self::assemble(gpu, (world, anchor), &words, maps)
    }
}

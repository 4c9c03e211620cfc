//! [`Tiled`]: an image and all its coarser ones, cut into tiles that lie in a [`TileCache`]'s source.
//!
//! Level by level, from the finest; in each the tiles row by row, in each the texels row by row. Tiles at
//! the upper borders are as small as what is left, so nothing is filled up.

use std::sync::Arc;

use super::cache::{HeldTile, SIDE, Tile, TileCache};
use super::coarser::coarser;
use super::texels::{Coding, Decoder, Level};
use crate::colour::Rgb;

/// An image in tiles.
#[derive(Clone, Debug)]
pub(super) struct Tiled {
    cache: Arc<TileCache>,
    coding: Coding,
    /// From the finest.
    levels: Vec<TiledLevel>,
}

/// One of the images.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct TiledLevel {
    size: [u32; 2],
    /// Its place in the source.
    first: u64,
}

/// Two are the same if they lie in the same place.
impl PartialEq for Tiled {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.cache, &other.cache)
            && (self.coding, &self.levels) == (other.coding, &other.levels)
    }
}

impl Tiled {
    /// Cuts an image and all its coarser ones. Tiles go to `write`, in their order in the source from
    /// `first` on.
    pub fn write<E>(
        finest: &Level,
        decoder: &Decoder,
        (cache, first): (&Arc<TileCache>, u64),
        write: &mut dyn FnMut(&[u8]) -> Result<(), E>,
    ) -> Result<Self, E> {
        let coding = finest.texels.coding();
        let mut tiled = Self { cache: Arc::clone(cache), coding, levels: Vec::new() };
        let (mut made, mut end): (Option<Level>, u64) = (None, first);
        loop {
            let level = made.as_ref().unwrap_or(finest);
            let size = [level.width, level.height];
            tiled.levels.push(TiledLevel { size, first: end });
            let mut bytes = Vec::new();
            for (row, column) in tile_places(size) {
                let [width, height] = tile_size(size, [column, row]);
                bytes.clear();
                for j in 0..height {
                    let from = (row * SIDE + j) as usize * size[0] as usize;
                    let from = from + (column * SIDE) as usize;
                    level.texels.put(from..from + width as usize, &mut bytes);
                }
                end += bytes.len() as u64;
                write(&bytes)?;
            }
            if size == [1, 1] {
                return Ok(tiled);
            }
            made = Some(coarser(level, decoder));
        }
    }

    pub fn cache(&self) -> &Arc<TileCache> {
        &self.cache
    }

    /// Texels along u and v at a depth.
    #[inline]
    pub fn size(&self, depth: usize) -> [u32; 2] {
        self.levels[depth].size
    }

    /// How many coarser images there are.
    pub fn coarser(&self) -> usize {
        self.levels.len() - 1
    }

    /// Bytes a texel.
    pub fn texel_bytes(&self) -> u64 {
        self.coding.bytes()
    }

    /// Reads texels of one depth.
    #[inline]
    pub fn reader<'a>(&'a self, depth: usize, decoder: &'a Decoder) -> Reader<'a> {
        Reader { tiled: self, level: &self.levels[depth], decoder, last: None }
    }

    fn tile(&self, level: &TiledLevel, place: [u32; 2]) -> Tile {
        let size = tile_size(level.size, place);
        let [column, row] = place.map(|at| u64::from(at * SIDE));
        // Whole rows of tiles before, then tiles as high as this one.
        let texels = row * u64::from(level.size[0]) + column * u64::from(size[1]);
        Tile { offset: level.first + texels * self.coding.bytes(), size, coding: self.coding }
    }
}

/// Reads texels of one image; keeps the tile that it was last in.
pub(super) struct Reader<'a> {
    tiled: &'a Tiled,
    level: &'a TiledLevel,
    decoder: &'a Decoder,
    last: Option<([u32; 2], Arc<HeldTile>)>,
}

impl Reader<'_> {
    /// The linear colour of a texel of the image.
    #[inline]
    pub fn texel(&mut self, i: u32, j: u32) -> Rgb {
        let place = [i / SIDE, j / SIDE];
        let (_, tile) = match self.last.take() {
            Some(last) if last.0 == place => self.last.insert(last),
            _ => {
                let tile = self.tiled.cache.tile(&self.tiled.tile(self.level, place));
                self.last.insert((place, tile))
            }
        };
        self.decoder.texel(&tile.level, i % SIDE, j % SIDE)
    }
}

/// Tiles of an image, as rows and columns, in order.
fn tile_places([width, height]: [u32; 2]) -> impl Iterator<Item = (u32, u32)> {
    let columns = width.div_ceil(SIDE);
    (0..height.div_ceil(SIDE)).flat_map(move |row| (0..columns).map(move |column| (row, column)))
}

/// Texels of a tile along u and v.
fn tile_size(size: [u32; 2], place: [u32; 2]) -> [u32; 2] {
    [0, 1].map(|axis| (size[axis] - place[axis] * SIDE).min(SIDE))
}

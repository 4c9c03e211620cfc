//! [`TileCache`]: tiles of images, those in memory that were looked at last.
//!
//! Tiles lie in a [`TileSource`], a file as a rule, and are told apart by their place in it. The cache is cut into shards, each with a lock and a
//! part of the capacity of its own, so that threads seldom wait for each other; nothing is read under a
//! lock. Where a shard is full the quarter of its tiles goes that was not looked at for longest.
//!
//! Tiles hold the bits that were written, so no picture depends on the capacity or on who reads what
//! when. Memory held is at most the capacity and [`TileCache::SLACK`] a thread.
//!
//! A tile that cannot be read is black, and [`TileCache::failure`] tells: who renders asks for it after each of their own tiles, and
//! throws away what they have.

use std::collections::HashMap;
use std::fmt;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use super::texels::{Coding, Level};

/// Texels along a side of a tile.
pub(super) const SIDE: u32 = 64;

/// Bytes of the largest tile.
const LARGEST: u64 = 12 * (SIDE * SIDE) as u64;

/// Most shards.
const SHARDS: u64 = 64;

/// Largest tiles that a shard has room for, at least, where there are several shards.
const ROOM: u64 = 16;

/// Where tiles are read from.
pub trait TileSource: fmt::Debug + Send + Sync {
    /// Fills `bytes` with those that begin at `offset`.
    ///
    /// # Errors
    /// Why that cannot be, in words.
    fn read(&self, offset: u64, bytes: &mut [u8]) -> Result<(), String>;
}

/// A part of an image: at most [`SIDE`] texels along an axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tile {
    /// Its place in the source.
    pub offset: u64,
    pub size: [u32; 2],
    pub coding: Coding,
}

/// A tile in memory.
#[derive(Debug)]
pub(super) struct HeldTile {
    pub level: Level,
    bytes: u64,
    /// All that are held.
    held: Arc<AtomicU64>,
}

impl Drop for HeldTile {
    fn drop(&mut self) {
        self.held.fetch_sub(self.bytes, Ordering::Relaxed);
    }
}

/// Brings in the tiles of images, and keeps those in memory that were looked at last.
#[derive(Debug)]
pub struct TileCache {
    source: Box<dyn TileSource>,
    shards: Vec<Mutex<Shard>>,
    capacity: u64,
    held: Arc<AtomicU64>,
    failure: OnceLock<String>,
}

/// Tiles that share a lock.
#[derive(Debug, Default)]
struct Shard {
    /// By offset, with when each was last looked at.
    tiles: HashMap<u64, (Arc<HeldTile>, u64)>,
    bytes: u64,
    clock: u64,
}

impl TileCache {
    /// Bytes that a thread may hold beyond the capacity: the tile it looks at, the next one as it is
    /// read and as texels.
    pub const SLACK: u64 = 3 * LARGEST;

    /// A cache of so many bytes.
    pub fn new(source: Box<dyn TileSource>, capacity: u64) -> Self {
        let shards = (capacity / (ROOM * LARGEST)).clamp(1, SHARDS);
        let shards = (0..shards).map(|_| Mutex::default()).collect();
        Self { source, shards, capacity, held: Arc::default(), failure: OnceLock::new() }
    }

    /// Bytes of the tiles that it may keep.
    pub fn capacity(&self) -> u64 {
        self.capacity
    }

    /// Bytes of all tiles in memory, kept or in use.
    pub fn held(&self) -> u64 {
        self.held.load(Ordering::Relaxed)
    }

    /// Why a tile could not be read, if one could not.
    pub fn failure(&self) -> Option<&str> {
        self.failure.get().map(String::as_str)
    }

    /// A tile: black if it cannot be read.
    pub(super) fn tile(&self, tile: &Tile) -> Arc<HeldTile> {
        // Hashed, so that neighbours are in different shards.
        let place = tile.offset.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32;
        let shard = &self.shards[(place % self.shards.len() as u64) as usize];
        if let Some(held) = lock(shard).find(tile.offset) {
            return held;
        }
        let bytes = tile.coding.bytes() * u64::from(tile.size[0]) * u64::from(tile.size[1]);
        let mut read = vec![0; bytes as usize];
        let found = self.source.read(tile.offset, &mut read);
        let [width, height] = tile.size;
        self.held.fetch_add(bytes, Ordering::Relaxed);
        let held = |read: &[u8]| {
            let level = Level { width, height, texels: tile.coding.texels(read) };
            Arc::new(HeldTile { level, bytes, held: Arc::clone(&self.held) })
        };
        if let Err(reason) = found {
            // The first one stays.
            let _ = self.failure.set(reason);
            read.fill(0);
            return held(&read);
        }
        let held = held(&read);
        lock(shard).keep(tile.offset, held, self.capacity / self.shards.len() as u64)
    }
}

impl Shard {
    fn find(&mut self, offset: u64) -> Option<Arc<HeldTile>> {
        self.clock += 1;
        let (tile, seen) = self.tiles.get_mut(&offset)?;
        *seen = self.clock;
        Some(Arc::clone(tile))
    }

    /// Keeps a tile if it finds room within `most` bytes; another one of the same place that came
    /// first counts.
    fn keep(&mut self, offset: u64, tile: Arc<HeldTile>, most: u64) -> Arc<HeldTile> {
        if let Some(there) = self.find(offset) {
            return there;
        }
        while self.bytes + tile.bytes > most && !self.tiles.is_empty() {
            self.forget();
        }
        if self.bytes + tile.bytes <= most {
            self.bytes += tile.bytes;
            self.tiles.insert(offset, (Arc::clone(&tile), self.clock));
        }
        tile
    }

    /// Drops the quarter, at least one, that was not looked at for longest.
    fn forget(&mut self) {
        let mut seen: Vec<u64> = self.tiles.values().map(|(_, seen)| *seen).collect();
        let quarter = (seen.len() - 1) / 4;
        let (_, &mut last, _) = seen.select_nth_unstable(quarter);
        let bytes = &mut self.bytes;
        self.tiles.retain(|_, (tile, seen)| {
            let stays = *seen > last;
            *bytes -= if stays { 0 } else { tile.bytes };
            stays
        });
    }
}

/// A shard is whole whenever its lock is let go.
fn lock(shard: &Mutex<Shard>) -> std::sync::MutexGuard<'_, Shard> {
    shard.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests;

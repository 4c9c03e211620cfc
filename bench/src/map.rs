//! [`MapName`]: the maps that are measured, at any size, in 16-bit codes for both sides.
//!
//! A map of size n has n x n samples on a vertex lattice, hence (n - 1)^2 cells. `fbm`, `gaussian`
//! and `studded` are rilievo's procedural maps. The two real ones are scanned tiles of
//! 1024 x 1024 samples from `scenes/maps`: at sizes below they are thinned out with bilinear
//! interpolation; above they are **repeated**, sample for sample, with the depth divided by the
//! repetitions, as a floor of many such tiles would be: a larger size is then not a smoother one.

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use rilievo::map::{HeightMap, Lattice, Procedural, Samples, Wrap};
use rilievo_io::Limits;
use rilievo_io::image::HeightOptions;

/// Samples a side of the real maps.
const TILE: u32 = 1024;

/// A map by its name on the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum MapName {
    /// Eight octaves of gradient noise: rough everywhere.
    Fbm,
    /// One smooth bump.
    Gaussian,
    /// 16 x 16 square studs with flanks one cell wide.
    Studded,
    /// Scanned moss, 16 bit (real).
    Moss,
    /// Scanned roofing tiles, 16 bit (real).
    RoofingTiles,
}

impl MapName {
    pub const ALL: [Self; 5] =
        [Self::Fbm, Self::Gaussian, Self::Studded, Self::Moss, Self::RoofingTiles];

    pub fn name(self) -> &'static str {
        match self {
            Self::Fbm => "fbm",
            Self::Gaussian => "gaussian",
            Self::Studded => "studded",
            Self::Moss => "moss",
            Self::RoofingTiles => "roofing-tiles",
        }
    }

    /// Depth of the relief at `size` if a single repetition has `depth`, both in scene units.
    pub fn depth(self, size: u32, depth: f64) -> f64 {
        match self.file() {
            Some(_) => depth / f64::from((size / TILE).max(1)),
            None => depth,
        }
    }

    /// The map with `size` x `size` samples.
    ///
    /// # Errors
    /// A size that no map has, or a file that cannot be read.
    pub fn load(self, size: u32) -> Result<HeightMap, String> {
        let procedural = match self {
            Self::Fbm => Procedural::Fbm { octaves: 8, seed: 1 },
            Self::Gaussian => Procedural::Gaussian,
            Self::Studded => Procedural::Studded { studs: [16, 16] },
            Self::Moss | Self::RoofingTiles => return self.read(size),
        };
        let map = procedural.height_map([size, size], Lattice::Vertex, Wrap::Repeat);
        map.map_err(|e| format!("map {}: {e}", self.name()))
    }

    /// The file of a real map, below the repository's root.
    fn file(self) -> Option<&'static str> {
        match self {
            Self::Moss => Some("scenes/maps/moss/Moss001_1K_Displacement.png"),
            Self::RoofingTiles => {
                Some("scenes/maps/roofing-tiles/RoofingTiles009_1K_Displacement.png")
            }
            Self::Fbm | Self::Gaussian | Self::Studded => None,
        }
    }

    fn read(self, size: u32) -> Result<HeightMap, String> {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        let path = root.join(self.file().unwrap_or_default());
        read(&path, size)
    }
}

/// A map from anywhere, as NAME=FILE on the command line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MapFile {
    pub name: String,
    pub path: PathBuf,
}

impl std::str::FromStr for MapFile {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, path) = text.split_once('=').ok_or("a map file is NAME=FILE")?;
        Ok(Self { name: name.to_owned(), path: path.into() })
    }
}

impl MapFile {
    /// The map with `size` x `size` samples: repeated above its own size, thinned out below.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn load(&self, size: u32) -> Result<HeightMap, String> {
        read(&self.path, size)
    }
}

fn read(path: &Path, size: u32) -> Result<HeightMap, String> {
    let tile = HeightOptions::default().read(path, &Limits::default());
    let tile = tile.map_err(|e| e.to_string())?;
    resampled(&tile, size).map_err(|e| format!("map {}: {e}", path.display()))
}

/// `tile` at `size` x `size` samples: repeated above its own size, thinned out below.
fn resampled(tile: &HeightMap, size: u32) -> Result<HeightMap, rilievo::map::HeightMapError> {
    let step = (f64::from(tile.width()) / f64::from(size)).max(1.0);
    let side = f64::from(tile.width());
    let code = |i: u32, j: u32| {
        // Texel centres: sample k of the tile lies at lattice coordinate k.
        let at = [i, j].map(|k| (f64::from(k) * step) % side);
        (tile.raw_at_lattice(at[0], at[1]) * tile.unit() * 65535.0).round() as u16
    };
    let codes = (0..size).flat_map(|j| (0..size).map(move |i| code(i, j))).collect();
    HeightMap::new(size, size, Samples::U16(codes), Lattice::Vertex, Wrap::Repeat)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_map_fills_its_range() {
        for name in MapName::ALL {
            let map = name.load(300).unwrap();
            assert_eq!((map.width(), map.height()), (300, 300));
            let (low, high) = map.raw_range();
            assert!(high - low > 15_000.0, "{}: {low} to {high}", name.name());
            assert_eq!(map.x().cells(), 299);
        }
    }

    #[test]
    fn real_maps_repeat_sample_for_sample_and_get_flatter() {
        let tile = MapName::Moss.load(1024).unwrap();
        let twice = MapName::Moss.load(2048).unwrap();
        for (i, j) in [(0, 0), (17, 900), (1023, 1)] {
            assert_eq!(twice.raw(i + 1024, j), tile.raw(i, j));
            assert_eq!(twice.raw(i, j + 1024), tile.raw(i, j));
        }
        assert_eq!(MapName::Moss.depth(2048, 0.1), 0.05);
        assert_eq!(MapName::Moss.depth(512, 0.1), 0.1);
        assert_eq!(MapName::Fbm.depth(8192, 0.1), 0.1);
    }
}

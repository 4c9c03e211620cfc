//! [`Film`]: linear, scene-referred radiance and the layers beside it.

pub mod aov;
pub mod false_colour;
pub mod filter;
pub mod tonemap;

pub use aov::{Aov, UnknownAov};
pub use filter::{Filter, FilterKind, UnknownFilter};

/// The pixels of an image were too many for the memory at hand.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no memory for an image of {width} x {height} pixels")]
pub struct FilmError {
    /// Pixels along x.
    pub width: u32,
    /// Pixels along y.
    pub height: u32,
}

/// One AOV of an image.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    aov: Aov,
    values: Vec<f32>,
}

impl Layer {
    /// What it holds.
    pub fn aov(&self) -> Aov {
        self.aov
    }

    /// All values: pixels row by row from the top left, the channels of a pixel side by side, as
    /// [`Aov::channels`] names them.
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// Channels per pixel.
    pub fn channels(&self) -> usize {
        self.aov.channels().len()
    }
}

/// A rectangle of pixels: the corner nearest the top left, and the extent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tile {
    /// First pixel along x and y.
    pub corner: [u32; 2],
    /// Pixels along x and y.
    pub size: [u32; 2],
}

/// An image: linear RGB radiance, layers, and which pixels are done.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    resolution: [u32; 2],
    radiance: Vec<[f32; 3]>,
    layers: Vec<Layer>,
    finished: Vec<bool>,
}

impl Film {
    /// A black image of which no pixel is finished; layers hold [`Aov::without_hit`]. A layer named
    /// twice is kept once.
    ///
    /// # Errors
    /// [`FilmError`] if there is not enough memory.
    pub fn new(resolution: [u32; 2], aovs: &[Aov]) -> Result<Self, FilmError> {
        let [width, height] = resolution;
        let error = FilmError { width, height };
        let pixels = (width as usize).checked_mul(height as usize).ok_or(error)?;
        let mut layers: Vec<Layer> = Vec::new();
        for &aov in aovs {
            if layers.iter().all(|layer| layer.aov != aov) {
                let channels = aov.channels().len();
                let values = filled(aov.without_hit(), pixels.checked_mul(channels).ok_or(error)?);
                layers.push(Layer { aov, values: values.ok_or(error)? });
            }
        }
        let radiance = filled([0.0; 3], pixels).ok_or(error)?;
        let finished = filled(false, pixels).ok_or(error)?;
        Ok(Self { resolution, radiance, layers, finished })
    }

    /// Bytes a film of this shape holds.
    pub fn predicted_bytes(resolution: [u32; 2], aovs: &[Aov]) -> u64 {
        let channels: usize = aovs.iter().map(|aov| aov.channels().len()).sum();
        let pixel = size_of::<[f32; 3]>() + size_of::<bool>() + size_of::<f32>() * channels;
        u64::from(resolution[0]) * u64::from(resolution[1]) * pixel as u64
    }

    /// Pixels along x and y.
    pub fn resolution(&self) -> [u32; 2] {
        self.resolution
    }

    /// Linear RGB, W/(sr m^2), row by row from the top left. Unfinished pixels are black.
    pub fn radiance(&self) -> &[[f32; 3]] {
        &self.radiance
    }

    /// The layers, in the order asked for.
    pub fn layers(&self) -> &[Layer] {
        &self.layers
    }

    /// One layer.
    pub fn layer(&self, aov: Aov) -> Option<&Layer> {
        self.layers.iter().find(|layer| layer.aov == aov)
    }

    /// For each pixel, row by row from the top left, whether all its samples were taken.
    pub fn finished(&self) -> &[bool] {
        &self.finished
    }

    /// Whether every pixel is finished.
    pub fn is_complete(&self) -> bool {
        self.finished.iter().all(|&done| done)
    }

    /// Copies a finished tile, whose pixel (0, 0) is `tile.corner`, into place.
    ///
    /// # Panics
    /// If the tile does not lie in the image or `pixels` has another size or other layers.
    pub(crate) fn insert(&mut self, tile: Tile, pixels: &Film) {
        assert_eq!(pixels.resolution, tile.size);
        let [width, rows] = tile.size.map(|n| n as usize);
        for row in 0..rows {
            let from = row * width..(row + 1) * width;
            let first = (tile.corner[1] as usize + row) * self.resolution[0] as usize
                + tile.corner[0] as usize;
            let to = first..first + width;
            self.radiance[to.clone()].copy_from_slice(&pixels.radiance[from.clone()]);
            self.finished[to.clone()].fill(true);
            for (mine, other) in self.layers.iter_mut().zip(&pixels.layers) {
                assert_eq!(mine.aov, other.aov);
                let n = mine.channels();
                mine.values[to.start * n..to.end * n]
                    .copy_from_slice(&other.values[from.start * n..from.end * n]);
            }
        }
    }

    /// The colour and, layer by layer, the channels of one pixel.
    pub(crate) fn pixel_mut(&mut self, x: u32, y: u32) -> PixelMut<'_> {
        let at = y as usize * self.resolution[0] as usize + x as usize;
        PixelMut { radiance: &mut self.radiance[at], layers: &mut self.layers, at }
    }
}

/// A pixel being written.
pub(crate) struct PixelMut<'a> {
    /// Its colour.
    pub(crate) radiance: &'a mut [f32; 3],
    layers: &'a mut [Layer],
    at: usize,
}

impl PixelMut<'_> {
    /// Its layers and their channels.
    pub(crate) fn layers(&mut self) -> impl Iterator<Item = (Aov, &mut [f32])> {
        let at = self.at;
        self.layers.iter_mut().map(move |layer| {
            let n = layer.channels();
            (layer.aov, &mut layer.values[at * n..(at + 1) * n])
        })
    }
}

/// `count` copies of `value`, or nothing if memory runs out.
fn filled<T: Clone>(value: T, count: usize) -> Option<Vec<T>> {
    let mut values = Vec::new();
    values.try_reserve_exact(count).ok()?;
    values.resize(count, value);
    Some(values)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_are_put_in_place() {
        let aovs = [Aov::Uv, Aov::Z, Aov::Uv];
        let mut film = Film::new([5, 4], &aovs).unwrap();
        assert_eq!(film.layers().len(), 2);
        let tile = Tile { corner: [3, 1], size: [2, 3] };
        let mut pixels = Film::new(tile.size, &aovs).unwrap();
        let mut pixel = pixels.pixel_mut(1, 2);
        *pixel.radiance = [1.0, 2.0, 3.0];
        for (_, channels) in pixel.layers() {
            channels.fill(7.0);
        }
        film.insert(tile, &pixels);
        // Pixel (1, 2) of the tile is pixel (4, 3) of the film, its last.
        assert_eq!(film.radiance()[19], [1.0, 2.0, 3.0]);
        assert_eq!(film.layer(Aov::Uv).unwrap().values()[36..], [0.0, 0.0, 7.0, 7.0]);
        assert_eq!(film.layer(Aov::Z).unwrap().values()[18..], [f32::INFINITY, 7.0]);
        let finished: Vec<usize> = (0..20).filter(|&i| film.finished()[i]).collect();
        assert_eq!(finished, [8, 9, 13, 14, 18, 19]);
        assert!(!film.is_complete());
        assert!(film.layer(Aov::P).is_none());
    }

    #[test]
    fn an_image_beyond_memory_is_an_error() {
        let error = Film::new([u32::MAX, u32::MAX], &[Aov::P]).unwrap_err();
        assert_eq!(error.to_string(), "no memory for an image of 4294967295 x 4294967295 pixels");
    }

    #[test]
    fn predicted_bytes_are_those_held() {
        let aovs = [Aov::P, Aov::Height];
        let film = Film::new([7, 3], &aovs).unwrap();
        let values: usize = film.layers().iter().map(|layer| layer.values().len()).sum();
        let held = film.radiance().len() * 12 + film.finished().len() + values * 4;
        assert_eq!(Film::predicted_bytes([7, 3], &aovs), held as u64);
    }
}

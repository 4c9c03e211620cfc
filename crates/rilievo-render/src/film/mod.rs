//! [`Film`]: linear, scene-referred radiance and the layers beside it.
//!
//! A film covers a window of an image, the whole of it unless it was cropped. Integrators that take
//! the samples of a pixel bit by bit keep [`Sums`] beside the picture.

pub mod aov;
pub mod false_colour;
pub mod filter;
pub mod join;
pub mod sums;
pub mod tonemap;

pub use aov::{Aov, UnknownAov};
pub use filter::{Filter, FilterKind, UnknownFilter};
pub use join::{JoinError, join};
use sums::PixelSums;
pub use sums::{Counts, Sums};

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

impl Tile {
    /// A whole image.
    pub fn whole(resolution: [u32; 2]) -> Self {
        Self { corner: [0, 0], size: resolution }
    }

    /// The first pixel beyond it along x and y.
    pub fn end(self) -> [u32; 2] {
        [0, 1].map(|axis| self.corner[axis].saturating_add(self.size[axis]))
    }

    /// Whether it has pixels and all of them lie in an image.
    pub fn lies_in(self, resolution: [u32; 2]) -> bool {
        [0, 1].into_iter().all(|axis| self.size[axis] > 0 && self.end()[axis] <= resolution[axis])
    }
}

/// An image or a window of it: linear RGB radiance, layers, and which pixels are done.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    resolution: [u32; 2],
    corner: [u32; 2],
    samples: [u32; 2],
    sums: Option<Sums>,
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
        Ok(Self {
            resolution,
            corner: [0, 0],
            samples: [0, 1],
            sums: None,
            radiance,
            layers,
            finished,
        })
    }

    /// Bytes a film of this shape holds, with or without sums.
    pub fn predicted_bytes(resolution: [u32; 2], aovs: &[Aov], sums: bool) -> u64 {
        let channels: usize = aovs.iter().map(|aov| aov.channels().len()).sum();
        let pixel = size_of::<[f32; 3]>() + size_of::<bool>() + size_of::<f32>() * channels;
        let picture = u64::from(resolution[0]) * u64::from(resolution[1]) * pixel as u64;
        picture + if sums { Sums::predicted_bytes(resolution, aovs) } else { 0 }
    }

    /// A film of a window of an image, for the samples from the first of two absolute indices up to
    /// the second; with sums beside the picture if the samples of a pixel may come bit by bit.
    ///
    /// # Errors
    /// [`FilmError`] if there is not enough memory.
    pub fn of_window(
        window: Tile,
        samples: [u32; 2],
        aovs: &[Aov],
        sums: bool,
    ) -> Result<Self, FilmError> {
        let film = Self::new(window.size, aovs)?;
        let aovs: Vec<Aov> = film.layers.iter().map(Layer::aov).collect();
        let sums = if sums { Some(Sums::new(window.size, &aovs)?) } else { None };
        Ok(Self { corner: window.corner, samples, sums, ..film })
    }

    /// Puts back what a film of this window, these samples and these layers held: which pixels are
    /// finished, the integers and counts of its sums ([`Sums`]) if it kept some, or else the colour,
    /// if it was kept, and each layer. To be asked of a film without sums, so that they are held once.
    /// `None` if anything is missing or too long, or if no samples add up to such sums.
    #[must_use]
    pub fn restored(
        mut self,
        finished: Vec<bool>,
        sums: Option<(Vec<i128>, Vec<Counts>)>,
        radiance: Option<Vec<f32>>,
        layers: Vec<Vec<f32>>,
    ) -> Option<Self> {
        if finished.len() != self.finished.len() || self.sums.is_some() {
            return None;
        }
        self.finished = finished;
        if let Some((values, counts)) = sums {
            let aovs: Vec<Aov> = self.layers.iter().map(Layer::aov).collect();
            self.sums = Some(Sums::checked(self.resolution, aovs, values, counts)?);
            self.store_sums();
            return Some(self);
        }
        if let Some(values) = radiance {
            let to = self.radiance.as_flattened_mut();
            (to.len() == values.len()).then(|| to.copy_from_slice(&values))?;
        }
        (layers.len() == self.layers.len()).then_some(())?;
        for (layer, values) in self.layers.iter_mut().zip(layers) {
            (layer.values.len() == values.len()).then_some(())?;
            layer.values = values;
        }
        Some(self)
    }

    /// Pixels along x and y.
    pub fn resolution(&self) -> [u32; 2] {
        self.resolution
    }

    /// The part of the image that it covers.
    pub fn window(&self) -> Tile {
        Tile { corner: self.corner, size: self.resolution }
    }

    /// The samples that a finished pixel has: from the first of two absolute indices up to the second.
    pub fn samples(&self) -> [u32; 2] {
        self.samples
    }

    /// What the samples have added up to, if that is kept.
    pub fn sums(&self) -> Option<&Sums> {
        self.sums.as_ref()
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

    /// Camera rays of all its pixels, traced or not.
    pub fn rays(&self) -> u64 {
        let [first, end] = self.samples;
        self.finished.len() as u64 * u64::from(end - first)
    }

    /// Camera rays that were traced.
    pub fn rays_taken(&self) -> u64 {
        match &self.sums {
            Some(sums) => sums.counts().iter().map(|counts| u64::from(counts.taken)).sum(),
            None => self.rays_done(),
        }
    }

    /// Camera rays that need not be traced any more: all of finished pixels, and those that were
    /// taken of others.
    pub fn rays_done(&self) -> u64 {
        let [first, end] = self.samples;
        let pixels = self.finished.iter().enumerate();
        let done = pixels.map(|(at, &done)| match &self.sums {
            _ if done => u64::from(end - first),
            Some(sums) => u64::from(sums.counts()[at].taken),
            None => 0,
        });
        done.sum()
    }

    /// Whether every pixel is finished.
    pub fn is_complete(&self) -> bool {
        self.finished.iter().all(|&done| done)
    }

    /// Copies a tile, whose pixel (0, 0) is `tile.corner` of this film, into place, with the sums of
    /// a film that keeps some.
    ///
    /// # Panics
    /// If the tile does not lie in the film or `pixels` has another size or other layers.
    pub(crate) fn insert(&mut self, tile: Tile, pixels: &Film) {
        assert_eq!(pixels.resolution, tile.size);
        for (to, from) in sums::rows(self.resolution[0], tile) {
            self.radiance[to.clone()].copy_from_slice(&pixels.radiance[from.clone()]);
            self.finished[to.clone()].copy_from_slice(&pixels.finished[from.clone()]);
            for (mine, other) in self.layers.iter_mut().zip(&pixels.layers) {
                assert_eq!(mine.aov, other.aov);
                let n = mine.channels();
                mine.values[to.start * n..to.end * n]
                    .copy_from_slice(&other.values[from.start * n..from.end * n]);
            }
        }
        if let (Some(mine), Some(other)) = (&mut self.sums, &pixels.sums) {
            mine.paste(tile, other);
        }
    }

    /// A film of a tile that has less than `taken` samples a pixel and is not finished, with the
    /// tile's sums if there are any, and the samples it has.
    pub(crate) fn part(&self, tile: Tile, taken: u32) -> Result<Option<(Self, u32)>, FilmError> {
        let at = tile.corner[1] as usize * self.resolution[0] as usize + tile.corner[0] as usize;
        let has = self.sums.as_ref().map_or(0, |sums| sums.taken(tile));
        if self.finished.get(at) != Some(&false) || has >= taken {
            return Ok(None);
        }
        let aovs: Vec<Aov> = self.layers.iter().map(Layer::aov).collect();
        let sums = self.sums.as_ref().map(|sums| sums.cut(tile)).transpose()?;
        let part = Self::of_window(Tile::whole(tile.size), self.samples, &aovs, false)?;
        Ok(Some((Self { sums, ..part }, has)))
    }

    /// The sums of a pixel, if there are any.
    pub(crate) fn pixel_sums(&mut self, x: u32, y: u32) -> Option<PixelSums<'_>> {
        self.sums.as_mut().map(|sums| sums.pixel_mut(x, y))
    }

    /// Says of all pixels whether they are finished.
    pub(crate) fn set_finished(&mut self, finished: bool) {
        self.finished.fill(finished);
    }

    /// Writes the means of the sums into the picture.
    pub(crate) fn store_sums(&mut self) {
        let Some(sums) = self.sums.take() else { return };
        let [width, height] = self.resolution;
        for y in 0..height {
            for x in 0..width {
                let at = y as usize * width as usize + x as usize;
                sums.store(at, &mut self.pixel_mut(x, y));
            }
        }
        self.sums = Some(sums);
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
        pixels.set_finished(true);
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
        assert_eq!(Film::predicted_bytes([7, 3], &aovs, false), held as u64);
        let film = Film::of_window(Tile::whole([7, 3]), [0, 1], &aovs, true).unwrap();
        let sums = film.sums().unwrap();
        let held = held + size_of_val(sums.values()) + size_of_val(sums.counts());
        assert_eq!(Film::predicted_bytes([7, 3], &aovs, true), held as u64);
    }
}

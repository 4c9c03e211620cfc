//! [`Passes`]: the tiles of a film, visited again and again by all threads.

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;
use rilievo::Ray;

use crate::film::{Film, FilmError, Tile};
use crate::integrator::{OFFSPRING, PixelTracer, RayCounts, Wave};
use crate::render::{FLOOR, RenderError, RenderOptions, TILE};
use crate::scene::Scene;
use crate::tracer::{CameraRay, RAYS, Traced, Tracer};

/// Samples at which a tile is first asked for its error.
const FIRST_QUESTION: u32 = 64;

/// What all threads write to.
pub(crate) struct Shared {
    film: Mutex<Film>,
    rays: Mutex<RayCounts>,
    done: AtomicU64,
}

impl Shared {
    pub(crate) fn new(film: Film) -> Self {
        Self {
            done: AtomicU64::new(film.rays_done()),
            film: Mutex::new(film),
            rays: Mutex::new(RayCounts::default()),
        }
    }

    /// The film and the rays that were traced for it.
    pub(crate) fn into_parts(self) -> (Film, RayCounts) {
        (into_inner(self.film), into_inner(self.rays))
    }
}

/// The tiles of a window: those of the whole image, cut by the window's border.
pub(crate) struct Tiles {
    window: Tile,
    /// First tile along x and y.
    first: [u32; 2],
    /// Tiles along x and y: at most 4096 each, see `Camera::MAX_RESOLUTION`.
    count: [u32; 2],
}

impl Tiles {
    pub(crate) fn of(window: Tile) -> Self {
        let first = window.corner.map(|at| at / TILE);
        let count = [0, 1].map(|axis| window.end()[axis].div_ceil(TILE) - first[axis]);
        Self { window, first, count }
    }

    fn len(&self) -> u32 {
        self.count[0] * self.count[1]
    }

    /// A tile, in pixels of the window.
    fn get(&self, index: u32) -> Tile {
        let place = [index % self.count[0], index / self.count[0]];
        let bound = |axis: usize, after: u32| {
            let at = (self.first[axis] + place[axis] + after) * TILE;
            at.clamp(self.window.corner[axis], self.window.end()[axis]) - self.window.corner[axis]
        };
        let corner = [bound(0, 0), bound(1, 0)];
        Tile { corner, size: [bound(0, 1) - corner[0], bound(1, 1) - corner[1]] }
    }
}

/// Passes over the tiles of a film.
pub(crate) struct Passes<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) options: &'a RenderOptions<'a>,
    pub(crate) tiles: Tiles,
    /// Samples a pixel.
    pub(crate) samples: u32,
}

/// A tile on its way through a pass.
struct Part {
    tile: Tile,
    pixels: Film,
    /// The samples to be taken, from the first of two absolute indices up to the second.
    range: [u32; 2],
}

impl Passes<'_> {
    pub(crate) fn all(&self, shared: &Shared) -> Result<(), RenderError> {
        let sums = self.scene.settings().integrator.sums();
        let mut end = if sums { 1 } else { self.samples };
        loop {
            let up_to = end.min(self.samples);
            // Levels of detail are worlds of their own.
            match self.options.tracer.filter(|_| self.scene.level_of_detail().is_none()) {
                None => (0..self.tiles.len())
                    .into_par_iter()
                    .with_max_len(1)
                    .try_for_each(|index| self.visit(index, up_to, shared))?,
                Some(tracer) => self.visit_traced(tracer, up_to, shared)?,
            }
            if up_to == self.samples || self.cancelled() {
                return Ok(());
            }
            end = if end < FIRST_QUESTION { 4 * end } else { end + FIRST_QUESTION };
        }
    }

    fn cancelled(&self) -> bool {
        self.options.cancel.load(Ordering::Relaxed)
    }

    /// Takes the samples of a tile up to `end` of the range.
    fn visit(&self, index: u32, end: u32, shared: &Shared) -> Result<(), RenderError> {
        let Some(part) = self.part(index, end, shared)? else { return Ok(()) };
        self.take(part, PixelTracer::new(self.scene, self.options.pixel_centers), shared)
    }

    /// Takes the samples of all tiles up to `end` of the range, those of a few tiles at a time.
    fn visit_traced(
        &self,
        tracer: &dyn Tracer,
        end: u32,
        shared: &Shared,
    ) -> Result<(), RenderError> {
        let rays = u64::from(TILE * TILE) * u64::from(end);
        let mut first = 0;
        while first < self.tiles.len() {
            if self.cancelled() {
                return Ok(());
            }
            let most = tracer.at_once().map_or(RAYS, |most| most.min(RAYS)) as u64;
            let tiles = (most / rays).clamp(1, u64::from(u32::MAX)) as u32;
            let some = first..self.tiles.len().min(first.saturating_add(tiles));
            let parts: Vec<Part> = some
                .filter_map(|index| self.part(index, end, shared).transpose())
                .collect::<Result<_, _>>()?;
            self.take_traced(parts, tracer, shared)?;
            first = first.saturating_add(tiles);
        }
        Ok(())
    }

    /// Takes the samples of some tiles.
    fn take_traced(
        &self,
        parts: Vec<Part>,
        tracer: &dyn Tracer,
        shared: &Shared,
    ) -> Result<(), RenderError> {
        let of_tiles: Vec<Vec<CameraRay>> =
            parts.par_iter().with_max_len(1).map(|part| self.camera_rays(part)).collect();
        let lengths: Vec<usize> = of_tiles.iter().map(Vec::len).collect();
        let rays: Vec<CameraRay> = of_tiles.into_iter().flatten().collect();
        let asked: Vec<Ray> = rays.iter().map(|ray| ray.ray).collect();
        let samples = PixelTracer::new(self.scene, self.options.pixel_centers).samples();
        let (scene, offspring, cancel) = (self.scene, OFFSPRING, self.options.cancel);
        let wave = Wave { scene, tracer, samples, offspring, cancel };
        let elsewhere = tracer.seen(&rays, samples).map_err(RenderError::Tracer)?;
        // First hits are wanted for layers and for waves.
        let wanted = elsewhere.is_none() || !self.options.aovs.is_empty();
        let first = if wanted { asked.as_slice() } else { &[] };
        let found = wave.closest(first).map_err(RenderError::Tracer)?;
        let seen = match elsewhere {
            Some(seen) => seen,
            None => wave.seen(&rays, &found).map_err(RenderError::Tracer)?,
        };
        if self.cancelled() {
            return Ok(());
        }
        *lock(&shared.rays) += seen.rays;
        let (mut found, mut seen) = (found.as_slice(), seen.radiance.as_slice());
        let answers: Vec<(&[Traced], &[_])> = lengths
            .into_iter()
            .map(|length| {
                let seen = seen.split_off(..length).unwrap_or_default();
                (found.split_off(..length).unwrap_or_default(), seen)
            })
            .collect();
        let tiles = parts.into_par_iter().zip(answers).with_max_len(1);
        tiles.try_for_each(|(part, (found, seen))| {
            let tracer = PixelTracer::new(self.scene, self.options.pixel_centers);
            self.take(part, tracer.with_answers(found, seen), shared)
        })
    }

    /// A tile whose samples up to `end` of the range are to be taken; none if it has them.
    fn part(&self, index: u32, end: u32, shared: &Shared) -> Result<Option<Part>, FilmError> {
        let tile = self.tiles.get(index);
        let part = lock(&shared.film).part(tile, end)?;
        Ok(part.map(|(pixels, taken)| {
            let first = pixels.samples()[0];
            Part { tile, pixels, range: [first + taken, first + end] }
        }))
    }

    /// The pixels of a tile, row by row: each in the tile and in the image.
    fn pixels(&self, tile: Tile) -> impl Iterator<Item = ([u32; 2], [u32; 2])> {
        let corner = [0, 1].map(|axis| self.tiles.window.corner[axis] + tile.corner[axis]);
        (0..tile.size[1]).flat_map(move |y| {
            (0..tile.size[0]).map(move |x| ([x, y], [corner[0] + x, corner[1] + y]))
        })
    }

    /// The camera rays of a tile.
    fn camera_rays(&self, part: &Part) -> Vec<CameraRay> {
        let mut tracer = PixelTracer::new(self.scene, self.options.pixel_centers);
        let mut rays = Vec::new();
        self.pixels(part.tile)
            .for_each(|(_, pixel)| tracer.camera_rays(pixel, part.range, &mut rays));
        rays
    }

    /// Takes the samples of a tile and puts it back into the film, unless cancelled before its last row.
    fn take(
        &self,
        part: Part,
        mut tracer: PixelTracer<'_>,
        shared: &Shared,
    ) -> Result<(), RenderError> {
        let Part { tile, mut pixels, range } = part;
        for ([x, y], pixel) in self.pixels(tile) {
            if x == 0 && self.cancelled() {
                return Ok(());
            }
            match pixels.pixel_sums(x, y) {
                Some(mut sums) => tracer.extend(pixel, range, &mut sums),
                None => tracer.trace(pixel, &mut pixels.pixel_mut(x, y)),
            }
        }
        if let Some(reason) = self.scene.texture_failure() {
            return Err(RenderError::Texture(reason.to_owned()));
        }
        pixels.store_sums();
        let [taken, end] = range.map(|sample| sample - pixels.samples()[0]);
        let enough = end == self.samples || self.is_good_enough(&pixels, end);
        pixels.set_finished(enough);
        let area = u64::from(tile.size[0]) * u64::from(tile.size[1]);
        let step = area * u64::from(if enough { self.samples - taken } else { end - taken });
        {
            let mut film = lock(&shared.film);
            film.insert(tile, &pixels);
            (self.options.watch)(&film);
        }
        *lock(&shared.rays) += tracer.rays();
        let done = shared.done.fetch_add(step, Ordering::Relaxed) + step;
        let [width, height] = self.tiles.window.size.map(u64::from);
        (self.options.progress)(done, width * height * u64::from(self.samples));
        Ok(())
    }

    /// Whether a tile may stop at so many samples.
    fn is_good_enough(&self, pixels: &Film, taken: u32) -> bool {
        let asked = taken >= FIRST_QUESTION && taken.is_power_of_two();
        match (self.options.max_error, pixels.sums()) {
            (Some(most), Some(sums)) if asked => sums.relative_error(FLOOR) <= most,
            _ => false,
        }
    }
}

/// A poisoned lock still guards a film of whole tiles.
fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
}

fn into_inner<T>(mutex: Mutex<T>) -> T {
    mutex.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_a_window_once_on_the_grid_of_the_image() {
        for window in [
            Tile { corner: [0, 0], size: [1, 1] },
            Tile { corner: [0, 0], size: [40, 16] },
            Tile { corner: [5, 30], size: [30, 3] },
            Tile { corner: [16, 31], size: [16, 34] },
        ] {
            let tiles = Tiles::of(window);
            let mut seen = vec![0; (window.size[0] * window.size[1]) as usize];
            for tile in (0..tiles.len()).map(|index| tiles.get(index)) {
                for axis in 0..2 {
                    let start = tile.corner[axis] + window.corner[axis];
                    assert!(start == window.corner[axis] || start.is_multiple_of(TILE));
                    assert!(tile.size[axis] > 0 && start % TILE + tile.size[axis] <= TILE);
                }
                for y in tile.corner[1]..tile.end()[1] {
                    for x in tile.corner[0]..tile.end()[0] {
                        seen[(y * window.size[0] + x) as usize] += 1;
                    }
                }
            }
            assert!(seen.iter().all(|&times| times == 1), "{window:?}");
        }
    }
}

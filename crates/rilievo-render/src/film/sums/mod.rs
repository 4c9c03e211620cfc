//! [`Sums`]: what the samples of a picture have added up to, exactly.
//!
//! The mean of a pixel must not depend on who took its samples, when, in how many runs and in which
//! order; and floating-point sums do depend on it. So each sample's value is cut to a multiple of
//! 2^-56 and added as an integer. Integers add exactly in any order: runs that were interrupted,
//! split by samples or by tiles, and merged, end in the same integers and hence in the same
//! picture, bit for bit.
//!
//! Range and precision. A sum keeps 120 bits. Samples are at most [`MOST`] = 2^40 in absolute value
//! and a pixel takes at most 2^20 of them, so that a sum stays below 2^60 and its integer below
//! 2^116. What is cut off a sample is below 2^-56, 1.4e-17: a mean of 1e-4 keeps 42 bits, one of
//! 1e-9 still the 24 of the f32 it becomes.
//!
//! A sample that is NaN, infinite or beyond [`MOST`] is refused: it is counted and left out of sum
//! and mean, for one would spoil the pixel for good. Channels of layers are bounded by [`MOST`]
//! instead.
//!
//! Beside the colour stands the sum of squares of each sample's mean channel, from which the
//! standard error of the pixel follows. Squares are cut to multiples of 2^-52 and taken of values
//! of at most 2^20, so what is brighter counts less there, and there only.
//!
//! Samples of a filter's negative part count -1: their values are subtracted, the weights added up.
//!
//! Memory: 16 bytes a channel and 20 for the counts, 84 a pixel without layers.

mod pixel;

use super::{Aov, FilmError, PixelMut, Tile, filled};
pub(crate) use pixel::PixelSums;

/// Largest absolute value of a channel of a sample.
pub const MOST: f64 = (1_u64 << 40) as f64;

/// Largest absolute value of which a square is taken.
const MOST_SQUARED: f64 = (1_u64 << 20) as f64;

/// 2^56: units of a sum.
const UNITS: f64 = (1_u64 << 56) as f64;

/// 2^52: units of a sum of squares.
const SQUARE_UNITS: f64 = (1_u64 << 52) as f64;

/// Red, green, blue, square.
const COLOUR: usize = 4;

/// How many samples a pixel took, and what became of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Samples taken, those refused included. They are those of the first absolute indices of the
    /// range.
    pub taken: u32,
    /// Samples left out: NaN, infinite or too large.
    pub refused: u32,
    /// Sum of the weights of the others.
    pub weight: i32,
    /// Samples that layers are means of: those of positive weight.
    pub seen: u32,
    /// Those of them whose camera ray hit something.
    pub hits: u32,
}

/// The sums of a rectangle of pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct Sums {
    size: [u32; 2],
    aovs: Vec<Aov>,
    /// Pixel by pixel: red, green, blue, square, then the channels of each layer.
    values: Vec<i128>,
    counts: Vec<Counts>,
}

/// Integers that a pixel keeps.
fn stride(aovs: &[Aov]) -> usize {
    COLOUR + aovs.iter().map(|aov| aov.channels().len()).sum::<usize>()
}

impl Sums {
    /// Nothing taken yet.
    ///
    /// # Errors
    /// [`FilmError`] if there is not enough memory.
    pub(crate) fn new(size: [u32; 2], aovs: &[Aov]) -> Result<Self, FilmError> {
        let error = FilmError { width: size[0], height: size[1] };
        let pixels = (size[0] as usize).checked_mul(size[1] as usize).ok_or(error)?;
        let count = pixels.checked_mul(stride(aovs)).ok_or(error)?;
        let values = filled(0, count).ok_or(error)?;
        let counts = filled(Counts::default(), pixels).ok_or(error)?;
        Ok(Self { size, aovs: aovs.to_vec(), values, counts })
    }

    /// Bytes that the sums of so many pixels hold.
    pub(crate) fn predicted_bytes(size: [u32; 2], aovs: &[Aov]) -> u64 {
        let pixel = size_of::<Counts>() + size_of::<i128>() * stride(aovs);
        u64::from(size[0]) * u64::from(size[1]) * pixel as u64
    }

    /// Integers a pixel: red, green, blue, square, then the channels of each layer.
    pub fn stride(&self) -> usize {
        stride(&self.aovs)
    }

    /// All integers, pixel by pixel, row by row from the top left.
    pub fn values(&self) -> &[i128] {
        &self.values
    }

    /// All counts, row by row from the top left.
    pub fn counts(&self) -> &[Counts] {
        &self.counts
    }

    /// Sums with integers and counts as [`Self::values`] and [`Self::counts`] gave them. `None` if there
    /// are more or fewer of them than pixels ask for, or any that no samples add up to.
    pub(crate) fn checked(
        size: [u32; 2],
        aovs: Vec<Aov>,
        values: Vec<i128>,
        counts: Vec<Counts>,
    ) -> Option<Self> {
        let pixels = (size[0] as usize).checked_mul(size[1] as usize)?;
        let lengths =
            Some(values.len()) == pixels.checked_mul(stride(&aovs)) && counts.len() == pixels;
        // A sample adds at most 2^40 units of 2^-56.
        let values_hold = values.chunks(stride(&aovs)).zip(&counts).all(|(values, counts)| {
            let limit = u128::from(counts.taken) << 96;
            values.iter().all(|v| v.unsigned_abs() <= limit)
        });
        let counts_hold = counts.iter().all(|c| {
            let kept = c.taken.checked_sub(c.refused);
            kept.is_some_and(|kept| c.weight.unsigned_abs() <= kept)
                && c.seen <= c.taken
                && c.hits <= c.seen
                && c.taken <= 1 << 20
        });
        (lengths && values_hold && counts_hold).then_some(Self { size, aovs, values, counts })
    }

    /// A pixel, to be added to.
    pub(crate) fn pixel_mut(&mut self, x: u32, y: u32) -> PixelSums<'_> {
        let at = y as usize * self.size[0] as usize + x as usize;
        let stride = stride(&self.aovs);
        let values = &mut self.values[at * stride..(at + 1) * stride];
        PixelSums::new(values, &mut self.counts[at], &self.aovs)
    }

    /// Samples that every pixel of the tile has taken: tiles go on as a whole.
    pub(crate) fn taken(&self, tile: Tile) -> u32 {
        let at = tile.corner[1] as usize * self.size[0] as usize + tile.corner[0] as usize;
        self.counts.get(at).map_or(0, |counts| counts.taken)
    }

    /// A copy of a rectangle.
    pub(crate) fn cut(&self, tile: Tile) -> Result<Self, FilmError> {
        let mut part = Self::new(tile.size, &self.aovs)?;
        let stride = stride(&self.aovs);
        for (own, other) in rows(self.size[0], tile) {
            let [own_values, other_values] =
                [&own, &other].map(|r| r.start * stride..r.end * stride);
            part.values[other_values].copy_from_slice(&self.values[own_values]);
            part.counts[other].copy_from_slice(&self.counts[own]);
        }
        Ok(part)
    }

    /// Puts a rectangle, cut out before, back in place.
    pub(crate) fn paste(&mut self, tile: Tile, part: &Self) {
        assert_eq!((part.size, &part.aovs), (tile.size, &self.aovs));
        let stride = stride(&self.aovs);
        for (own, other) in rows(self.size[0], tile) {
            let [own_values, other_values] =
                [&own, &other].map(|r| r.start * stride..r.end * stride);
            self.values[own_values].copy_from_slice(&part.values[other_values]);
            self.counts[own].copy_from_slice(&part.counts[other]);
        }
    }

    /// Adds the samples of another run of the same pixels.
    pub(crate) fn add(&mut self, other: &Self) {
        for (mine, other) in self.values.iter_mut().zip(&other.values) {
            *mine += other;
        }
        for (mine, other) in self.counts.iter_mut().zip(&other.counts) {
            mine.taken += other.taken;
            mine.refused += other.refused;
            mine.weight += other.weight;
            mine.seen += other.seen;
            mine.hits += other.hits;
        }
    }

    /// Writes the means of a pixel.
    pub(crate) fn store(&self, at: usize, out: &mut PixelMut<'_>) {
        let stride = stride(&self.aovs);
        let (values, counts) = (&self.values[at * stride..(at + 1) * stride], &self.counts[at]);
        for (channel, &sum) in out.radiance.iter_mut().zip(values) {
            *channel = mean(sum, f64::from(counts.weight)).unwrap_or(0.0);
        }
        let mut rest = values[COLOUR..].iter();
        for (aov, channels) in out.layers() {
            let count = if aov == Aov::Steps { counts.seen } else { counts.hits };
            for (channel, &sum) in channels.iter_mut().zip(&mut rest) {
                *channel = mean(sum, f64::from(count)).unwrap_or_else(|| aov.without_hit());
            }
        }
    }

    /// The mean channel of a pixel's colour, and its standard error if more than one sample was kept:
    /// samples taken as independent, so an upper bound in the mean for samplers that spread them
    /// better.
    pub fn estimate(&self, at: usize) -> (f64, Option<f64>) {
        let stride = stride(&self.aovs);
        let (values, counts) = (&self.values[at * stride..(at + 1) * stride], &self.counts[at]);
        let weight = f64::from(counts.weight);
        if weight == 0.0 {
            return (0.0, None);
        }
        let mean = (values[0] + values[1] + values[2]) as f64 / (3.0 * UNITS * weight);
        let kept = f64::from(counts.taken - counts.refused);
        let square = values[3] as f64 / SQUARE_UNITS;
        let variance = (square - kept * mean * mean).max(0.0) / (kept - 1.0);
        // The estimate is a sum of `kept` samples over the sum of their weights.
        let error = (kept * variance).sqrt() / weight.abs();
        (mean, (kept > 1.0).then_some(error))
    }

    /// The root of the mean square error of all pixels over that of their values, which count as no
    /// darker than `floor`. Infinite before every pixel has an estimate.
    pub(crate) fn relative_error(&self, floor: f64) -> f64 {
        let (mut errors, mut values) = (0.0, 0.0);
        for at in 0..self.counts.len() {
            let (mean, Some(error)) = self.estimate(at) else { return f64::INFINITY };
            errors += error * error;
            values += (mean * mean).max(floor * floor);
        }
        (errors / values).sqrt()
    }
}

/// For each row of a tile of an image `width` pixels wide: its pixels in the image and in the tile.
pub(super) fn rows(
    width: u32,
    tile: Tile,
) -> impl Iterator<Item = (std::ops::Range<usize>, std::ops::Range<usize>)> {
    let [columns, count] = tile.size.map(|n| n as usize);
    let [x, y] = tile.corner.map(|n| n as usize);
    (0..count).map(move |row| {
        let first = (y + row) * width as usize + x;
        (first..first + columns, row * columns..(row + 1) * columns)
    })
}

/// A sum over a count, as a picture keeps it.
fn mean(sum: i128, count: f64) -> Option<f32> {
    (count != 0.0).then(|| (sum as f64 / (UNITS * count)) as f32)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::colour::Rgb;
    use crate::film::Film;

    /// The samples of a pixel: many magnitudes, both signs.
    fn sample(k: u32) -> Rgb {
        let x = f64::from(k.wrapping_mul(2_654_435_761));
        Rgb::new(x * 1e-9, (x * 1e-3).sin() * 10_f64.powi(k as i32 % 9 - 4), 1.0 / (x + 1.0))
    }

    fn summed(samples: impl Iterator<Item = u32>) -> Sums {
        let mut sums = Sums::new([1, 1], &[Aov::P]).unwrap();
        for k in samples {
            let mut pixel = sums.pixel_mut(0, 0);
            pixel.add(sample(k), if k % 7 == 3 { -1.0 } else { 1.0 });
            pixel.add_layers(k % 2 == 0, |_| (k % 2 == 0).then(|| sample(k + 1)));
        }
        sums
    }

    #[test]
    fn the_order_of_samples_does_not_show() {
        let forth = summed(0..1000);
        assert_eq!(summed((0..1000).rev()), forth);
        let mut parts = summed(600..1000);
        parts.add(&summed(0..250));
        parts.add(&summed(250..600));
        assert_eq!(parts, forth);
    }

    #[test]
    fn means_are_those_of_the_samples() {
        let sums = summed(0..1000);
        let mut film = Film::new([1, 1], &[Aov::P]).unwrap();
        sums.store(0, &mut film.pixel_mut(0, 0));
        let weight = |k: u32| if k % 7 == 3 { -1.0 } else { 1.0 };
        let total: f64 = (0..1000).map(weight).sum();
        let want = (0..1000).map(|k| sample(k) * weight(k)).sum::<Rgb>() / total;
        for (got, want) in film.radiance()[0].into_iter().zip(want.to_array()) {
            assert!((f64::from(got) / want - 1.0).abs() < 1e-6, "{got} {want}");
        }
        let seen = (0..1000).step_by(2).map(|k| sample(k + 1)).sum::<DVec3>() / 500.0;
        let layer = film.layer(Aov::P).unwrap().values();
        for (got, want) in layer.iter().zip(seen.to_array()) {
            assert!((f64::from(*got) / want - 1.0).abs() < 1e-6, "{got} {want}");
        }
    }

    #[test]
    fn samples_that_are_no_numbers_are_counted_and_left_out() {
        let mut sums = Sums::new([1, 1], &[]).unwrap();
        let bad = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 2.0 * MOST];
        for value in [1.0, 3.0].into_iter().chain(bad) {
            sums.pixel_mut(0, 0).add(Rgb::new(1.0, value, 1.0), 1.0);
        }
        let Counts { taken, refused, weight, .. } = sums.counts()[0];
        assert_eq!((taken, refused, weight), (6, 4, 2));
        let mut film = Film::new([1, 1], &[]).unwrap();
        sums.store(0, &mut film.pixel_mut(0, 0));
        assert_eq!(film.radiance()[0], [1.0, 2.0, 1.0]);
    }

    #[test]
    fn the_error_is_that_of_a_mean() {
        // Values 0 and 6, as often: a standard deviation of 3.
        let mut sums = Sums::new([1, 1], &[]).unwrap();
        assert_eq!(sums.relative_error(0.01), f64::INFINITY);
        for k in 0..900 {
            sums.pixel_mut(0, 0).add(Rgb::splat(f64::from(k % 2) * 6.0), 1.0);
        }
        let (mean, error) = sums.estimate(0);
        assert_eq!(mean, 3.0);
        assert!((error.unwrap() - 0.1).abs() < 1e-4, "{error:?}");
        assert!((sums.relative_error(0.01) - 0.1 / 3.0).abs() < 1e-4);
    }

    #[test]
    fn parts_go_out_and_back() {
        let mut all = Sums::new([5, 4], &[Aov::Z]).unwrap();
        for (k, value) in all.values.iter_mut().enumerate() {
            *value = k as i128;
        }
        for (k, counts) in all.counts.iter_mut().enumerate() {
            counts.taken = k as u32;
        }
        let tile = Tile { corner: [3, 1], size: [2, 3] };
        let part = all.cut(tile).unwrap();
        assert_eq!(part.counts.iter().map(|c| c.taken).collect::<Vec<_>>(), [8, 9, 13, 14, 18, 19]);
        assert_eq!((all.taken(tile), part.values[0]), (8, 8 * 5));
        let mut other = Sums::new([5, 4], &[Aov::Z]).unwrap();
        other.paste(tile, &part);
        assert_eq!(other.cut(tile).unwrap(), part);
        assert_eq!(other.counts[7], Counts::default());
    }

    #[test]
    fn nonsense_is_not_restored() {
        let sums = summed(0..9);
        let restored = |change: &dyn Fn(&mut Vec<i128>, &mut Counts)| {
            let (mut values, mut counts) = (sums.values.clone(), sums.counts.clone());
            change(&mut values, &mut counts[0]);
            Sums::checked([1, 1], vec![Aov::P], values, counts)
        };
        assert_eq!(restored(&|_, _| {}), Some(sums.clone()));
        assert_eq!(restored(&|values, _| values[0] = i128::MAX), None);
        assert_eq!(restored(&|values, _| values.truncate(1)), None);
        assert_eq!(restored(&|_, counts| counts.hits = 99), None);
        assert_eq!(restored(&|_, counts| counts.weight = -12), None);
        assert_eq!(restored(&|_, counts| counts.refused = 10), None);
    }
}

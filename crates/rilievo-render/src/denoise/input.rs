//! What the filter reads, pixel by pixel.

use super::DenoiseError;
use crate::film::{Aov, Film};

/// Albedo below which light is not divided by it: black, or no surface.
const DARK: f32 = 0.02;

/// Least square of a feature's slope: differences below its root are no edge.
const FLAT: f32 = 1e-3;

/// How far features may differ, in slopes: the paper's `k_f`, squared.
const FEATURE_SCALE: f32 = 0.6 * 0.6;

/// A pixel as the filter sees it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Pixel {
    /// Light divided by `albedo`.
    pub light: [f32; 3],
    /// Variance of `light`.
    pub variance: [f32; 3],
    /// What light is multiplied by again.
    pub factor: [f32; 3],
    pub albedo: [f32; 3],
    pub normal: [f32; 3],
    /// What squared differences of albedo and of normal are multiplied by.
    pub steepness: [f32; 2],
    /// Whether all its samples were taken.
    pub finished: bool,
}

/// A film made ready.
pub(super) struct Input {
    pub size: [usize; 2],
    pub pixels: Vec<Pixel>,
}

impl Input {
    pub fn new(film: &Film) -> Result<Self, DenoiseError> {
        let [width, height] = film.resolution();
        let guide = |aov| film.layer(aov).ok_or(DenoiseError::NoGuide(aov));
        let (albedo, normal) = (guide(Aov::Albedo)?.values(), guide(Aov::Ns)?.values());
        let mut pixels = Vec::new();
        let count = film.radiance().len();
        let memory = |_| DenoiseError::Memory { size: [width, height] };
        pixels.try_reserve_exact(count).map_err(memory)?;
        let triple = |values: &[f32], at: usize| [0, 1, 2].map(|c| values[3 * at + c]);
        for (at, (&radiance, &finished)) in film.radiance().iter().zip(film.finished()).enumerate()
        {
            let albedo = triple(albedo, at);
            let factor = albedo.map(|a| if a > DARK { a } else { 1.0 });
            let light = [0, 1, 2].map(|c| radiance[c] / factor[c]);
            let normal = triple(normal, at);
            // A pixel that is no number spoils itself only.
            let finished = finished && radiance.iter().all(|c| c.is_finite());
            pixels.push(Pixel { light, factor, albedo, normal, finished, ..Pixel::default() });
        }
        let mut input = Self { size: [width as usize, height as usize], pixels };
        input.find_edges();
        let variances = input.sampled(film).unwrap_or_else(|| input.spread());
        input.set_variances(&variances);
        Ok(input)
    }

    /// The pixel at a place, or the nearest one of the image.
    #[inline]
    pub fn at(&self, x: isize, y: isize) -> &Pixel {
        let [x, y] = [(x, self.size[0]), (y, self.size[1])]
            .map(|(at, size)| at.clamp(0, size as isize - 1) as usize);
        &self.pixels[y * self.size[0] + x]
    }

    /// Sets how fast features change around each pixel.
    fn find_edges(&mut self) {
        let width = self.size[0];
        for at in 0..self.pixels.len() {
            let (x, y) = ((at % width) as isize, (at / width) as isize);
            let slope = |of: fn(&Pixel) -> [f32; 3]| {
                let here = of(self.at(x, y));
                // Of both sides the gentler slope: beside an edge it is that of the surface.
                let along = |dx: isize, dy: isize| {
                    let sides = [of(self.at(x - dx, y - dy)), of(self.at(x + dx, y + dy))];
                    let [a, b] = sides.map(|side| square_distance(here, side));
                    a.min(b)
                };
                (along(1, 0) + along(0, 1)).max(FLAT)
            };
            let slopes = [slope(|p| p.albedo), slope(|p| p.normal)];
            self.pixels[at].steepness = slopes.map(|slope| 1.0 / (FEATURE_SCALE * slope));
        }
    }

    /// How far features of two pixels differ, as the paper's exponents: the larger.
    #[inline]
    pub fn feature_distance(p: &Pixel, q: &Pixel) -> f32 {
        let albedo = square_distance(p.albedo, q.albedo) * p.steepness[0];
        let normal = square_distance(p.normal, q.normal) * p.steepness[1];
        albedo.max(normal)
    }

    /// Variances of the mean channel, from the samples of each pixel; `None` if the film does not know
    /// them, or took one sample of a pixel only.
    fn sampled(&self, film: &Film) -> Option<Vec<f32>> {
        let sums = film.sums()?;
        let variance = |at: usize| sums.estimate(at).1.map(|error| (error * error) as f32);
        (0..self.pixels.len()).map(variance).collect()
    }

    /// Variances of the mean channel, estimated from the differences of each pixel to the mean of its
    /// neighbours on the same surface.
    fn spread(&self) -> Vec<f32> {
        let width = self.size[0];
        let neighbours = |at: usize, radius: isize| {
            let (x, y) = ((at % width) as isize, (at / width) as isize);
            let side = -radius..=radius;
            side.clone().flat_map(move |dy| side.clone().map(move |dx| (x + dx, y + dy)))
        };
        let residuals: Vec<f32> = (0..self.pixels.len())
            .map(|at| {
                let (here, mut sum, mut weights, mut squares) = (&self.pixels[at], 0.0, 0.0, 0.0);
                for (x, y) in neighbours(at, 1) {
                    let other = self.at(x, y);
                    let weight = (-Self::feature_distance(here, other)).exp();
                    sum += weight * mean(other.light);
                    squares += weight * weight;
                    weights += weight;
                }
                // Of independent values the difference to a mean they are part of is smaller.
                let share = 1.0 - 2.0 / weights + squares / (weights * weights);
                let residual = mean(here.light) - sum / weights;
                if share > 0.1 { residual * residual / share } else { 0.0 }
            })
            .collect();
        let smooth = |at: usize| {
            let (mut sum, mut weights) = (0.0, 0.0);
            for (x, y) in neighbours(at, 3) {
                let inside = [(x, self.size[0]), (y, self.size[1])]
                    .iter()
                    .all(|&(at, size)| (0..size as isize).contains(&at));
                if inside {
                    let other = y as usize * width + x as usize;
                    let weight =
                        (-Self::feature_distance(&self.pixels[at], &self.pixels[other])).exp();
                    sum += weight * residuals[other];
                    weights += weight;
                }
            }
            // `light` has been divided by the factor, variances have not.
            sum / weights * mean(self.pixels[at].factor).powi(2)
        };
        (0..self.pixels.len()).map(smooth).collect()
    }

    /// Sets the variances of the channels from those of the mean channel, which count as noise of
    /// the colour around the pixel.
    fn set_variances(&mut self, variances: &[f32]) {
        let [width, height] = self.size;
        for at in 0..self.pixels.len() {
            let (x, y) = (at % width, at / width);
            let (mut variance, mut colour, mut count) = (0.0, [0.0; 3], 0.0);
            for y in y.saturating_sub(1)..height.min(y + 2) {
                for x in x.saturating_sub(1)..width.min(x + 2) {
                    let other = &self.pixels[y * width + x];
                    variance += variances[y * width + x];
                    count += 1.0;
                    colour = [0, 1, 2].map(|c| colour[c] + other.light[c] * other.factor[c]);
                }
            }
            let variance = variances[at].max(variance / count);
            let grey = mean(colour);
            let pixel = &mut self.pixels[at];
            pixel.variance = [0, 1, 2].map(|c| {
                let tint = if grey > 0.0 { (colour[c] / grey).clamp(0.1, 3.0) } else { 1.0 };
                variance * (tint / pixel.factor[c]).powi(2)
            });
        }
    }
}

pub(super) fn mean(rgb: [f32; 3]) -> f32 {
    (rgb[0] + rgb[1] + rgb[2]) / 3.0
}

fn square_distance(a: [f32; 3], b: [f32; 3]) -> f32 {
    (0..3).map(|c| (a[c] - b[c]) * (a[c] - b[c])).sum()
}

//! [`Environment`]: light from all around, an image of the sphere of directions.
//!
//! The image is equirectangular, seen from inside: its middle lies towards +x of its own frame, its
//! right half towards -y, its top towards +z, as Cycles has it. Texels sit at their centres and are
//! mixed bilinearly; rows end at the poles, columns close.
//!
//! Directions are drawn by the light: a cell of the grid in proportion to its solid angle and the
//! luminance that the mixed texels have over it on average, then uniformly by solid angle within the
//! cell. So the density is constant over a cell, and above 0 wherever the image is. Large images are
//! gathered to at most [`CELLS`] cells.

use std::f64::consts::{FRAC_1_PI, PI, TAU};

use glam::{DMat3, DVec2, DVec3};

use super::LightSample;
use super::distribution::Distribution;
use crate::colour::{Rgb, is_radiance};
use crate::texture::ColourImage;

/// Most cells of the grid that directions are drawn from.
const CELLS: usize = 1 << 22;

/// The axis that the top of an environment's image points to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Up {
    /// +y; the middle of the image lies towards +x, its right half towards +z.
    Y,
    /// +z; the middle of the image lies towards +x, its right half towards -y.
    #[default]
    Z,
}

/// How an environment's image is laid around the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EnvironmentPlacement {
    /// Radiance of a texel of 1, W/(sr m^2), by channel.
    pub scale: Rgb,
    /// Turn about the up axis, degrees, counter-clockwise seen from above.
    pub rotate: f64,
    /// Where the top of the image points to.
    pub up: Up,
}

impl Default for EnvironmentPlacement {
    fn default() -> Self {
        Self { scale: Rgb::ONE, rotate: 0.0, up: Up::Z }
    }
}

/// Light from all around.
#[derive(Clone, Debug, PartialEq)]
pub struct Environment {
    pub(super) width: usize,
    pub(super) height: usize,
    /// Radiance, row 0 at the bottom.
    pub(super) texels: Vec<[f32; 3]>,
    pub(super) world_from_image: DMat3,
    image_from_world: DMat3,
    /// Texels along a side of a cell.
    pub(super) side: usize,
    /// Nothing where the image is black.
    pub(super) cells: Option<Distribution>,
}

impl Environment {
    /// Lays an image around the scene. Nothing where `scale` is no colour or `rotate` not finite.
    pub fn new(image: &ColourImage, placement: EnvironmentPlacement) -> Option<Self> {
        if !(is_radiance(placement.scale) && placement.rotate.is_finite()) {
            return None;
        }
        let (width, height) = (image.width(), image.height());
        let mut texels = Vec::with_capacity(width as usize * height as usize);
        for j in 0..height {
            for i in 0..width {
                let radiance = image.texel(i, j) * placement.scale;
                texels.push(radiance.to_array().map(|c| c.min(f64::from(f32::MAX)) as f32));
            }
        }
        let turned = DMat3::from_rotation_z(placement.rotate.to_radians());
        let world_from_image = match placement.up {
            Up::Z => turned,
            Up::Y => DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::Y) * turned,
        };
        let mut environment = Self {
            width: width as usize,
            height: height as usize,
            texels,
            world_from_image,
            image_from_world: world_from_image.transpose(),
            side: 1,
            cells: None,
        };
        environment.distribute();
        Some(environment)
    }

    /// Bytes held.
    pub fn bytes(&self) -> u64 {
        size_of_val(self.texels.as_slice()) as u64
            + self.cells.as_ref().map_or(0, Distribution::bytes)
    }

    /// Whether directions can be drawn: the image is not black.
    pub(super) fn shines(&self) -> bool {
        self.cells.is_some()
    }

    /// Radiance that comes against a unit `direction`, W/(sr m^2).
    pub fn radiance(&self, direction: DVec3) -> Rgb {
        self.mixed(place(self.image_from_world * direction))
    }

    /// Radiance that comes against a unit `direction`, and the density of [`Self::sample`] there, per
    /// steradian.
    pub(super) fn seen(&self, direction: DVec3) -> (Rgb, f64) {
        let at = place(self.image_from_world * direction);
        let Some(cells) = &self.cells else { return (Rgb::ZERO, 0.0) };
        let cell =
            |at: f64, texels: usize| ((at * texels as f64) as usize).min(texels - 1) / self.side;
        let cell = [cell(at.x, self.width), cell(at.y, self.height)];
        (self.mixed(at), cells.share(cell) / self.solid_angle(cell))
    }

    /// A direction for `u` in `[0, 1)^2`.
    pub(super) fn sample(&self, point: DVec3, u: DVec2) -> Option<LightSample> {
        let (cell, within, share) = self.cells.as_ref()?.sample(u);
        let [x, z] = [self.columns(cell[0]), self.heights(cell[1])];
        let along = x[0] + within.x * (x[1] - x[0]);
        let height = z[0] + within.y * (z[1] - z[0]);
        let (sin, cos) = (TAU * (along - 0.5)).sin_cos();
        let level = (1.0 - height * height).max(0.0).sqrt();
        let direction = self.world_from_image * DVec3::new(level * cos, -level * sin, height);
        let radiance = self.mixed(DVec2::new(along, latitude(height)));
        let pdf = share / self.solid_angle(cell);
        Some(LightSample {
            position: point + direction,
            direction,
            weight: radiance / pdf,
            pdf,
            clear: f64::INFINITY,
        })
    }

    /// The part of the turn that a column of cells spans.
    fn columns(&self, column: usize) -> [f64; 2] {
        let width = self.width as f64;
        let first = column * self.side;
        [first as f64 / width, (first + self.side).min(self.width) as f64 / width]
    }

    /// z of the lower and the upper edge of a row of cells.
    pub(super) fn heights(&self, row: usize) -> [f64; 2] {
        let first = row * self.side;
        let edge = |texels: usize| -(PI * texels as f64 / self.height as f64).cos();
        [edge(first), edge((first + self.side).min(self.height))]
    }

    /// Solid angle of a cell, steradian.
    fn solid_angle(&self, cell: [usize; 2]) -> f64 {
        let ([x0, x1], [z0, z1]) = (self.columns(cell[0]), self.heights(cell[1]));
        TAU * (x1 - x0) * (z1 - z0)
    }

    /// Makes the grid of cells.
    fn distribute(&mut self) {
        let gathered = |side: usize| self.width.div_ceil(side) * self.height.div_ceil(side);
        while gathered(self.side) > CELLS {
            self.side *= 2;
        }
        let columns = self.width.div_ceil(self.side);
        let mut weights = vec![0.0; gathered(self.side)];
        for j in 0..self.height {
            let row = j as f64 / self.height as f64;
            let next = (j + 1) as f64 / self.height as f64;
            let solid_angle = TAU / self.width as f64 * ((PI * row).cos() - (PI * next).cos());
            for i in 0..self.width {
                weights[j / self.side * columns + i / self.side] +=
                    self.mean_luminance(i, j) * solid_angle;
            }
        }
        self.cells = Distribution::new(columns, &weights);
    }

    /// Luminance of the mixed texels, on average over one.
    fn mean_luminance(&self, i: usize, j: usize) -> f64 {
        let columns = [(i + self.width - 1) % self.width, i, (i + 1) % self.width];
        let rows = [j.saturating_sub(1), j, (j + 1).min(self.height - 1)];
        let share = [0.125, 0.75, 0.125];
        let mut sum = 0.0;
        for (row, a) in rows.into_iter().zip(share) {
            for (column, b) in columns.into_iter().zip(share) {
                sum += a * b * super::luminance(self.texel(column, row));
            }
        }
        sum
    }

    fn texel(&self, i: usize, j: usize) -> Rgb {
        Rgb::from_array(self.texels[j * self.width + i].map(f64::from))
    }

    /// The texels around a place of the image, mixed.
    fn mixed(&self, at: DVec2) -> Rgb {
        let x = at.x * self.width as f64 - 0.5;
        let y = (at.y * self.height as f64 - 0.5).clamp(0.0, (self.height - 1) as f64);
        let (left, low) = (x.floor(), y.floor());
        let i = if left < 0.0 { self.width - 1 } else { (left as usize).min(self.width - 1) };
        let next = if i + 1 == self.width { 0 } else { i + 1 };
        let j = low as usize;
        let above = (j + 1).min(self.height - 1);
        let (s, t) = (x - left, y - low);
        let lower = self.texel(i, j).lerp(self.texel(next, j), s);
        lower.lerp(self.texel(i, above).lerp(self.texel(next, above), s), t)
    }
}

/// The place of a unit direction in the image: (0, 0) is its lower left corner.
fn place(direction: DVec3) -> DVec2 {
    let turn = 0.5 - 0.5 * FRAC_1_PI * direction.y.atan2(direction.x);
    DVec2::new(turn.clamp(0.0, 1.0), latitude(direction.z))
}

/// The place between the poles, 0 at -z.
fn latitude(z: f64) -> f64 {
    1.0 - FRAC_1_PI * z.clamp(-1.0, 1.0).acos()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::chi_square::{check_directions, independent_points};
    use crate::texture::Texels;

    fn image(width: u32, height: u32, texel: impl Fn(u32, u32) -> [f32; 3]) -> ColourImage {
        let places = (0..height).flat_map(|j| (0..width).map(move |i| (i, j)));
        let texels = places.map(|(i, j)| texel(i, j)).collect();
        ColourImage::new(width, height, Texels::Linear(texels)).unwrap()
    }

    #[test]
    fn the_image_is_seen_from_inside() {
        // Left to right: red, green, blue, white; below the horizon black.
        let colours = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 1.0, 1.0]];
        let quarter = image(4, 2, |i, j| if j == 0 { [0.0; 3] } else { colours[i as usize] });
        let laid = |placement| Environment::new(&quarter, placement).unwrap();
        let plain = laid(EnvironmentPlacement::default());
        // The middle of the second column lies to the left of +x, 45 degrees towards +y.
        let at = |e: &Environment, x: f64, y: f64, z: f64| {
            e.radiance(DVec3::new(x, y, z).normalize()).to_array()
        };
        let high = 1e3;
        assert_eq!(at(&plain, 1.0, 1.0, high).map(|c| (c * 10.0).round()), [0.0, 10.0, 0.0]);
        assert_eq!(at(&plain, 1.0, -1.0, high).map(|c| (c * 10.0).round()), [0.0, 0.0, 10.0]);
        assert_eq!(at(&plain, 1.0, 0.0, -high), [0.0; 3]);
        let turned = laid(EnvironmentPlacement { rotate: 90.0, ..Default::default() });
        assert_eq!(at(&turned, -1.0, 1.0, high).map(|c| (c * 10.0).round()), [0.0, 10.0, 0.0]);
        let y_up = laid(EnvironmentPlacement { up: Up::Y, scale: Rgb::splat(2.0), rotate: 0.0 });
        // Right of the middle lies +z.
        assert_eq!(at(&y_up, 1.0, high, 1.0).map(|c| (c * 10.0).round()), [0.0, 0.0, 20.0]);
        assert_eq!(at(&y_up, 1.0, -high, 1.0), [0.0; 3]);
    }

    #[test]
    fn directions_follow_their_density() {
        // Cells of the test of directions are 18 degrees wide; so are these texels.
        let spot = image(20, 10, |i, j| [((i * 7 + j * 13) % 11) as f32, 1.0, 0.0]);
        let dark = image(20, 10, |i, j| if (i, j) == (3, 8) { [9.0; 3] } else { [0.0; 3] });
        let large = image(4096, 2048, |i, j| [(i / 512 + j / 256) as f32; 3]);
        for (name, image) in [("spots", spot), ("one texel", dark), ("gathered", large)] {
            let environment = Environment::new(&image, EnvironmentPlacement::default()).unwrap();
            let sample = |u| environment.sample(DVec3::ZERO, u).unwrap();
            check_directions(name, |u| sample(u).direction, |d| environment.seen(d).1);
            for u in independent_points(2000) {
                let sample = sample(u);
                let (radiance, pdf) = environment.seen(sample.direction);
                assert!((pdf / sample.pdf - 1.0).abs() < 1e-9, "{name}");
                let weight = radiance / pdf;
                assert!((weight - sample.weight).length() <= 1e-6 * (1.0 + weight.length()));
            }
        }
        let black = image(4, 2, |_, _| [0.0; 3]);
        let black = Environment::new(&black, EnvironmentPlacement::default()).unwrap();
        assert!(!black.shines() && black.sample(DVec3::ZERO, DVec2::ZERO).is_none());
    }
}

//! What a material sends out over the uv square: how much on average, and where.
//!
//! An image is gathered to a grid of at most [`SIDE`] cells along u and v, each by the luminance of the
//! image's mean over it. A share [`EVEN`] is spread evenly: the mean over a cell may be dark where the
//! image is not.

use glam::DVec2;

use super::distribution::Distribution;
use super::luminance;
use crate::scene::Material;
use crate::texture::Footprint;

/// Most cells along u and v.
const SIDE: u32 = 256;

/// The share of the points that is spread evenly.
const EVEN: f64 = 0.05;

/// Places in the uv square, drawn by the light that is sent out from there.
#[derive(Clone, Debug)]
pub(super) struct EmissionTable {
    /// Cells along u and v.
    pub(super) size: [usize; 2],
    pub(super) cells: Distribution,
}

impl EmissionTable {
    /// Luminance sent out on average over the uv square, and the table if it differs from place to place;
    /// nothing where it is dark.
    pub fn of(material: &Material) -> Option<(f64, Option<Self>)> {
        let Some(texture) = &material.emission else {
            let even = luminance(material.emitted);
            return (even > 0.0).then_some((even, None));
        };
        let cells = |texels: u32, tile: f64| {
            let texels = (f64::from(texels) * tile.abs()).min(f64::from(SIDE));
            (texels as u32).max(1)
        };
        let (image, tile) = (&texture.image, texture.tile);
        // A turn may exchange the axes.
        let turned = texture.turn.y.abs() > texture.turn.x.abs();
        let [w, h] = [image.width(), image.height()];
        let [w, h] = if turned { [h, w] } else { [w, h] };
        let [columns, rows] = [cells(w, tile.x), cells(h, tile.y)];
        let width = DVec2::new(f64::from(columns), f64::from(rows)).recip();
        let places = (0..rows).flat_map(|j| (0..columns).map(move |i| [i, j]));
        let mut weights: Vec<f64> = places
            .map(|[i, j]| {
                let uv = (DVec2::new(f64::from(i), f64::from(j)) + 0.5) * width;
                luminance(
                    material.emitted * texture.mean(&Footprint { width, ..Footprint::point(uv) }),
                )
            })
            .collect();
        let mean = weights.iter().sum::<f64>() / weights.len() as f64;
        if !(mean > 0.0 && mean.is_finite()) {
            return None;
        }
        weights.iter_mut().for_each(|weight| *weight += EVEN * mean);
        let cells = Distribution::new(columns as usize, &weights)?;
        Some((mean, Some(Self { size: [columns as usize, rows as usize], cells })))
    }

    /// A place for `u` in `[0, 1)^2`.
    pub fn sample(&self, u: DVec2) -> DVec2 {
        let ([i, j], within, _) = self.cells.sample(u);
        let [columns, rows] = self.size.map(|n| n as f64);
        (DVec2::new(i as f64, j as f64) + within) / DVec2::new(columns, rows)
    }

    /// Density of [`Self::sample`] over the uv square.
    pub fn pdf(&self, uv: DVec2) -> f64 {
        let [columns, rows] = self.size;
        let cell = |x: f64, n: usize| ((x * n as f64) as usize).min(n - 1);
        self.cells.share([cell(uv.x, columns), cell(uv.y, rows)]) * (columns * rows) as f64
    }

    /// Bytes held.
    pub fn bytes(&self) -> u64 {
        self.cells.bytes()
    }
}

/// Luminance that a material sends out on average over a triangle of the uv square.
pub(super) fn luminance_over(material: &Material, [a, b, c]: [DVec2; 3]) -> f64 {
    let Some(texture) = &material.emission else { return luminance(material.emitted) };
    let width = a.max(b).max(c) - a.min(b).min(c);
    luminance(
        material.emitted
            * texture.mean(&Footprint { width, ..Footprint::point((a + b + c) / 3.0) }),
    )
}

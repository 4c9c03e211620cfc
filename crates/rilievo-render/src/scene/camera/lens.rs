//! [`Lens`]: a thin lens with an aperture, round or of straight blades.

use std::f64::consts::{PI, TAU};

use glam::DVec2;

use super::CameraError;

/// A thin lens: what lies at its focus distance is sharp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lens {
    /// From the middle of the opening to its border, or to its corners; scene units.
    pub radius: f64,
    /// Depth, along the view axis, of what is sharp; scene units.
    pub focus_distance: f64,
    /// Straight sides of the opening: 3 to [`Self::MAX_BLADES`], or 0 for a round one.
    pub blades: u32,
    /// Turns the opening, seen from behind, counter-clockwise; radians. At 0 a corner is to the right.
    pub rotation: f64,
}

impl Lens {
    /// Most sides of an opening.
    pub const MAX_BLADES: u32 = 64;

    pub(super) fn check(&self) -> Result<(), CameraError> {
        let Self { radius, focus_distance, blades, rotation } = *self;
        let sharp = focus_distance.is_finite() && focus_distance > 0.0;
        if !(radius.is_finite() && radius >= 0.0 && sharp && rotation.is_finite()) {
            return Err(CameraError::Lens);
        }
        if blades != 0 && !(3..=Self::MAX_BLADES).contains(&blades) {
            return Err(CameraError::Blades { found: blades });
        }
        Ok(())
    }

    /// A point of the opening, x to the right and y up, uniform for `u` uniform in `[0, 1)^2`; its
    /// middle for (1/2, 1/2).
    pub(super) fn point(&self, u: DVec2) -> DVec2 {
        let place = if self.blades == 0 { disk(u) } else { polygon(self.blades, u) };
        DVec2::from_angle(self.rotation).rotate(place) * self.radius
    }
}

/// The unit disk by concentric squares \[Shirley1997\].
fn disk(u: DVec2) -> DVec2 {
    let v = 2.0 * u - 1.0;
    if v == DVec2::ZERO {
        return v;
    }
    let (r, angle) = if v.x.abs() > v.y.abs() {
        (v.x, 0.25 * PI * v.y / v.x)
    } else {
        (v.y, 0.5 * PI - 0.25 * PI * v.x / v.y)
    };
    r * DVec2::from_angle(angle)
}

/// The regular polygon with corners on the unit circle: the disk's point decides for the sector and,
/// by its radius, how far out; within the sector the place along the side is as the angle's. Areas
/// stay in proportion, and so do strata.
fn polygon(sides: u32, u: DVec2) -> DVec2 {
    let place = disk(u);
    let r = place.length();
    if r == 0.0 {
        return place;
    }
    let turn = place.y.atan2(place.x).rem_euclid(TAU) / TAU * f64::from(sides);
    let sector = turn.floor();
    let corner = |k: f64| DVec2::from_angle(TAU * k / f64::from(sides));
    r * corner(sector).lerp(corner(sector + 1.0), turn - sector)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::chi_square::{chi_square_z, independent_points};

    #[test]
    fn points_are_uniform_over_the_opening() {
        const CELLS: usize = 24;
        const SAMPLES: u32 = 200_000;
        for (blades, rotation) in [(0, 0.0), (3, 0.2), (5, 0.0), (8, 1.0)] {
            let lens = Lens { radius: 2.0, focus_distance: 1.0, blades, rotation };
            let cell = |p: DVec2| {
                let place = (p / lens.radius + 1.0) * 0.5 * CELLS as f64;
                let [x, y] = place.to_array().map(|x| (x as usize).min(CELLS - 1));
                y * CELLS + x
            };
            let mut observed = vec![0.0; CELLS * CELLS];
            for u in independent_points(SAMPLES) {
                observed[cell(lens.point(u))] += 1.0;
            }
            // Inside: on the inner side of every side of the polygon.
            let inside = |p: DVec2| {
                if blades == 0 {
                    return p.length() <= lens.radius;
                }
                let half = PI / f64::from(blades);
                (0..blades).all(|k| {
                    let middle = DVec2::from_angle(rotation + half * f64::from(2 * k + 1));
                    p.dot(middle) <= lens.radius * half.cos()
                })
            };
            let fine = 24 * CELLS;
            let mut expected = vec![0.0; CELLS * CELLS];
            for at in 0..fine * fine {
                let p = DVec2::new((at % fine) as f64 + 0.5, (at / fine) as f64 + 0.5);
                let p = (p / fine as f64 * 2.0 - 1.0) * lens.radius;
                expected[cell(p)] += f64::from(u8::from(inside(p)));
            }
            let total: f64 = expected.iter().sum();
            expected.iter_mut().for_each(|cell| *cell *= f64::from(SAMPLES) / total);
            // Cells that the border cuts are known to a percent only; they are few.
            let whole = expected.iter().fold(0.0_f64, |a, &b| a.max(b));
            let keep = |values: &[f64]| -> Vec<f64> {
                let inner = values.iter().zip(&expected).filter(|(_, e)| **e > 0.999 * whole);
                inner.map(|(v, _)| *v).collect()
            };
            let z = chi_square_z(&keep(&observed), &keep(&expected));
            assert!(z < 4.0, "{blades}: {z}");
            let outside: f64 =
                observed.iter().zip(&expected).filter(|(_, e)| **e == 0.0).map(|(o, _)| o).sum();
            assert!(outside < 1e-3 * f64::from(SAMPLES), "{blades}: {outside}");
            assert_eq!(lens.point(DVec2::splat(0.5)), DVec2::ZERO);
        }
    }
}

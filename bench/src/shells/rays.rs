//! The rays of `shells`.
//!
//! | family | rays |
//! |---|---|
//! | primary | one through each pixel of an image that shows the whole mesh from aside and above |
//! | shadow | from each primary hit to a random point of a light above; any hit |
//! | diffuse | from each primary hit, cosine-distributed about the normal |
//! | grazing | within 0.02 rad of the surface at a primary hit, from up to 0.3 of the size before it |
//! | inside | in random directions from just under each primary hit |
//!
//! Origins of secondary rays keep a distance of 1e-4 of the size from the surface.

use std::f64::consts::TAU;

use clap::ValueEnum;
use glam::DVec3;
use rilievo::relief::ReliefMesh;
use rilievo::{Hit, Ray};

use super::rounded;
use crate::random::unit;
use crate::rays::Ray32;

/// A kind of ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ShellFamily {
    Primary,
    Shadow,
    Diffuse,
    Grazing,
    Inside,
}

impl ShellFamily {
    pub const ALL: [Self; 5] =
        [Self::Primary, Self::Shadow, Self::Diffuse, Self::Grazing, Self::Inside];

    pub fn name(self) -> &'static str {
        match self {
            Self::Primary => "primary",
            Self::Shadow => "shadow",
            Self::Diffuse => "diffuse",
            Self::Grazing => "grazing",
            Self::Inside => "inside",
        }
    }

    /// Whether any hit will do.
    pub fn is_any_hit(self) -> bool {
        self == Self::Shadow
    }
}

/// The rays of a family, from an image of `side` x `side` pixels.
pub fn rays(shell: &ReliefMesh, family: ShellFamily, side: u32) -> Vec<Ray32> {
    let bounds = shell.bounds();
    let (centre, size) = (0.5 * (bounds.min + bounds.max), (bounds.max - bounds.min).length());
    let eye = centre + 1.5 * size * DVec3::new(0.55, 0.6, 0.58).normalize();
    let forward = (centre - eye).normalize();
    let right = forward.cross(DVec3::Z).normalize();
    let up = right.cross(forward);
    let mut all = Vec::new();
    for y in 0..side {
        for x in 0..side {
            let at = [x, y].map(|k| 0.62 * ((f64::from(k) + 0.5) / f64::from(side) - 0.5));
            let direction = forward + at[0] * right - at[1] * up;
            let ray = Ray::new(eye, direction);
            if family == ShellFamily::Primary {
                all.push(rounded(eye, direction, f64::INFINITY));
            } else if let Some(hit) = shell.closest(&ray, &mut ()) {
                let number = u64::from(y * side + x);
                all.push(secondary(&hit, family, (centre, size), number));
            }
        }
    }
    all
}

/// A ray from a primary hit.
fn secondary(hit: &Hit, family: ShellFamily, (centre, size): (DVec3, f64), number: u64) -> Ray32 {
    let random = |draw: u32| unit(number, draw);
    let normal = hit.geometric_normal;
    let above = hit.position + 1e-4 * size * normal;
    let (a, b) = normal.any_orthonormal_pair();
    let (sin, cos) = (TAU * random(0)).sin_cos();
    let tangent = cos * a + sin * b;
    match family {
        ShellFamily::Primary | ShellFamily::Shadow => {
            let aside = DVec3::new(random(1) - 0.5, random(2) - 0.5, random(3) - 0.5);
            let light = centre + size * (DVec3::new(1.0, -1.5, 3.0) + aside);
            rounded(above, light - above, 1.0)
        }
        ShellFamily::Diffuse => {
            let r = random(1).sqrt();
            let direction = r * tangent + (1.0 - r * r).sqrt() * normal;
            rounded(above, direction, f64::INFINITY)
        }
        ShellFamily::Grazing => {
            let direction = tangent + 0.02 * (random(1) - 0.8) * normal;
            rounded(above - 0.3 * size * random(2) * direction, direction, f64::INFINITY)
        }
        ShellFamily::Inside => {
            let z = 2.0 * random(1) - 1.0;
            let direction = (1.0 - z * z).sqrt() * tangent + z * normal;
            rounded(hit.position - 1e-4 * size * normal, direction, f64::INFINITY)
        }
    }
}

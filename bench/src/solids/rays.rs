//! The rays of a body: made once, on rilievo's surface, traced by everyone.
//!
//! | family | rays |
//! |---|---|
//! | primary | one through the centre of each pixel of an image of the whole body |
//! | shadow | from each primary hit to a point light aside |
//! | diffuse | from each primary hit in a random direction, cosine-distributed about the normal |
//! | grazing | past each primary hit within 0.02 rad of the surface, from up to 0.3 sizes before |
//! | inside | from just below each primary hit in any direction |
//!
//! Starts are off the surface by 10^-4 of the size, more than what cells and triangles differ by at
//! most places, so that no contender meets its own start.

use clap::ValueEnum;
use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::body::Displaced;
use crate::random::unit;
use crate::rays::{Ray32, widened};

/// A kind of ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum SolidFamily {
    Primary,
    Shadow,
    Diffuse,
    Grazing,
    Inside,
}

impl SolidFamily {
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

    /// Whether only the existence of a hit is asked for.
    pub fn is_any_hit(self) -> bool {
        self == Self::Shadow
    }
}

/// Where primary rays hit.
struct Start {
    at: DVec3,
    normal: DVec3,
    along: DVec3,
}

/// How far starts are off the surface, in sizes.
const CLEARANCE: f64 = 1e-4;

/// The rays of every family, `side` x `side` primary ones.
pub fn rays(body: &Displaced, side: u32) -> Vec<(SolidFamily, Vec<Ray32>)> {
    let primary = image(body, side);
    let starts: Vec<Start> = primary.iter().filter_map(|ray| start(body, ray)).collect();
    let off = CLEARANCE * body.size;
    let numbered = || (0u64..).zip(&starts);
    let from = |at: DVec3, direction: DVec3, t_max: f32| Ray32 {
        origin: at.as_vec3().to_array(),
        direction: direction.as_vec3().to_array(),
        t_max,
    };
    let bounds = body.surface.bounds();
    let light = bounds.centre() + body.size * DVec3::new(1.5, 1.0, 2.0);
    let shadow = |s: &Start| {
        let at = s.at + off * s.normal;
        from(at, light - at, 1.0)
    };
    let diffuse = |id: u64, s: &Start| {
        let to = (s.normal + ball(id, 0)).try_normalize().unwrap_or(s.normal);
        from(s.at + off * s.normal, to, f32::INFINITY)
    };
    let grazing = |id: u64, s: &Start| {
        let side = s.normal.cross(ball(id, 2)).try_normalize().unwrap_or(s.along);
        let to = (side + 0.02 * (2.0 * unit(id, 4) - 1.0) * s.normal).normalize();
        let back = 0.3 * body.size * unit(id, 5);
        from(s.at + off * s.normal - back * to, to, f32::INFINITY)
    };
    let inside =
        |id: u64, s: &Start| from(s.at - 10.0 * off * s.normal, ball(id, 6), f32::INFINITY);
    vec![
        (SolidFamily::Shadow, starts.iter().map(shadow).collect()),
        (SolidFamily::Diffuse, numbered().map(|(id, s)| diffuse(id, s)).collect()),
        (SolidFamily::Grazing, numbered().map(|(id, s)| grazing(id, s)).collect()),
        (SolidFamily::Inside, numbered().map(|(id, s)| inside(id, s)).collect()),
        (SolidFamily::Primary, primary),
    ]
}

fn start(body: &Displaced, ray: &Ray32) -> Option<Start> {
    let ray = widened(ray);
    let hit = body.surface.closest(&ray, &mut ())?;
    let normal = if hit.front { hit.geometric_normal } else { -hit.geometric_normal };
    Some(Start { at: hit.position, normal, along: hit.geometric_normal.any_orthonormal_vector() })
}

/// An image from aside and above that shows the whole body.
fn image(body: &Displaced, side: u32) -> Vec<Ray32> {
    let bounds = body.surface.bounds();
    let (centre, reach) = (bounds.centre(), 0.5 * (bounds.max - bounds.min).length());
    let back = DVec3::new(0.5, -1.0, 0.6).normalize();
    let eye = centre + 3.0 * reach * back;
    let right = DVec3::Z.cross(back).normalize();
    let up = back.cross(right);
    // The sphere around the box fills the image.
    let half = 1.0 / 8f64.sqrt();
    let at = |k: u32| (2.0 * (f64::from(k) + 0.5) / f64::from(side) - 1.0) * half;
    (0..side)
        .flat_map(|y| (0..side).map(move |x| (x, y)))
        .map(|(x, y)| Ray32 {
            origin: eye.as_vec3().to_array(),
            direction: (at(x) * right - at(y) * up - back).normalize().as_vec3().to_array(),
            t_max: f32::INFINITY,
        })
        .collect()
}

/// A random unit vector.
fn ball(id: u64, draw: u32) -> DVec3 {
    let z = 1.0 - 2.0 * unit(id, draw);
    let (sin, cos) = (std::f64::consts::TAU * unit(id, draw + 1)).sin_cos();
    let r = (1.0 - z * z).max(0.0).sqrt();
    DVec3::new(r * cos, r * sin, z)
}

#[cfg(test)]
mod tests {
    use super::super::body::Body;
    use super::*;
    use crate::map::MapName;

    #[test]
    fn every_family_hits_a_plausible_share() {
        let map = MapName::Fbm.load(129).unwrap();
        for body in Body::ALL {
            let displaced = body.displaced(&map, 0.03).unwrap();
            for (family, rays) in rays(&displaced, 48) {
                let hits =
                    rays.iter().filter(|ray| displaced.surface.occludes(&widened(ray), &mut ()));
                let share = hits.count() as f64 / rays.len() as f64;
                let range = match family {
                    SolidFamily::Primary => 0.15..=0.9,
                    // A thin relief on a ball hardly sees itself.
                    SolidFamily::Shadow | SolidFamily::Diffuse => 0.0..=0.9,
                    SolidFamily::Grazing => 0.05..=1.0,
                    SolidFamily::Inside => 0.95..=1.0,
                };
                assert!(range.contains(&share), "{body:?} {}: {share}", family.name());
            }
        }
    }
}

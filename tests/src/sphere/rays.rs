//! Families of rays around a displaced sphere.

use glam::DVec3;
use rilievo::Ray;
use rilievo::map::CubeFace;

use super::SphereScene;
use crate::random::Random;

/// How a ray lies to the sphere.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Family {
    /// From a few radii away to a point of the ball.
    Primary,
    /// From very far.
    Distant,
    /// From the shell, in any direction.
    Shell,
    /// From the shell, nearly along the sphere.
    Grazing,
    /// From within, in any direction.
    Inside,
    /// To a lattice point, a point of an edge of the cube or one of its corners.
    Aimed,
    /// The same from within.
    AimedInside,
    /// A segment that ends in the shell.
    Segment,
    /// Along an axis of the cube, through or past the centre.
    Axis,
}

impl Family {
    /// All of them.
    pub const ALL: [Self; 9] = [
        Self::Primary,
        Self::Distant,
        Self::Shell,
        Self::Grazing,
        Self::Inside,
        Self::Aimed,
        Self::AimedInside,
        Self::Segment,
        Self::Axis,
    ];

    /// A ray of the family.
    pub(super) fn ray(self, scene: &SphereScene, random: &mut Random) -> Ray {
        let center = scene.center;
        let [low, high] = scene.radii();
        let shell = |random: &mut Random| {
            center + random.range(0.999 * low, 1.001 * high) * random.direction()
        };
        let away = |random: &mut Random, from: f64, to: f64| {
            center + high * random.range(from, to) * random.direction()
        };
        let within =
            |random: &mut Random| center + 0.5 * low * random.unit().cbrt() * random.direction();
        match self {
            Self::Primary => {
                let from = away(random, 1.1, 4.0);
                Ray::new(from, away(random, 0.0, 1.05) - from)
            }
            Self::Distant => {
                let from = away(random, 1e3, 1e5);
                Ray::new(from, (away(random, 0.0, 1.02) - from) * random.range(0.1, 10.0))
            }
            Self::Shell => Ray::new(shell(random), random.direction()),
            Self::Grazing => {
                let (from, direction) = (shell(random), random.direction());
                let up = (from - center).normalize();
                let along = direction.reject_from(up) + random.range(-0.05, 0.05) * up;
                Ray::new(from, along * high)
            }
            Self::Inside => Ray::new(within(random), random.direction()),
            Self::Aimed => {
                let from = away(random, 1.1, 3.0);
                Ray::new(from, lattice_point(scene, random) - from)
            }
            Self::AimedInside => {
                let from = if random.one_in(4) { center } else { within(random) };
                Ray::new(from, lattice_point(scene, random) - from)
            }
            Self::Segment => {
                let from = if random.one_in(2) { away(random, 1.1, 2.0) } else { within(random) };
                Ray::between(from, shell(random))
            }
            Self::Axis => {
                let axis = DVec3::AXES[random.integer(0, 2) as usize] * random.sign();
                let side = away(random, 0.0, 1.0) - center;
                let past = if random.one_in(3) { DVec3::ZERO } else { side.reject_from(axis) };
                Ray::new(center + past - 2.0 * high * axis, axis)
            }
        }
    }
}

/// A point of the lattice on the surface: anywhere, on an edge of the cube or at a corner.
fn lattice_point(scene: &SphereScene, random: &mut Random) -> DVec3 {
    let n = scene.heights.cells();
    let face = CubeFace::ALL[random.integer(0, 5) as usize];
    let any = |random: &mut Random| random.integer(0, n as i32) as u32;
    let end = |random: &mut Random| if random.one_in(2) { 0 } else { n };
    let at = match random.integer(0, 3) {
        0 => [end(random), end(random)],
        1 => [any(random), end(random)],
        2 => [end(random), any(random)],
        _ => [any(random), any(random)],
    };
    let map = scene.heights.face(face);
    let height = f64::from(map.raw(at[0], at[1])) * map.unit();
    let offset = scene.displacement.scale * (height - scene.displacement.zero);
    let along =
        DVec3::from_array(face.lattice_point(n, at).map(|c| 2.0 * f64::from(c) - f64::from(n)));
    // On an edge between lattice points every other time.
    let next = DVec3::from_array(
        face.lattice_point(n, [at[0], at[1].min(n - 1) + 1])
            .map(|c| 2.0 * f64::from(c) - f64::from(n)),
    );
    let along = if random.one_in(2) { along } else { along.lerp(next, random.unit()) };
    scene.center + (scene.radius + offset) * along.normalize()
}

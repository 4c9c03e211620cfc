//! The families of rays a scene is tried with.
//!
//! All are made in the scene's own frame, so that a lattice-aligned ray runs along a line of the
//! lattice whatever the face; on the unit faces the numbers are exact, elsewhere they are rounded
//! to the world's.

use glam::{DVec2, DVec3};
use rilievo::Ray;

use crate::oracle::Oracle;
use crate::random::Random;

/// A way to make rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Family {
    /// From above at a point of the slab or beside it.
    Primary,
    /// From below.
    Behind,
    /// Between two points in the slab.
    Inside,
    /// Along a world axis.
    Axis,
    /// One or two zero components, of either sign.
    Zeros,
    /// Along a line of the lattice.
    Lattice,
    /// Through a row of lattice points, diagonally.
    Diagonal,
    /// Through a sample of the surface.
    Corner,
    /// Almost along the slab.
    Grazing,
    /// In the slab at one offset.
    Horizontal,
    /// Along the displacement.
    Vertical,
    /// At a point of the surface on the very border of the face, where a ray has no stable
    /// answer: all that can be asked is that some neighbour's is given.
    Border,
}

impl Family {
    /// All of them.
    pub const ALL: [Self; 12] = [
        Self::Primary,
        Self::Behind,
        Self::Inside,
        Self::Axis,
        Self::Zeros,
        Self::Lattice,
        Self::Diagonal,
        Self::Corner,
        Self::Grazing,
        Self::Horizontal,
        Self::Vertical,
        Self::Border,
    ];

    /// A ray of this family at the scene of `oracle`.
    pub fn ray(self, oracle: &Oracle<'_>, random: &mut Random) -> Ray {
        let aim = Aim::new(oracle);
        let (origin, direction) = match self {
            Self::Primary => between(aim.outside(random, 1.0), aim.near(random)),
            Self::Behind => between(aim.outside(random, -1.0), aim.near(random)),
            Self::Inside => between(aim.within(random), aim.near(random)),
            Self::Axis => {
                let mut axis = DVec3::ZERO;
                axis[random.integer(0, 2) as usize] = random.sign();
                aim.back_off(aim.near(random), axis, random)
            }
            Self::Zeros => {
                let mut direction = random.direction();
                direction[random.integer(0, 2) as usize] = 0.0 * random.sign();
                if random.one_in(2) {
                    direction[random.integer(0, 2) as usize] = 0.0 * random.sign();
                }
                if direction == DVec3::ZERO {
                    direction.z = random.sign();
                }
                aim.back_off(aim.near(random), direction, random)
            }
            Self::Lattice => aim.along_a_line(random),
            Self::Diagonal => aim.through_points(random),
            Self::Corner => {
                let side = random.sign();
                between(aim.outside(random, side), aim.sample(random))
            }
            Self::Grazing => aim.grazing(random),
            Self::Horizontal => {
                let w = aim.offset(random);
                let mut uv = || DVec2::new(random.range(-0.5, 1.5), random.range(-0.5, 1.5));
                between(aim.world(uv(), w), aim.world(uv(), w))
            }
            Self::Border => {
                let mut uv = DVec2::new(random.unit(), random.unit());
                uv[random.integer(0, 1) as usize] = f64::from(random.integer(0, 1));
                let side = random.sign();
                let to = aim.world(uv, oracle.surface_offset(uv.x, uv.y));
                between(aim.outside(random, side), to)
            }
            Self::Vertical => {
                let uv = if random.one_in(3) {
                    aim.lattice_point(random)
                } else {
                    DVec2::new(random.range(-0.1, 1.1), random.range(-0.1, 1.1))
                };
                let (w0, w1) = (aim.offset(random), aim.offset(random));
                between(aim.world(uv, w0), aim.world(uv, w1))
            }
        };
        let mut ray = Ray::new(origin, direction);
        if ray.direction == DVec3::ZERO {
            ray.direction = oracle.normal() * aim.depth;
        }
        if random.one_in(8) {
            ray.t_max = random.range(0.5, 1.5);
        } else if random.one_in(2) {
            ray.direction = ray.direction.normalize();
        }
        ray
    }
}

/// Origin and direction of the ray from one point to another, where t = 1.
fn between(from: DVec3, to: DVec3) -> (DVec3, DVec3) {
    (from, to - from)
}

/// Where to aim at.
struct Aim<'a> {
    oracle: &'a Oracle<'a>,
    low: f64,
    high: f64,
    /// Thickness of the slab, never zero.
    depth: f64,
}

impl<'a> Aim<'a> {
    fn new(oracle: &'a Oracle<'a>) -> Self {
        let (mut low, mut high) = oracle.offsets();
        if oracle.placement().closed {
            (low, high) = (low.min(0.0), high.max(0.0));
        }
        let depth = (high - low).max(1e-3 * oracle.size());
        Self { oracle, low, high, depth }
    }

    fn world(&self, uv: DVec2, w: f64) -> DVec3 {
        self.oracle.point(uv.x, uv.y, w)
    }

    /// An offset in the slab or a little beyond.
    fn offset(&self, random: &mut Random) -> f64 {
        random.range(self.low - 0.1 * self.depth, self.high + 0.1 * self.depth)
    }

    fn within(&self, random: &mut Random) -> DVec3 {
        self.world(DVec2::new(random.unit(), random.unit()), self.offset(random))
    }

    fn near(&self, random: &mut Random) -> DVec3 {
        let uv = DVec2::new(random.range(-0.1, 1.1), random.range(-0.1, 1.1));
        self.world(uv, self.offset(random))
    }

    fn outside(&self, random: &mut Random, side: f64) -> DVec3 {
        let uv = DVec2::new(random.range(-1.0, 2.0), random.range(-1.0, 2.0));
        let away = self.oracle.size() * random.range(0.05, 2.0);
        self.world(uv, if side > 0.0 { self.high + away } else { self.low - away })
    }

    fn back_off(&self, to: DVec3, direction: DVec3, random: &mut Random) -> (DVec3, DVec3) {
        let reach = if random.one_in(4) { self.depth } else { self.oracle.size() };
        let direction = direction * (reach * random.range(0.1, 2.0));
        (to - direction, direction)
    }

    /// A point of the lattice, not on the border of the face, nor on a seam between two tiles: a
    /// ray within the plane of a wall has no stable answer, and may start on it.
    fn lattice_point(&self, random: &mut Random) -> DVec2 {
        let (low, high) = self.oracle.window();
        let (first, last) = (low.floor() + 1.0, high.ceil() - 1.0);
        let mut uv = DVec2::new(random.unit(), random.unit());
        for axis in 0..2 {
            if first[axis] <= last[axis] {
                let line = random.integer(first[axis] as i32, last[axis] as i32);
                if self.oracle.is_seam(axis, line) {
                    continue;
                }
                let line = f64::from(line);
                uv[axis] = self.oracle.uv_of_lattice(DVec2::splat(line))[axis];
            }
        }
        uv
    }

    fn sample(&self, random: &mut Random) -> DVec3 {
        let uv = self.lattice_point(random);
        self.world(uv, self.oracle.surface_offset(uv.x, uv.y))
    }

    fn along_a_line(&self, random: &mut Random) -> (DVec3, DVec3) {
        let uv = self.lattice_point(random);
        let (mut a, mut b) = (uv, uv);
        let axis = random.integer(0, 1) as usize;
        a[axis] = random.range(-0.5, 0.5);
        b[axis] = random.range(0.5, 1.5);
        if random.one_in(2) {
            (a, b) = (b, a);
        }
        between(self.world(a, self.offset(random)), self.world(b, self.offset(random)))
    }

    fn through_points(&self, random: &mut Random) -> (DVec3, DVec3) {
        let (low, high) = self.oracle.window();
        let uv = self.lattice_point(random);
        let step = DVec2::new(random.sign(), random.sign()) * f64::from(random.integer(1, 3));
        let slope = DVec2::new(1.0, f64::from(random.integer(1, 2)));
        let reach = (high - low).max_element().ceil().max(1.0);
        let per_cell =
            self.oracle.uv_of_lattice(step * slope + low) - self.oracle.uv_of_lattice(low);
        let (a, b) = (uv - per_cell * reach, uv + per_cell * reach);
        between(self.world(a, self.offset(random)), self.world(b, self.offset(random)))
    }

    fn grazing(&self, random: &mut Random) -> (DVec3, DVec3) {
        let angle = random.range(0.0, std::f64::consts::TAU);
        let away = DVec2::new(angle.cos(), angle.sin()) * random.range(0.8, 3.0);
        let target = DVec2::new(random.unit(), random.unit());
        let w = self.offset(random);
        let rise = random.sign() * self.depth * 10f64.powf(random.range(-3.0, 0.0));
        between(self.world(target + away, w + rise), self.world(target, w))
    }
}

//! [`Ray`]: what is traced, and [`Origin`]: how a ray remembers the surface it leaves.
//!
//! Points on a ray are `origin + t * direction`, in world space and scene units, all in `f64`. The
//! direction need not be a unit vector: `t` counts in its lengths. Hits are reported for
//! `0 <= t <= t_max`.
//!
//! A ray that leaves a surface carries its [`Origin`]. With it no epsilon is needed: a planar
//! primitive never meets its own ray again and is passed over; a sphere divides out the root at
//! `t = 0`; a relief lifts the start along the displacement, the one direction in which a height
//! field cannot be crossed, by the proven rounding bound of its own leaf (see `relief::leaf`).

use glam::DVec3;

use crate::map::CubeFace;

/// A half-line or a segment, in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Start, in scene units.
    pub origin: DVec3,
    /// Direction, any length but zero.
    pub direction: DVec3,
    /// Largest `t` of interest; may be infinite.
    pub t_max: f64,
    /// The surface the ray starts on, if it starts on one.
    pub from: Option<Origin>,
    /// When the ray is traced, from 0 to 1: where surfaces that move then are. Others ignore it.
    pub time: f64,
}

/// What is known of rays that are traced together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coherence {
    /// They start close together and go about the same way, like the camera rays of a pixel.
    Coherent,
    /// Anything else: shadow rays to an area light, bounces.
    Incoherent,
}

/// The place on a surface from which a ray starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Origin {
    /// Index of the surface in its [`crate::surface::World`].
    pub surface: u32,
    /// Part of that surface.
    pub part: Part,
    /// Whether the ray leaves towards the front of that part.
    pub front: bool,
}

/// A part of a surface that can be hit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Part {
    /// The whole of an undisplaced quad or sphere.
    Whole,
    /// A triangle of a mesh.
    Triangle(u32),
    /// A cell of a relief: its unfolded lattice indices.
    Cell(i32, i32),
    /// A cell of a displaced mesh: a base triangle and unfolded lattice indices.
    TriangleCell {
        /// The base triangle.
        triangle: u32,
        /// The cell of the map that it shows there.
        cell: [i32; 2],
    },
    /// A wall of a displaced mesh: its number.
    SeamWall(u32),
    /// An upright wall of a relief, on its border or on a seam between two tiles.
    Wall(Wall),
    /// A cell of a displaced sphere: the face of the cube around it, and the cell's lattice indices.
    CubeCell(CubeFace, u32, u32),
}

/// The lattice line on which an upright wall of a relief stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Wall {
    /// The border at the smallest u.
    LowU,
    /// The border at the largest u.
    HighU,
    /// The border at the smallest v.
    LowV,
    /// The border at the largest v.
    HighV,
    /// A seam between tiles at lattice coordinate x = the number.
    SeamU(i32),
    /// A seam between tiles at lattice coordinate y = the number.
    SeamV(i32),
}

impl Ray {
    /// A ray that starts in free space and has no end, at time 0.
    pub fn new(origin: DVec3, direction: DVec3) -> Self {
        Self { origin, direction, t_max: f64::INFINITY, from: None, time: 0.0 }
    }

    /// A ray that starts in free space and ends at `end`, where `t = 1`, at time 0.
    pub fn between(origin: DVec3, end: DVec3) -> Self {
        Self { t_max: 1.0, ..Self::new(origin, end - origin) }
    }

    /// The point at `t`.
    #[inline]
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + t * self.direction
    }

    /// Whether origin and direction are finite and the direction is not zero.
    #[inline]
    pub fn is_valid(&self) -> bool {
        self.origin.is_finite() && self.direction.is_finite() && self.direction != DVec3::ZERO
    }
}

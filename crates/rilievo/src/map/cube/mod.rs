//! The six faces of the cube around a sphere, and a map resampled onto them.
//!
//! A face looks along one axis. A point `(X, Y, Z)` of its frame, `Z > 0` along that axis, is seen in
//! the direction `(X/Z, Y/Z)`, in `[-1, 1]^2` on the face; `n` x `n` cells divide that square
//! evenly. X and Y are the two other axes in ascending order, on every face, so a common edge of two
//! faces runs the same way on both.
//!
//! A lattice point is an integer point on the surface of the cube `[0, n]^3`: its *direction*
//! `2 c - n` is a vector of whole numbers, the same for every face that has the point. What is
//! computed from the direction alone is therefore the same on both sides of an edge, bit for bit.

mod equirectangular;
mod mip;
mod resample;

use glam::DVec3;

pub use equirectangular::Tiling;
pub use mip::CubeMipLevel;
pub use resample::{CubeHeights, CubeHeightsError, ResamplingError};

/// A face of the cube around a sphere, by the axis that it looks along.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum CubeFace {
    /// +x.
    PosX,
    /// -x.
    NegX,
    /// +y.
    PosY,
    /// -y.
    NegY,
    /// +z.
    PosZ,
    /// -z.
    NegZ,
}

impl CubeFace {
    /// All six, in the order of [`CubeFace::index`].
    pub const ALL: [Self; 6] =
        [Self::PosX, Self::NegX, Self::PosY, Self::NegY, Self::PosZ, Self::NegZ];

    /// The face that looks along `axis`, 0 to 2, or against it.
    ///
    /// # Panics
    /// If there is no such axis.
    #[inline]
    pub fn new(axis: usize, positive: bool) -> Self {
        Self::ALL[2 * axis + usize::from(!positive)]
    }

    /// The face through which the direction goes; the first of several.
    #[inline]
    pub fn towards(direction: DVec3) -> Self {
        let [x, y, z] = direction.abs().to_array();
        let axis = if x >= y && x >= z {
            0
        } else if y >= z {
            1
        } else {
            2
        };
        Self::new(axis, direction[axis] >= 0.0)
    }

    /// 0 to 5.
    #[inline]
    pub fn index(self) -> usize {
        self as usize
    }

    /// The axis that the face looks along or against.
    #[inline]
    pub fn axis(self) -> usize {
        self as usize / 2
    }

    /// Whether the face looks along its axis.
    #[inline]
    pub fn is_positive(self) -> bool {
        (self as usize).is_multiple_of(2)
    }

    /// 1 along the axis, -1 against it.
    #[inline]
    pub fn sign(self) -> f64 {
        if self.is_positive() { 1.0 } else { -1.0 }
    }

    /// The axes of X and Y.
    #[inline]
    pub fn across(self) -> [usize; 2] {
        match self.axis() {
            0 => [1, 2],
            1 => [0, 2],
            _ => [0, 1],
        }
    }

    /// The vector with components `x` and `y` across and `z` along the face's direction.
    #[inline]
    pub fn from_frame(self, [x, y, z]: [f64; 3]) -> DVec3 {
        let z = self.sign() * z;
        match self.axis() {
            0 => DVec3::new(z, x, y),
            1 => DVec3::new(x, z, y),
            _ => DVec3::new(x, y, z),
        }
    }

    /// The components of a vector across and along the face's direction.
    #[inline]
    pub fn to_frame(self, v: DVec3) -> [f64; 3] {
        let z = self.sign() * v[self.axis()];
        let [a, b] = self.across();
        [v[a], v[b], z]
    }

    /// The lattice point (i, j) of the face as a point of the cube `[0, n]^3`.
    #[inline]
    pub fn lattice_point(self, cells: u32, [i, j]: [u32; 2]) -> [u32; 3] {
        let mut point = [if self.is_positive() { cells } else { 0 }; 3];
        let [a, b] = self.across();
        (point[a], point[b]) = (i, j);
        point
    }
}

/// The direction `2 c - n` of a point of the cube `[0, n]^3`.
#[inline]
pub(crate) fn direction(cells: u32, point: [u32; 3]) -> [f64; 3] {
    point.map(|c| 2.0 * f64::from(c) - f64::from(cells))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_turned_back() {
        for face in CubeFace::ALL {
            let v = DVec3::new(0.5, -2.0, 3.0);
            assert_eq!(face.from_frame(face.to_frame(v)), v);
            assert_eq!(CubeFace::ALL[face.index()], face);
            assert_eq!(CubeFace::new(face.axis(), face.is_positive()), face);
            let out = face.from_frame([0.3, -0.9, 1.0]);
            assert_eq!(CubeFace::towards(out), face);
            let point = direction(8, face.lattice_point(8, [3, 8]));
            assert_eq!(face.to_frame(DVec3::from_array(point)), [-2.0, 8.0, 8.0]);
        }
    }
}

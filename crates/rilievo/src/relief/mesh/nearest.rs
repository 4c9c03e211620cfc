//! [`Nearest`]: the first of all meetings found so far.

use glam::DVec2;

/// A meeting of a ray with a part of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Candidate {
    /// Parameter of the mesh ray.
    pub t: f64,
    /// Prism, or wall after all prisms.
    pub item: u32,
    /// Unfolded cell; zero for a wall.
    pub cell: [i32; 2],
    /// Parameters of the patch: cell coordinates, weights, or place and height on a wall.
    pub at: DVec2,
    /// Whether the ray comes from the front.
    pub front: bool,
}

impl Candidate {
    /// What comes first at the same parameter.
    #[inline]
    fn key(&self) -> (u32, i32, i32) {
        (self.item, self.cell[1], self.cell[0])
    }
}

/// The nearest meeting, and how near others have to be.
#[derive(Clone, Copy, Debug)]
pub(super) struct Nearest {
    /// Parameter of what was found, or the largest of interest.
    limit: f64,
    any: bool,
    pub found: Option<Candidate>,
}

impl Nearest {
    /// `any` ends the search with the first meeting.
    pub fn new(t_max: f64, any: bool) -> Self {
        Self { limit: t_max, any, found: None }
    }

    /// Farther meetings do not count.
    #[inline(always)]
    pub fn limit(&self) -> f64 {
        self.limit
    }

    /// Whether nothing more is asked for.
    #[inline]
    pub fn is_over(&self) -> bool {
        self.any && self.found.is_some()
    }

    /// Takes a meeting if it is the first; says whether the search is over.
    #[inline(always)]
    pub fn offer(&mut self, candidate: Candidate) -> bool {
        let first = match &self.found {
            Some(best) => (candidate.t, candidate.key()) < (best.t, best.key()),
            None => candidate.t <= self.limit,
        };
        if first {
            self.limit = candidate.t;
            self.found = Some(candidate);
        }
        self.is_over()
    }
}

//! [`Trees`]: the trees of rays of a few camera rays of one pixel, grown side by side.
//!
//! Level by level: the hits of one level are shaded, then all shadow rays are traced that this asks for,
//! then all rays that grow from there. Rays that are traced together are made ready together
//! ([`rilievo::surface::World::closest_each`]), and neither the shading nor the walk throws the other out of the
//! processor's caches and predictors. What a camera ray sees is added up in the order of its own tree, level by
//! level, so it does not depend on which other rays are on the way.

use std::mem;

use rilievo::{Coherence, Hit, Ray};

use super::RayCounts;
use super::distributed::{Branch, Distributed, Sink};
use crate::colour::Rgb;
use crate::level_of_detail::Detail;
use crate::sampler::PixelTable;
use crate::scene::Scene;
use crate::tracer::ShadowRay;

/// Branches that are grown at a time, unless one tree has more at a level.
const MOST: usize = 512;

/// A branch of the tree of a camera ray.
#[derive(Clone, Copy)]
pub(super) struct Twig {
    /// Index of the camera ray.
    pub(super) root: usize,
    pub(super) branch: Branch,
}

/// What branches bring to a camera ray.
struct Brought {
    root: usize,
    radiance: Rgb,
    /// Whether the next shadow ray must meet nothing.
    asked: bool,
}

/// What some branches have become, in their order.
#[derive(Default)]
pub(super) struct Growth {
    /// The camera ray in hand.
    pub(super) root: usize,
    brought: Vec<Brought>,
    /// Shadow rays, and the surface of each that does not count.
    shadows: Vec<Ray>,
    exempt: Vec<Option<u32>>,
    pub(super) twigs: Vec<Twig>,
}

impl Growth {
    /// The shadow rays that are to be traced.
    pub(super) fn shadow_rays(&self) -> impl Iterator<Item = ShadowRay> {
        let rays = self.shadows.iter().zip(&self.exempt);
        rays.map(|(&ray, &exempt)| ShadowRay { ray, exempt })
    }

    /// Adds what was brought to the camera rays, given which shadow rays meet nothing, and forgets it.
    pub(super) fn settle(&mut self, free: &mut impl Iterator<Item = bool>, radiance: &mut [Rgb]) {
        for Brought { root, radiance: more, asked } in self.brought.drain(..) {
            if !asked || free.next() == Some(true) {
                radiance[root] += more;
            }
        }
        self.shadows.clear();
        self.exempt.clear();
    }
}

impl Sink for Growth {
    #[inline]
    fn bring(&mut self, radiance: Rgb) {
        self.brought.push(Brought { root: self.root, radiance, asked: false });
    }

    #[inline]
    fn ask(&mut self, ray: Ray, exempt: Option<u32>, radiance: Rgb) {
        self.shadows.push(ray);
        self.exempt.push(exempt);
        self.brought.push(Brought { root: self.root, radiance, asked: true });
    }

    #[inline]
    fn spawn(&mut self, branch: Branch) {
        self.twigs.push(Twig { root: self.root, branch });
    }
}

/// Where to halve a group of more than `most` branches so that none of a camera ray's are parted, if it can be.
pub(super) fn half(twigs: &[Twig], most: usize) -> Option<usize> {
    if twigs.len() <= most {
        return None;
    }
    let parts = |at: &usize| twigs[at - 1].root != twigs[*at].root;
    let middle = twigs.len() / 2;
    (middle.max(1)..twigs.len()).find(parts).or_else(|| (1..middle).rev().find(parts))
}

/// Room for what grows, kept from pixel to pixel.
#[derive(Default)]
pub(super) struct Room {
    growth: Growth,
    rays: Vec<Ray>,
    hits: Vec<Option<Hit>>,
    occluded: Vec<bool>,
    groups: Vec<Vec<Twig>>,
    /// Groups that are empty.
    spare: Vec<Vec<Twig>>,
}

/// Grows trees of one pixel.
pub(super) struct Trees<'a> {
    pub(super) scene: &'a Scene,
    /// The world that is traced.
    pub(super) detail: Detail<'a>,
    /// At that pixel.
    pub(super) table: &'a mut PixelTable,
    pub(super) rays: &'a mut RayCounts,
    pub(super) room: &'a mut Room,
}

impl Trees<'_> {
    /// Adds the radiance that arrives against some camera rays to `radiance`, given what they meet.
    pub(super) fn grow(
        &mut self,
        roots: impl Iterator<Item = Branch>,
        hits: &[Option<Hit>],
        radiance: &mut [Rgb],
    ) {
        for ((root, branch), hit) in roots.enumerate().zip(hits) {
            self.shade(&Twig { root, branch }, hit.as_ref());
        }
        self.settle(radiance);
        while let Some(mut twigs) = self.room.groups.pop() {
            if let Some(half) = half(&twigs, MOST) {
                let mut rest = self.room.spare.pop().unwrap_or_default();
                rest.extend(twigs.drain(half..));
                self.room.groups.extend([rest, twigs]);
                continue;
            }
            self.trace(&twigs);
            let hits = mem::take(&mut self.room.hits);
            for (twig, hit) in twigs.iter().zip(&hits) {
                self.shade(twig, hit.as_ref());
            }
            self.room.hits = hits;
            twigs.clear();
            self.room.spare.push(twigs);
            self.settle(radiance);
        }
    }

    /// Grows a branch, given what its ray meets.
    fn shade(&mut self, twig: &Twig, hit: Option<&Hit>) {
        let Self { scene, detail, table, rays, room } = self;
        room.growth.root = twig.root;
        let mut tree = Distributed { scene, detail: *detail, table, rays };
        tree.grow(&twig.branch, hit, &mut room.growth);
    }

    /// Finds what branches meet.
    fn trace(&mut self, twigs: &[Twig]) {
        let Room { rays, hits, .. } = self.room;
        rays.clear();
        rays.extend(twigs.iter().map(|twig| twig.branch.ray));
        hits.clear();
        hits.resize(rays.len(), None);
        self.detail.world.closest_each((rays, Coherence::Incoherent), hits, &mut ());
    }

    /// Traces the shadow rays of what has grown, adds up, and puts what grows from there on the pile.
    fn settle(&mut self, radiance: &mut [Rgb]) {
        let Room { growth, occluded, groups, spare, .. } = self.room;
        occluded.clear();
        occluded.resize(growth.shadows.len(), false);
        let Growth { shadows, exempt, .. } = growth;
        self.detail.world.occluded_each(shadows, exempt, (occluded, &mut ()));
        growth.settle(&mut occluded.iter().map(|occluded| !occluded), radiance);
        if !growth.twigs.is_empty() {
            let next = spare.pop().unwrap_or_default();
            groups.push(mem::replace(&mut growth.twigs, next));
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::sampler::Strand;

    #[test]
    fn groups_are_halved_between_camera_rays() {
        let group = |roots: &[usize]| -> Vec<Twig> {
            let ray = Ray::new(DVec3::ZERO, DVec3::X);
            let branch = Branch::root(ray, Strand { index: 0, count: 1 });
            roots.iter().map(|&root| Twig { root, branch }).collect()
        };
        assert_eq!(half(&group(&[0, 0, 1, 1]), 4), None);
        assert_eq!(half(&group(&[0, 0, 1, 1]), 3), Some(2));
        assert_eq!(half(&group(&[0, 0, 0, 1]), 1), Some(3));
        assert_eq!(half(&group(&[0, 1, 1, 1]), 1), Some(1));
        assert_eq!(half(&group(&[3, 3, 3]), 1), None);
        assert_eq!(half(&group(&[3]), 0), None);
    }
}

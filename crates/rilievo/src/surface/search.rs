//! The search among the surfaces of a world: their boxes, sixteen at once.
//!
//! [`WideBvh`] bounds its rounding by the largest coordinate of boxes and of rays' starts, its *reach*. So
//! rays from far outside, and worlds that are small for the place they lie in, go through the tree in
//! `f64`. Boxes only say which surfaces are asked; the answer is the same.

use crate::accel::{Aabb, Visit, WideBvh};
use crate::mesh::crossing::ShearedRay;
use crate::mesh::departure::Departure;
use crate::ray::{Part, Ray};
use crate::simd::{self, Kernel, Lanes, SimdLevel};

use super::Surface;
use super::meeting::Meeting;
use super::prepared::PreparedQuad;
use super::world::{departure, seen_by};

/// Rays start within so many times the largest coordinate of the world.
const AROUND: f64 = 8.0;

/// A world must be at least this large, as a share of its largest coordinate: boxes are then grown by less
/// than 1/4000 of it.
const LARGE: f64 = 1.0 / 16.0;

/// The tree over a world's surfaces, and where it holds.
#[derive(Clone, Debug)]
pub(super) struct WideWorld {
    tree: WideBvh,
    reach: f64,
    level: SimdLevel,
    /// For each surface, if it is a quad, its place among the prepared ones.
    quad_of: Vec<u32>,
    quads: Vec<PreparedQuad>,
}

impl WideWorld {
    /// Over the boxes of surfaces; nothing where single precision says too little about them.
    pub(super) fn of(surfaces: &[Surface], boxes: &[Aabb]) -> Option<Self> {
        let around = boxes.iter().fold(Aabb::EMPTY, |all, bounds| all.union(*bounds));
        let largest = around.largest_coordinate();
        let size = (around.max - around.min).max_element();
        let ordinary = (1e-12..=1e12).contains(&largest) && size >= LARGE * largest;
        let reach = AROUND * largest;
        if !ordinary {
            return None;
        }
        let (mut quad_of, mut quads) = (Vec::with_capacity(surfaces.len()), Vec::new());
        for surface in surfaces {
            quad_of.push(quads.len() as u32);
            if let Surface::Quad(quad) = surface {
                quads.push(PreparedQuad::new(quad));
            }
        }
        let items: Vec<(u32, Aabb)> = (0..).zip(boxes.iter().copied()).collect();
        let (tree, level) = (WideBvh::build(&items, reach), SimdLevel::detect());
        Some(Self { tree, reach, level, quad_of, quads })
    }

    /// A quad of this world, ready for rays.
    #[inline]
    fn quad(&self, index: u32) -> &PreparedQuad {
        &self.quads[self.quad_of[index as usize] as usize]
    }

    /// What a ray leaves, as the others should know.
    #[inline]
    fn departure<'a>(&'a self, surfaces: &'a [Surface], ray: &Ray) -> Option<Departure<'a>> {
        let from = ray.from?;
        match departure(surfaces, ray)? {
            Departure::Parallelogram(corners, _, front) => {
                let plane = self.quad(from.surface).plane();
                Some(Departure::Parallelogram(corners, Some(plane), front))
            }
            other => Some(other),
        }
    }

    /// Whether the tree serves a ray.
    #[inline]
    fn serves(&self, ray: &Ray) -> bool {
        ray.origin.abs().max_element() <= self.reach && ray.is_valid()
    }

    /// The index and the meeting of the nearest surface; nothing if the ray must go another way.
    #[inline]
    pub(super) fn closest<'a>(
        &'a self,
        surfaces: &'a [Surface],
        ray: &Ray,
    ) -> Option<Option<(u32, Meeting<'a>)>> {
        if !self.serves(ray) {
            return None;
        }
        let left = self.departure(surfaces, ray);
        let mut nearest =
            Nearest { world: self, surfaces, left, sheared: None, ray: *ray, best: None };
        simd::run(self.level, Walk { tree: &self.tree, ray, visitor: &mut nearest });
        Some(nearest.best)
    }

    /// Whether any surface but `exempt` is met; nothing if the ray must go another way.
    #[inline]
    pub(super) fn occluded(
        &self,
        surfaces: &[Surface],
        ray: &Ray,
        exempt: Option<u32>,
    ) -> Option<bool> {
        if !self.serves(ray) {
            return None;
        }
        let left = self.departure(surfaces, ray);
        let mut any = Any { world: self, surfaces, left, sheared: None, ray, exempt, found: false };
        simd::run(self.level, Walk { tree: &self.tree, ray, visitor: &mut any });
        Some(any.found)
    }
}

/// The part of surface `index` that a ray starts on.
#[inline]
fn own(index: u32, ray: &Ray) -> Option<Part> {
    ray.from.filter(|from| from.surface == index).map(|from| from.part)
}

/// One ray through the tree.
struct Walk<'a, V> {
    tree: &'a WideBvh,
    ray: &'a Ray,
    visitor: &'a mut V,
}

impl<V: Visit<()>> Kernel for Walk<'_, V> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        self.tree.walk::<L, ()>(self.ray, self.visitor, &mut ());
    }
}

/// The nearest meeting so far.
struct Nearest<'a> {
    world: &'a WideWorld,
    surfaces: &'a [Surface],
    left: Option<Departure<'a>>,
    sheared: Option<ShearedRay>,
    /// It ends at the meeting.
    ray: Ray,
    best: Option<(u32, Meeting<'a>)>,
}

impl Nearest<'_> {
    #[inline(never)]
    fn ask(&mut self, index: u32) {
        let left = self.left.as_ref();
        let found = match &self.surfaces[index as usize] {
            Surface::Quad(quad) => {
                let sheared = self.sheared.get_or_insert_with(|| ShearedRay::new(&self.ray));
                let own = own(index, &self.ray);
                let met = self.world.quad(index).meet((&self.ray, sheared), own, left);
                met.map(|met| Meeting::of_quad(quad, met))
            }
            surface => surface.meet(seen_by(index, &self.ray, &mut None), left, &mut ()),
        };
        let Some(found) = found else { return };
        let t = found.t();
        if self.best.as_ref().is_none_or(|(i, b)| t < b.t() || (t == b.t() && index < *i)) {
            self.ray.t_max = t;
            self.best = Some((index, found));
        }
    }
}

impl Visit<()> for Nearest<'_> {
    #[inline(always)]
    fn visit<L: Lanes>(&mut self, index: u32, (): &mut ()) -> Option<f64> {
        self.ask(index);
        Some(self.ray.t_max)
    }
}

/// Whether there was a meeting.
struct Any<'a> {
    world: &'a WideWorld,
    surfaces: &'a [Surface],
    left: Option<Departure<'a>>,
    sheared: Option<ShearedRay>,
    ray: &'a Ray,
    exempt: Option<u32>,
    found: bool,
}

impl Any<'_> {
    #[inline(never)]
    fn ask(&mut self, index: u32) {
        if self.exempt == Some(index) {
            return;
        }
        let left = self.left.as_ref();
        self.found = match &self.surfaces[index as usize] {
            Surface::Quad(_) => {
                let sheared = self.sheared.get_or_insert_with(|| ShearedRay::new(self.ray));
                let own = own(index, self.ray);
                self.world.quad(index).meet((self.ray, sheared), own, left).is_some()
            }
            surface => {
                let mut room = None;
                surface.occludes_after(seen_by(index, self.ray, &mut room), left, &mut ())
            }
        };
    }
}

impl Visit<()> for Any<'_> {
    #[inline(always)]
    fn visit<L: Lanes>(&mut self, index: u32, (): &mut ()) -> Option<f64> {
        self.ask(index);
        (!self.found).then_some(self.ray.t_max)
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::accel::random::Random;
    use crate::mesh::{Mesh, solids};
    use crate::probe::Counters;
    use crate::surface::{Quad, Sphere, World};

    /// The sides of nested boxes, of which some share corners, bent quads, spheres and a mesh.
    fn surfaces(random: &mut Random) -> Vec<Surface> {
        let mut all = Vec::new();
        for k in 0..40 {
            let corner = (random.cube() * 4.0).round() / 4.0;
            let (u, v) = match k % 4 {
                0 => (random.cube(), random.cube()),
                k => (0.5 * DVec3::AXES[k % 3], 0.5 * DVec3::AXES[(k + 1) % 3]),
            };
            let bend = if k % 5 == 0 { 0.3 * random.cube() } else { DVec3::ZERO };
            let corners = [corner, corner + u, corner + u + v + bend, corner + v];
            all.push(Quad::new(corners, k % 7 == 0).expect("valid").into());
        }
        all.push(Sphere::new(0.5 * random.cube(), 0.2).expect("valid").into());
        all.push(Mesh::new(solids::subdivided_sphere(2)).expect("valid").into());
        all
    }

    #[test]
    fn hits_are_those_of_the_tree_to_the_last_bit() {
        let mut random = Random(131);
        let surfaces = surfaces(&mut random);
        // In one node, in several, and from so far away that the tree must do.
        for (count, size) in [(12, 2.0), (42, 2.0), (42, 40.0)] {
            let world = World::new(surfaces[..count].to_vec());
            assert!(world.wide.is_some());
            for case in 0..20_000 {
                let origin = size * random.cube();
                let at = (random.cube() * 4.0).round() / 4.0;
                let direction = if case % 3 == 0 { at - origin } else { random.cube() - origin };
                let mut ray = Ray::new(origin, direction);
                // Up to a hit, and on from there.
                for _ in 0..4 {
                    let hit = world.closest(&ray, &mut ());
                    assert_eq!(hit, world.closest(&ray, &mut Counters::default()), "{ray:?}");
                    let stopped = world.occluded(&ray, &mut ());
                    assert_eq!(stopped, hit.is_some(), "{ray:?}");
                    let Some(hit) = hit else { break };
                    let before = world.occluded_before(&ray, hit.surface, &mut ());
                    let counted = &mut Counters::default();
                    assert_eq!(before, world.occluded_before(&ray, hit.surface, counted));
                    let to = if case % 2 == 0 { at } else { random.cube() };
                    ray = hit.spawn(to - hit.position);
                    ray.t_max = if case % 4 == 0 { 1.0 } else { f64::INFINITY };
                    if !ray.is_valid() {
                        break;
                    }
                }
            }
        }
    }
}

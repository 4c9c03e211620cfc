//! The suite must pass the oracle itself and catch what is wrong by little.

use glam::{DVec2, DVec3};

use super::*;
use crate::scenes;

/// The oracle over all cells, posing as a method.
struct Judge<'a> {
    oracle: Oracle<'a>,
    /// Added to every t, relative.
    late: f64,
    /// Rays whose first bits of t are zero are lost.
    leaks: bool,
}

impl Contender for Judge<'_> {
    fn closest(&self, ray: &Ray) -> Option<Hit> {
        let hit = self.oracle.closest_of_all_cells(ray)?;
        if self.leaks && hit.t.to_bits().is_multiple_of(64) {
            return None;
        }
        let t = hit.t * (1.0 + self.late);
        let (offset, slope) = match hit.part {
            Part::Cell(i, j) => self.oracle.cell_offset(i, j, hit.uv.x, hit.uv.y),
            _ => (hit.offset, DVec2::ZERO),
        };
        let [c0, c1, _, c3] = self.oracle.placement().corners;
        let along = [c1 - c0, c3 - c0];
        let normal = match hit.part {
            Part::Cell(..) => (along[0] + slope.x * self.oracle.normal())
                .cross(along[1] + slope.y * self.oracle.normal())
                .normalize(),
            _ => along[0].normalize(),
        };
        let place = self.oracle.placement();
        let height = if place.scale == 0.0 { 0.0 } else { offset / place.scale + place.zero };
        Some(Hit {
            t,
            position: ray.at(t),
            position_error: 1e-9 * self.oracle.size(),
            geometric_normal: normal,
            shading_normal: normal,
            tangents: along,
            uv: hit.uv,
            height,
            front: hit.front,
            surface: 0,
            part: hit.part,
            time: ray.time,
        })
    }
}

fn judge(scene: &Scene) -> Box<dyn Contender + '_> {
    Box::new(Judge { oracle: scene.oracle(), late: 0.0, leaks: false })
}

fn few(words: &[&str]) -> Plan {
    let scenes = words.iter().map(|words| scenes::named(words)).collect();
    Plan { scenes, rays: 3000, seed: 7 }
}

#[test]
fn the_oracle_over_all_cells_passes() {
    let entries = [Entry { name: "judge", build: judge }];
    let report = check(&entries, &few(&["noise 3 x 5", "ramp 9 x 12", "white noise 31"]));
    assert!(report.rays == 9000 && report.hits > 2000, "{report}");
}

#[test]
fn a_hit_a_little_late_is_caught() {
    let entries = [Entry {
        name: "late",
        build: |scene| Box::new(Judge { oracle: scene.oracle(), late: 1e-3, leaks: false }),
    }];
    let plan = few(&["ramp 9 x 12"]);
    let report = check_scene(&entries, &plan.scenes[0], &plan, 0);
    assert!(report.disagreements > report.hits / 2, "{report}");
}

#[test]
fn a_few_lost_rays_are_caught_by_both_comparisons() {
    let leaky: fn(&Scene) -> Box<dyn Contender + '_> =
        |scene| Box::new(Judge { oracle: scene.oracle(), late: 0.0, leaks: true });
    let plan = few(&["noise 3 x 5"]);
    let alone = [Entry { name: "leaky", build: leaky }];
    let report = check_scene(&alone, &plan.scenes[0], &plan, 0);
    assert!(report.disagreements > 3, "{report}");
    assert!(report.examples.iter().any(|example| example.kind == Kind::Missed));
    let beside = [Entry { name: "judge", build: judge }, Entry { name: "leaky", build: leaky }];
    let report = check_scene(&beside, &plan.scenes[0], &plan, 0);
    assert!(report.examples.iter().all(|example| example.kind == Kind::Bits), "{report}");
    assert!(report.disagreements > 3, "{report}");
}

#[test]
fn every_family_makes_rays_that_hit_and_rays_that_miss() {
    let scene = scenes::named("fbm 64");
    let oracle = scene.oracle();
    for family in Family::ALL {
        let hits = (0..2000)
            .filter(|&k| {
                let ray = family.ray(&oracle, &mut Random::new(&[3, k]));
                assert!(ray.is_valid() && ray.direction != DVec3::ZERO);
                oracle.closest(&ray).is_some()
            })
            .count();
        assert!((20..1980).contains(&hits), "{family:?}: {hits} of 2000 hit");
    }
}

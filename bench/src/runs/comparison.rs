//! [`Comparison`]: rilievo beside the best of Embree on one row.

use super::Run;
use crate::kernels;
use crate::rays::Family;

/// A map, a size, a family, single rays or packets.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    pub map: String,
    pub size: u32,
    pub family: Family,
    pub packet: bool,
    /// Mrays/s of rilievo's default layout.
    pub rilievo: f64,
    /// The same of the layout tiny.
    pub tiny: Option<f64>,
    /// The best Embree contender and its Mrays/s.
    pub embree: (String, f64),
}

/// Which rows a mean speaks of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scope {
    /// Primary, shadow, diffuse, packets of 16 primary rays, on fbm, gaussian and studded.
    Goal,
    /// Every row.
    All,
}

impl Comparison {
    /// The rows of a run that have both sides, sizes ascending, in the order of the record: rilievo
    /// at one SIMD level, or at the best one recorded.
    pub fn all(run: &Run, simd: Option<&str>) -> Vec<Self> {
        let mut rows: Vec<Self> = Vec::new();
        for record in &run.kernels {
            let at = |row: &Self| row.is_of(record);
            if !rows.iter().any(at)
                && let Some(row) = Self::of(&run.kernels, record, simd)
            {
                rows.push(row);
            }
        }
        rows.sort_by_key(|row| row.size);
        rows
    }

    /// The row of `record`.
    fn of(
        records: &[kernels::Record],
        record: &kernels::Record,
        simd: Option<&str>,
    ) -> Option<Self> {
        let fits = |other: &kernels::Record| match (other.simd(), simd) {
            (Some(found), Some(asked)) => found == asked,
            _ => true,
        };
        let same = || records.iter().filter(|other| record.is_same_work(other) && fits(other));
        let best = |chosen: &dyn Fn(&str) -> bool| {
            same()
                .filter(|r| chosen(&r.contender))
                .max_by(|a, b| a.mrays_per_s.total_cmp(&b.mrays_per_s))
        };
        let rilievo = best(&|name| name == "rilievo-default")?;
        let embree = best(&|name| name.starts_with("embree-"))?;
        let packets = if embree.rays_a_call > 1 {
            format!(" x{}", embree.rays_a_call)
        } else {
            String::new()
        };
        Some(Self {
            map: record.map.clone(),
            size: record.size,
            family: record.family,
            packet: record.packet,
            rilievo: rilievo.mrays_per_s,
            tiny: best(&|name| name == "rilievo-tiny").map(|r| r.mrays_per_s),
            embree: (format!("{}{packets}", embree.contender), embree.mrays_per_s),
        })
    }

    fn is_of(&self, record: &kernels::Record) -> bool {
        (self.map.as_str(), self.size, self.family, self.packet)
            == (record.map.as_str(), record.size, record.family, record.packet)
    }

    /// rilievo / Embree.
    pub fn ratio(&self) -> f64 {
        self.rilievo / self.embree.1
    }

    /// The family, with the word packets where it comes in such.
    pub fn row_name(&self) -> String {
        self.family.row_name(self.packet)
    }

    /// Whether a scope holds the row.
    pub fn is_in(&self, scope: Scope) -> bool {
        let is_goal = match (self.family, self.packet) {
            (Family::Primary | Family::Shadow | Family::Diffuse, packet) => !packet,
            (Family::Primary16, _) => true,
            (Family::Grazing, _) => false,
        };
        let goal = is_goal && ["fbm", "gaussian", "studded"].contains(&self.map.as_str());
        scope == Scope::All || goal
    }
}

/// The geometric mean of ratios; none without any.
pub fn geometric_mean(ratios: impl Iterator<Item = f64>) -> Option<f64> {
    let (mut sum, mut count) = (0.0, 0u32);
    for ratio in ratios {
        (sum, count) = (sum + ratio.ln(), count + 1);
    }
    (count > 0).then(|| (sum / f64::from(count)).exp())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::example;

    #[test]
    fn the_best_peer_of_the_same_work_counts() {
        let mut wide = example("embree-grid", Family::Primary16, true, 20.0);
        wide.rays_a_call = 16;
        let run = Run {
            kernels: vec![
                example("rilievo-default", Family::Primary, false, 6.0),
                example("rilievo-tiny", Family::Primary, false, 5.0),
                example("embree-grid", Family::Primary, false, 4.0),
                example("embree-quad", Family::Primary, false, 3.0),
                example("rilievo-default", Family::Primary16, true, 10.0),
                wide,
                // No peer: no comparison.
                example("rilievo-default", Family::Diffuse, false, 10.0),
            ],
            ..Run::default()
        };
        let rows = Comparison::all(&run, None);
        assert_eq!(rows.len(), 2);
        assert_eq!((rows[0].ratio(), rows[0].tiny), (1.5, Some(5.0)));
        assert_eq!(rows[0].embree.0, "embree-grid");
        assert_eq!((rows[1].ratio(), rows[1].embree.0.as_str()), (0.5, "embree-grid x16"));
        assert_eq!(rows[1].row_name(), "primary16 packets");
        assert!(rows.iter().all(|row| row.is_in(Scope::Goal)));
        // The examples say no level, so they belong to any.
        assert_eq!(Comparison::all(&run, Some("avx2")), rows);
        let mean = geometric_mean(rows.iter().map(Comparison::ratio)).unwrap();
        assert!((mean - 0.75f64.sqrt()).abs() < 1e-12);
        assert_eq!(geometric_mean([].into_iter()), None);
    }
}

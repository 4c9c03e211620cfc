//! One line of `gpu --json`.

use serde::{Deserialize, Serialize};

/// A contender on one family of rays, or a build or an edit.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Always `gpu`.
    pub bench: String,
    pub adapter: String,
    /// Whether the adapter is a program on the CPU: then no figure says anything of a GPU.
    pub software: bool,
    /// `device` for the device's own clock, `wall` for that of the machine.
    pub clock: String,
    /// `primary`, `diffuse`, `build`, `edit`, `edit and frame`.
    pub what: String,
    pub contender: String,
    pub map: String,
    /// Samples a side.
    pub size: u32,
    /// Scene units of height 1, on a unit square.
    pub depth: f64,
    /// Pixels of the image that makes the rays.
    pub image: [u32; 2],
    /// Slices of the distance map; 0 where there is none.
    pub slices: u32,
    /// Voxels or nodes a side of the distance map; 0 where there is none.
    pub grid: u32,
    /// Samples a side of the grid that was cut into triangles; 0 for none.
    pub peer_size: u32,
    /// The median pass.
    pub seconds: f64,
    /// (slowest - fastest) / median pass.
    pub spread: f64,
    pub passes: usize,
    pub rays: u64,
    pub mrays_per_s: f64,
    /// Bytes beside the heights.
    pub bytes: u64,
    pub steps_a_ray: Option<f64>,
    pub answers: Option<Answers>,
}

/// Answers beside those of `pyramid`, which is exact.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Answers {
    pub hits: u64,
    /// Rays that hit nothing and should.
    pub missed: u64,
    /// Rays that hit and should not.
    pub false_hits: u64,
    /// Hits more than a thousandth of the map's side from their place, along the ray.
    pub misplaced: u64,
}

impl Answers {
    /// Of parameters along rays of unit length.
    pub fn new(reference: &[Option<f64>], found: &[Option<f64>]) -> Self {
        let mut answers = Self::default();
        for pair in reference.iter().zip(found) {
            answers.hits += u64::from(pair.1.is_some());
            match pair {
                (Some(_), None) => answers.missed += 1,
                (None, Some(_)) => answers.false_hits += 1,
                (Some(a), Some(b)) if (a - b).abs() > 1e-3 => answers.misplaced += 1,
                _ => {}
            }
        }
        answers
    }
}

impl Record {
    /// The record for people.
    pub fn line(&self) -> String {
        let Self { what, contender, slices, seconds, spread, .. } = self;
        let slices = if *slices > 0 { format!(" {slices}") } else { String::new() };
        let mut line = format!(
            "{what:15} {:22} {:9.3} ms +-{:.0} %",
            format!("{contender}{slices}"),
            seconds * 1e3,
            spread * 50.0
        );
        if self.mrays_per_s > 0.0 {
            line +=
                &format!(", {:.2} Mrays/s, {:.1} MB", self.mrays_per_s, self.bytes as f64 * 1e-6);
        }
        if let Some(steps) = self.steps_a_ray {
            line += &format!(", {steps:.1} steps a ray");
        }
        if let Some(Answers { missed, false_hits, misplaced, .. }) = self.answers {
            line += &format!(", {missed} missed, {false_hits} false, {misplaced} misplaced");
        }
        line
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn answers_are_told_apart() {
        let reference = [Some(1.0), Some(1.0), None, Some(2.0), None];
        let found = [Some(1.0001), None, Some(3.0), Some(2.1), None];
        let want = Answers { hits: 3, missed: 1, false_hits: 1, misplaced: 1 };
        assert_eq!(Answers::new(&reference, &found), want);
        let record = Record {
            answers: Some(want),
            contender: "distance".to_owned(),
            slices: 16,
            ..Record::default()
        };
        let line = serde_json::to_string(&record).unwrap();
        assert_eq!(serde_json::from_str::<Record>(&line).unwrap(), record);
        assert!(record.line().contains("distance 16") && record.line().contains("1 missed"));
    }
}

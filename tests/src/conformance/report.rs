//! What the suite found.

use std::collections::BTreeMap;
use std::fmt;

use rilievo::{Hit, Ray};

use crate::oracle::OracleHit;
use crate::rays::Family;

/// In what two answers differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// A miss where the oracle hits.
    Missed,
    /// A hit where the oracle misses.
    False,
    /// A hit elsewhere than the oracle's.
    Misplaced,
    /// The right place, from the wrong side.
    Side,
    /// Not the bits of the first method.
    Bits,
    /// Any-hit and closest-hit do not agree.
    Occlusion,
    /// A hit that does not describe its own point.
    Attributes,
}

/// One ray and what was said about it.
#[derive(Clone, Copy, Debug)]
pub struct Disagreement {
    /// In what.
    pub kind: Kind,
    /// The name of the entry that is in the minority.
    pub who: &'static str,
    /// How the ray was made.
    pub family: Family,
    /// The ray.
    pub ray: Ray,
    /// The entry's answer.
    pub answer: Option<Hit>,
    /// The oracle's.
    pub judge: Option<OracleHit>,
}

/// Counts for one scene or many.
#[derive(Clone, Debug)]
pub struct Report {
    /// The scene's name.
    pub scene: String,
    /// Rays traced.
    pub rays: u64,
    /// Rays that hit, by the first entry.
    pub hits: u64,
    /// Differences from the oracle that a nudge explains, by family and kind.
    pub excuses: BTreeMap<(Family, Kind), u64>,
    /// Differences that nothing explains.
    pub disagreements: u64,
    /// The same by kind, family and entry.
    pub counts: BTreeMap<(Kind, Family, &'static str), u64>,
    /// The first of them.
    pub examples: Vec<Disagreement>,
}

impl Report {
    /// Examples kept of a scene.
    const KEPT: usize = 6;

    /// Nothing found yet.
    pub fn new(scene: &str) -> Self {
        Self {
            scene: scene.to_owned(),
            rays: 0,
            hits: 0,
            excuses: BTreeMap::new(),
            disagreements: 0,
            counts: BTreeMap::new(),
            examples: Vec::new(),
        }
    }

    /// Adds a disagreement.
    pub fn push(&mut self, disagreement: Disagreement) {
        self.disagreements += 1;
        let Disagreement { kind, family, who, .. } = disagreement;
        *self.counts.entry((kind, family, who)).or_default() += 1;
        if self.examples.len() < Self::KEPT {
            self.examples.push(disagreement);
        }
    }

    /// Both together, under the name of the first.
    #[must_use]
    pub fn merge(mut self, other: Self) -> Self {
        self.rays += other.rays;
        self.hits += other.hits;
        for (key, count) in other.excuses {
            *self.excuses.entry(key).or_default() += count;
        }
        self.disagreements += other.disagreements;
        for (key, count) in other.counts {
            *self.counts.entry(key).or_default() += count;
        }
        self.examples.extend(other.examples);
        self.examples.truncate(Self::KEPT);
        self
    }

    /// Whether anything disagreed without excuse.
    pub fn failed(&self) -> bool {
        self.disagreements > 0
    }

    /// The counts and the examples, each a ray to start from.
    pub fn details(&self) -> String {
        let mut text = format!("{self}\n");
        for ((family, kind), count) in &self.excuses {
            text += &format!("  {count} {kind:?} excused, {family:?}\n");
        }
        for ((kind, family, who), count) in &self.counts {
            text += &format!("  {count} {kind:?} by {who}, {family:?}\n");
        }
        for example in &self.examples {
            let Disagreement { kind, who, family, ray, answer, judge } = example;
            text += &format!("  {kind:?} by {who}, {family:?}\n    {ray:?}\n");
            text += &format!("    answer {answer:?}\n    oracle {judge:?}\n");
        }
        text
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let border = |at_border: bool| -> u64 {
            let there = |(family, _): &(Family, Kind)| (*family == Family::Border) == at_border;
            self.excuses.iter().filter(|(key, _)| there(key)).map(|(_, count)| count).sum()
        };
        write!(
            f,
            "{}: {} rays, {} hits, {} disagreements, {} nudge-excused and {} at the border",
            self.scene,
            self.rays,
            self.hits,
            self.disagreements,
            border(false),
            border(true)
        )
    }
}

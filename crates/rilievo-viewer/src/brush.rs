//! The brush: heights raised, lowered and smoothed around a place of the map.
//!
//! A dab weighs samples by `(1 - d^2)^2`, `d` being the distance from its middle in radii. The
//! rectangle it touches is read, changed and written back by [`Relief::edit`], which mends the pyramid
//! above it; what was there before stays with the stroke, to be taken back.

use std::ops::Range;

use glam::DVec2;
use rilievo::map::{Axis, HeightMap, HeightMapError, RowMut, Samples, Wrap};
use rilievo::relief::Relief;

/// A dab touches its own sample at least.
const LEAST_RADIUS: f64 = 1.0;
/// Beyond this a dab takes longer than a picture.
const MOST_RADIUS: f64 = 4096.0;

/// What a brush does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tool {
    /// Heights grow.
    #[default]
    Raise,
    /// Heights shrink.
    Lower,
    /// Heights come nearer to the mean of their neighbours.
    Smooth,
}

impl Tool {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Raise, Self::Lower, Self::Smooth];

    /// What the window calls it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Raise => "raise",
            Self::Lower => "lower",
            Self::Smooth => "smooth",
        }
    }
}

/// One touch of the brush.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dab {
    /// What is done.
    pub tool: Tool,
    /// Its middle, in repetitions of the map along u and v.
    pub at: DVec2,
    /// Samples from its middle to its border.
    pub radius: f64,
    /// Of raise and lower: heights of the whole range of the map, 0 to 1; of smooth: how much of the
    /// way to the mean.
    pub strength: f64,
}

/// A rectangle of a map as it was.
#[derive(Clone, Debug, PartialEq)]
struct Patch {
    /// First column and row.
    corner: [u32; 2],
    size: [u32; 2],
    samples: Samples,
}

/// What a stroke has changed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Stroke {
    /// In the order of the changes.
    patches: Vec<Patch>,
}

impl Stroke {
    /// Bytes that are kept to take it back.
    pub fn bytes(&self) -> u64 {
        self.patches.iter().map(|patch| patch.samples.bytes()).sum()
    }

    /// The rectangles that were changed, first and end column and row, in the order of the changes.
    pub fn areas(&self) -> impl Iterator<Item = [Range<u32>; 2]> {
        self.patches.iter().map(|Patch { corner: [x, y], size: [width, height], .. }| {
            [*x..*x + width, *y..*y + height]
        })
    }

    /// Touches the map.
    ///
    /// # Errors
    /// [`HeightMapError`] if a height grows beyond all bounds; the map is then as it was before.
    pub fn dab(&mut self, relief: &mut Relief, dab: &Dab) -> Result<(), HeightMapError> {
        let map = relief.heights();
        let (low, high) = map.raw_range();
        // Of a flat map, what a code or a height of 1 can be.
        let span = if low < high { f64::from(high - low) } else { 1.0 / map.unit() };
        let radius = dab.radius.clamp(LEAST_RADIUS, MOST_RADIUS);
        let middle = [stored(map.x(), dab.at.x), stored(map.y(), dab.at.y)];
        let columns = parts(middle[0], radius, map.x());
        let rows = parts(middle[1], radius, map.y());
        for &(x, shift_x) in &columns {
            for &(y, shift_y) in &rows {
                let middle = [middle[0] + shift_x, middle[1] + shift_y];
                self.touch(relief, [x, y], (middle, span), dab)?;
            }
        }
        Ok(())
    }

    /// Changes a rectangle, first and end column and row, within which the dab has this middle; `span` is a
    /// strength of 1 in raw units.
    fn touch(
        &mut self,
        relief: &mut Relief,
        [[x0, x1], [y0, y1]]: [[u32; 2]; 2],
        (middle, span): ([f64; 2], f64),
        dab: &Dab,
    ) -> Result<(), HeightMapError> {
        let radius = dab.radius.clamp(LEAST_RADIUS, MOST_RADIUS);
        let old = read(relief.heights(), [x0, y0], [x1 - x0, y1 - y0]);
        let mut new = Vec::with_capacity(old.samples.len());
        for j in y0..y1 {
            for i in x0..x1 {
                let map = relief.heights();
                let d = DVec2::new(f64::from(i) - middle[0], f64::from(j) - middle[1]) / radius;
                let weight = (1.0 - d.length_squared()).max(0.0).powi(2);
                let raw = f64::from(map.raw(i, j));
                let change = match dab.tool {
                    Tool::Raise => span * dab.strength,
                    Tool::Lower => -span * dab.strength,
                    Tool::Smooth => (mean_around(map, i, j) - raw) * dab.strength.min(1.0),
                };
                new.push(raw + weight * change);
            }
        }
        let width = (x1 - x0) as usize;
        relief.edit([x0..x1, y0..y1], |j, row| {
            let from = (j - y0) as usize * width;
            write(row, &new[from..from + width]);
        })?;
        self.patches.push(old);
        Ok(())
    }

    /// Puts back what was there before, and keeps what is there now in its place: done twice, the map is
    /// what it was.
    ///
    /// # Errors
    /// [`HeightMapError`] if the map is another one.
    pub fn swap(&mut self, relief: &mut Relief) -> Result<(), HeightMapError> {
        let mut now = Vec::with_capacity(self.patches.len());
        for patch in self.patches.iter().rev() {
            let Patch { corner: [x, y], size: [width, height], samples } = patch;
            let whole = [relief.heights().width(), relief.heights().height()];
            if x + width > whole[0] || y + height > whole[1] {
                let (x, y) = (*x..x + width, *y..y + height);
                let [width, height] = whole;
                return Err(HeightMapError::NotInside { x, y, width, height });
            }
            now.push(read(relief.heights(), patch.corner, patch.size));
            let width = *width as usize;
            relief.edit([*x..x + patch.size[0], *y..y + height], |j, row| {
                let from = (j - y) as usize * width;
                match (row, samples) {
                    (RowMut::U16(row), Samples::U16(old)) => {
                        row.copy_from_slice(&old[from..from + width]);
                    }
                    (RowMut::F32(row), Samples::F32(old)) => {
                        row.copy_from_slice(&old[from..from + width]);
                    }
                    _ => {}
                }
            })?;
        }
        self.patches = now;
        Ok(())
    }
}

/// The lattice coordinate of the stored sample that shows at `u`, of maps that repeat or are mirrored.
fn stored(axis: &Axis, u: f64) -> f64 {
    match axis.wrap() {
        Wrap::Repeat => axis.coordinate(u.rem_euclid(1.0)),
        Wrap::Mirror => {
            let folded = u.rem_euclid(2.0);
            axis.coordinate(if folded > 1.0 { 2.0 - folded } else { folded })
        }
        Wrap::Clamp => axis.coordinate(u),
    }
}

/// Columns or rows that a dab touches, each run with what is added to the middle within it. Maps that
/// repeat are touched across their border.
fn parts(middle: f64, radius: f64, axis: &Axis) -> Vec<([u32; 2], f64)> {
    let (all, period) = (f64::from(axis.samples()), f64::from(axis.period()));
    let shifts: &[f64] = match axis.wrap() {
        Wrap::Repeat => &[0.0, -1.0, 1.0],
        Wrap::Clamp | Wrap::Mirror => &[0.0],
    };
    let mut found = Vec::new();
    for shift in shifts {
        let at = middle + shift * period;
        let from = (at - radius).ceil().clamp(0.0, all) as u32;
        let to = ((at + radius).floor() + 1.0).clamp(0.0, all) as u32;
        if from < to {
            found.push(([from, to], shift * period));
        }
    }
    found
}

fn read(map: &HeightMap, corner: [u32; 2], size: [u32; 2]) -> Patch {
    let rows = (corner[1]..corner[1] + size[1]).map(|j| {
        let from = j as usize * map.width() as usize + corner[0] as usize;
        from..from + size[0] as usize
    });
    let samples = match map.samples() {
        Samples::U16(all) => Samples::U16(rows.flat_map(|row| all[row].to_vec()).collect()),
        Samples::F32(all) => Samples::F32(rows.flat_map(|row| all[row].to_vec()).collect()),
    };
    Patch { corner, size, samples }
}

/// The mean of the eight samples around one, within the map.
fn mean_around(map: &HeightMap, i: u32, j: u32) -> f64 {
    let near = |at: u32, most: u32| at.saturating_sub(1)..=(at + 1).min(most - 1);
    let (mut sum, mut count) = (0.0, 0.0);
    for y in near(j, map.height()) {
        for x in near(i, map.width()) {
            if (x, y) != (i, j) {
                sum += f64::from(map.raw(x, y));
                count += 1.0;
            }
        }
    }
    sum / count
}

fn write(row: RowMut<'_>, new: &[f64]) {
    match row {
        RowMut::U16(row) => {
            for (slot, value) in row.iter_mut().zip(new) {
                *slot = value.round().clamp(0.0, 65535.0) as u16;
            }
        }
        RowMut::F32(row) => {
            for (slot, value) in row.iter_mut().zip(new) {
                *slot = *value as f32;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rilievo::map::Lattice;

    fn relief(samples: Samples, wrap: Wrap) -> Relief {
        Relief::new(HeightMap::new(40, 40, samples, Lattice::Texel, wrap).unwrap())
    }

    fn reliefs() -> Vec<Relief> {
        let codes = (0..1600u32).map(|k| (k * 7919 % 40_000) as u16 + 9000).collect();
        let heights = (0..1600u32).map(|k| (k * 7919 % 1000) as f32 / 500.0).collect();
        let mut all = Vec::new();
        for wrap in [Wrap::Repeat, Wrap::Clamp, Wrap::Mirror] {
            all.push(relief(Samples::U16(Vec::clone(&codes)), wrap));
            all.push(relief(Samples::F32(Vec::clone(&heights)), wrap));
        }
        all
    }

    fn dab(tool: Tool, at: [f64; 2]) -> Dab {
        Dab { tool, at: at.into(), radius: 6.0, strength: 0.2 }
    }

    fn bytes(relief: &Relief) -> String {
        format!("{:?} {:?}", relief.heights(), relief.pyramid())
    }

    #[test]
    fn a_stroke_taken_back_leaves_the_same_bytes_and_can_be_done_again() {
        for mut relief in reliefs() {
            let before = bytes(&relief);
            let mut stroke = Stroke::default();
            for (k, tool) in Tool::ALL.into_iter().enumerate() {
                // Dabs overlap, and reach over the border.
                for at in [[0.1, 0.1], [0.02, 0.5], [0.2, 0.98]] {
                    stroke.dab(&mut relief, &dab(tool, at.map(|c| c + 0.05 * k as f64))).unwrap();
                }
            }
            let after = bytes(&relief);
            assert_ne!(before, after);
            // The mended pyramid is that of the changed map.
            let fresh = Relief::new(relief.heights().clone());
            assert_eq!(bytes(&fresh), after);
            stroke.swap(&mut relief).unwrap();
            assert_eq!(bytes(&relief), before);
            stroke.swap(&mut relief).unwrap();
            assert_eq!(bytes(&relief), after);
        }
    }

    #[test]
    fn each_tool_does_what_it_is_called() {
        for mut relief in reliefs() {
            let at = [0.51, 0.51];
            let height = |relief: &Relief| f64::from(relief.heights().raw(20, 20));
            let old = height(&relief);
            let mut stroke = Stroke::default();
            stroke.dab(&mut relief, &dab(Tool::Raise, at)).unwrap();
            let raised = height(&relief);
            assert!(raised > old);
            stroke.dab(&mut relief, &dab(Tool::Lower, at)).unwrap();
            assert!(height(&relief) < raised);
            let rough = |relief: &Relief| {
                (15..25)
                    .map(|i| {
                        let map = relief.heights();
                        (f64::from(map.raw(i, 20)) - mean_around(map, i, 20)).abs()
                    })
                    .sum::<f64>()
            };
            let before = rough(&relief);
            for _ in 0..10 {
                stroke.dab(&mut relief, &dab(Tool::Smooth, at)).unwrap();
            }
            assert!(rough(&relief) < before);
            // Far away nothing happened.
            let fresh = reliefs().into_iter().find(|r| {
                r.heights().x().wrap() == relief.heights().x().wrap()
                    && std::mem::discriminant(r.heights().samples())
                        == std::mem::discriminant(relief.heights().samples())
            });
            assert_eq!(fresh.unwrap().heights().raw(2, 2), relief.heights().raw(2, 2));
        }
    }

    #[test]
    fn a_map_that_repeats_is_painted_across_its_border() {
        for mut relief in reliefs() {
            let across = relief.heights().raw(39, 20);
            Stroke::default().dab(&mut relief, &dab(Tool::Raise, [0.0, 0.5])).unwrap();
            let changed = relief.heights().raw(39, 20) > across;
            assert_eq!(changed, relief.heights().x().wrap() == Wrap::Repeat);
        }
    }
}

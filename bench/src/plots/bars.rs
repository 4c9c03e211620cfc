//! Bars: ratios of rates, and times of distance transforms.

use super::panel::ticks;
use super::svg::{Anchor, Svg};
use super::{Plot, colour};
use crate::runs::{Comparison, Run, Transform};

const LABEL: f64 = 210.0;
const INSIDE: f64 = 400.0;
const STEP: f64 = 20.0;
const TOP: f64 = 56.0;

/// Colour of a row where rilievo is slower.
const LOSS: &str = "#868e96";

/// One bar.
struct Bar {
    label: String,
    figure: f64,
    colour: &'static str,
    /// Written behind the bar.
    note: String,
}

/// rilievo / best Embree, a file a size.
pub fn ratios(run: &Run) -> Vec<Plot> {
    let rows = Comparison::all(run, None);
    let mut sizes: Vec<u32> = rows.iter().map(|row| row.size).collect();
    sizes.dedup();
    let bar = |row: &Comparison| Bar {
        label: format!("{} {}", row.map, row.row_name()),
        figure: row.ratio(),
        colour: if row.ratio() < 1.0 { LOSS } else { colour("rilievo-default") },
        note: format!("{:.2} ({})", row.ratio(), row.embree.0),
    };
    let plot = |size: u32| {
        let bars: Vec<Bar> = rows.iter().filter(|row| row.size == size).map(bar).collect();
        let title = format!("{size} x {size}: rays a second, rilievo / best Embree");
        Plot { name: format!("ratios-{size}.svg"), text: chart(&title, &bars, Some(1.0)) }
    };
    sizes.into_iter().map(plot).collect()
}

/// Nanoseconds a voxel, ours and the peers'.
pub fn transforms(records: &[Transform]) -> Vec<Plot> {
    if records.is_empty() {
        return Vec::new();
    }
    let bar = |record: &Transform| Bar {
        label: format!("{} {}", record.grid, record.contender),
        figure: record.ns_per_voxel,
        colour: if record.contender.starts_with("rilievo") {
            colour("rilievo-default")
        } else {
            colour("embree-grid")
        },
        note: format!("{:.1}", record.ns_per_voxel),
    };
    let mut sorted: Vec<&Transform> = records.iter().collect();
    sorted.sort_by(|a, b| (&a.grid, &a.contender).cmp(&(&b.grid, &b.contender)));
    let bars: Vec<Bar> = sorted.into_iter().map(bar).collect();
    let title = "Distance maps and transforms: processor nanoseconds a voxel, one thread";
    vec![Plot { name: "transforms.svg".to_owned(), text: chart(title, &bars, None) }]
}

/// Bars on a logarithmic axis. They start at `base`, or at the low end of the axis without one.
fn chart(title: &str, bars: &[Bar], base: Option<f64>) -> String {
    let figures = || bars.iter().map(|bar| bar.figure).chain(base);
    let low = figures().fold(f64::INFINITY, f64::min) * 0.8;
    let high = figures().fold(0.0, f64::max) * 1.25;
    let base = base.unwrap_or(low);
    let bottom = TOP + STEP * bars.len() as f64;
    let mut svg = Svg::new(LABEL + INSIDE + 140.0, bottom + 12.0);
    let x = |figure: f64| LABEL + INSIDE * (figure / low).ln() / (high / low).ln();
    svg.text("title", Anchor::Start, [10.0, 20.0], title);
    for tick in ticks(low, high) {
        svg.line("grid", [x(tick), TOP - 6.0], [x(tick), bottom]);
        svg.text("small", Anchor::Middle, [x(tick), TOP - 12.0], &tick.to_string());
    }
    for (index, bar) in bars.iter().enumerate() {
        let y = TOP + STEP * index as f64;
        svg.text("small", Anchor::End, [LABEL - 6.0, y + 12.0], &bar.label);
        svg.bar(bar.colour, [x(base), y + 2.0], [x(bar.figure), y + STEP - 4.0]);
        let end = x(bar.figure.max(base)) + 6.0;
        svg.text("small", Anchor::Start, [end, y + 12.0], &bar.note);
    }
    svg.line("axis", [x(base), TOP - 6.0], [x(base), bottom]);
    svg.finish(title)
}

#[cfg(test)]
mod tests {
    use super::super::svg::is_well_formed;
    use super::*;
    use crate::kernels::example;
    use crate::rays::Family;

    #[test]
    fn losses_have_their_own_colour_and_side() {
        let run = Run {
            kernels: vec![
                example("rilievo-default", Family::Primary, false, 8.0),
                example("embree-grid", Family::Primary, false, 4.0),
                example("rilievo-default", Family::Shadow, true, 2.0),
                example("embree-quad", Family::Shadow, true, 4.0),
            ],
            ..Run::default()
        };
        let plots = ratios(&run);
        assert_eq!(plots.len(), 1);
        let Plot { name, text } = &plots[0];
        assert_eq!(name, "ratios-1024.svg");
        assert!(is_well_formed(text) && !text.contains("NaN"), "{text}");
        let bars = text.lines().filter(|line| line.contains("<rect"));
        let is_loss: Vec<bool> = bars.map(|line| line.contains(LOSS)).collect();
        assert_eq!(is_loss, [false, true]);
        assert!(text.contains("2.00 (embree-grid)") && text.contains("0.50 (embree-quad)"));
    }

    #[test]
    fn transforms_are_drawn_with_their_peers() {
        let record = |contender: &str, ns_per_voxel| Transform {
            grid: "fbm-64x64".to_owned(),
            contender: contender.to_owned(),
            ns_per_voxel,
        };
        let plots = transforms(&[record("rilievo-boxes", 5.0), record("scipy", 80.0)]);
        assert!(is_well_formed(&plots[0].text));
        assert!(plots[0].text.contains("fbm-64x64 scipy"));
        assert!(transforms(&[]).is_empty());
    }
}

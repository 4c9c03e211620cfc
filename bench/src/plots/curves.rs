//! Figures by map size: rates, memory, build time.

use super::panel::{Curve, PANEL, Panel};
use super::svg::{Anchor, Svg};
use super::{ORDER, Plot, colour};
use crate::kernels::Record;

/// Panels side by side.
const COLUMNS: usize = 3;

const LEGEND: f64 = 34.0;

/// Mrays/s by size: a file a row, a panel a map.
pub fn rates(records: &[Record]) -> Vec<Plot> {
    let mut rows = Vec::new();
    for record in records {
        let row = (record.family, record.packet);
        if !rows.contains(&row) {
            rows.push(row);
        }
    }
    let plot = |(family, packet): (crate::rays::Family, bool)| {
        let of_row: Vec<&Record> =
            records.iter().filter(|r| (r.family, r.packet) == (family, packet)).collect();
        let panels = panels_by_map(&of_row, |r| r.mrays_per_s);
        let name = family.row_name(packet);
        let title = format!("{name}: million rays a second of one thread, by samples a side");
        Plot {
            name: format!("kernels-{}.svg", name.replace(' ', "-")),
            text: sheet(&title, &panels),
        }
    };
    rows.into_iter().map(plot).collect()
}

/// Memory and build time by size, a panel a map.
pub fn costs(records: &[Record]) -> Vec<Plot> {
    if records.is_empty() {
        return Vec::new();
    }
    let all: Vec<&Record> = records.iter().collect();
    let build = |r: &Record| r.build_seconds * 1e9 / (f64::from(r.size) * f64::from(r.size));
    vec![
        Plot {
            name: "memory.svg".to_owned(),
            text: sheet(
                "Bytes a texel beyond the heights, by samples a side",
                &panels_by_map(&all, |r| r.bytes_per_texel),
            ),
        },
        Plot {
            name: "build.svg".to_owned(),
            text: sheet(
                "Build, processor nanoseconds a texel, by samples a side",
                &panels_by_map(&all, build),
            ),
        },
    ]
}

/// A panel for each map, a curve for each contender: its best figure where it was called in several
/// ways.
fn panels_by_map<'a>(records: &[&'a Record], figure: impl Fn(&Record) -> f64) -> Vec<Panel<'a>> {
    let mut maps: Vec<&'a str> = Vec::new();
    for record in records {
        if !maps.contains(&record.map.as_str()) {
            maps.push(&record.map);
        }
    }
    let curve = |map: &str, contender: &str| {
        let mut points: Vec<(u32, f64)> = Vec::new();
        for record in records.iter().filter(|r| r.map == map && r.contender == contender) {
            let new = figure(record);
            match points.iter_mut().find(|(size, _)| *size == record.size) {
                Some((_, best)) => *best = best.max(new),
                None => points.push((record.size, new)),
            }
        }
        points.sort_unstable_by_key(|(size, _)| *size);
        Curve { colour: colour(contender), points }
    };
    let panel = |title: &'a str| Panel {
        title,
        curves: ORDER
            .iter()
            .map(|contender| curve(title, contender))
            .filter(|curve| !curve.points.is_empty())
            .collect(),
    };
    maps.into_iter().map(panel).collect()
}

/// A title, a legend and panels on one scale.
fn sheet(title: &str, panels: &[Panel<'_>]) -> String {
    let columns = panels.len().clamp(1, COLUMNS);
    let rows = panels.len().div_ceil(columns);
    let width = (PANEL[0] * columns as f64).max(620.0);
    let mut svg = Svg::new(width, 26.0 + LEGEND + PANEL[1] * rows as f64);
    svg.text("title", Anchor::Start, [10.0, 20.0], title);
    for (index, contender) in ORDER.iter().enumerate() {
        let x = 10.0 + 122.0 * index as f64;
        svg.bar(colour(contender), [x, 32.0], [x + 12.0, 44.0]);
        svg.text("small", Anchor::Start, [x + 17.0, 42.0], contender);
    }
    let ranges = || panels.iter().filter_map(Panel::range);
    let low = ranges().map(|[low, _]| low).fold(f64::INFINITY, f64::min);
    let high = ranges().map(|[_, high]| high).fold(0.0, f64::max);
    for (index, panel) in panels.iter().enumerate() {
        let [column, row] = [index % columns, index / columns].map(|n| n as f64);
        let corner = [PANEL[0] * column, 26.0 + LEGEND + PANEL[1] * row];
        panel.draw(&mut svg, corner, [low * 0.9, high * 1.1]);
    }
    svg.finish(title)
}

#[cfg(test)]
mod tests {
    use super::super::svg::is_well_formed;
    use super::*;
    use crate::kernels::example;
    use crate::rays::Family;

    #[test]
    fn every_row_has_its_sheet() {
        let mut records = vec![
            example("rilievo-default", Family::Primary, false, 8.0),
            example("embree-grid", Family::Primary, false, 4.0),
            example("embree-grid", Family::Shadow, true, 4.0),
        ];
        records.push(Record { size: 4096, mrays_per_s: 2.0, ..records[0].clone() });
        records.push(Record { map: "moss".to_owned(), ..records[0].clone() });
        let plots = rates(&records);
        let names: Vec<_> = plots.iter().map(|plot| plot.name.as_str()).collect();
        assert_eq!(names, ["kernels-primary.svg", "kernels-shadow-packets.svg"]);
        for plot in plots.iter().chain(&costs(&records)) {
            assert!(is_well_formed(&plot.text), "{}", plot.name);
            assert!(!plot.text.contains("NaN") && !plot.text.contains("inf"), "{}", plot.name);
        }
        assert_eq!(plots[0].text.matches("<polyline").count(), 3);
        assert!(plots[0].text.contains("moss") && plots[0].text.contains("4096"));
    }
}

//! `summary`: the tables of a run, in Markdown.

use std::collections::BTreeMap;
use std::path::Path;

use super::Run;
use super::comparison::{Comparison, Scope, geometric_mean};
use crate::kernels;
use crate::report::print;

/// Prints the tables of the run in `folder`.
///
/// # Errors
/// A run that cannot be read, or an output that cannot be written.
pub fn summary(folder: &Path) -> Result<(), String> {
    let run = Run::read(folder)?;
    text(&run).iter().try_for_each(|line| print(line))
}

/// All tables, line by line.
fn text(run: &Run) -> Vec<String> {
    let mut levels: Vec<&str> = run.kernels.iter().filter_map(kernels::Record::simd).collect();
    levels.sort_unstable();
    levels.dedup();
    let mut lines = vec![
        "Rays a second of one thread. Goal rows: primary, shadow, diffuse, primary16 packets on fbm, \
         gaussian, studded."
            .to_owned(),
    ];
    for level in levels {
        let rows = Comparison::all(run, Some(level));
        lines.extend([String::new(), format!("## rilievo ({level}) / best Embree"), String::new()]);
        lines.extend(means(&rows));
        lines.extend(rates(&rows));
    }
    lines.extend(memory(&run.kernels));
    if !run.builds.is_empty() {
        lines.extend(builds(run));
    }
    if !run.transforms.is_empty() {
        lines.extend(transforms(run));
    }
    lines
}

fn sizes(rows: &[Comparison]) -> Vec<u32> {
    let mut sizes: Vec<u32> = rows.iter().map(|row| row.size).collect();
    sizes.dedup();
    sizes
}

/// Geometric means and extremes of the ratios at each size.
fn means(rows: &[Comparison]) -> Vec<String> {
    let mut lines = vec![
        "| size | geometric mean, goal rows | smallest goal row | geometric mean, all rows | smallest row | tiny / default |"
            .to_owned(),
        "|---|---|---|---|---|---|".to_owned(),
    ];
    for size in sizes(rows) {
        let of = |scope| rows.iter().filter(move |row| row.size == size && row.is_in(scope));
        let mean = |scope| geometric_mean(of(scope).map(Comparison::ratio));
        let least = |scope| of(scope).min_by(|a, b| a.ratio().total_cmp(&b.ratio()));
        let named = |row: Option<&Comparison>| {
            row.map_or("-".to_owned(), |row| {
                format!("{:.2} ({} {})", row.ratio(), row.map, row.row_name())
            })
        };
        let tiny = of(Scope::All).filter_map(|row| Some(row.tiny? / row.rilievo));
        lines.push(format!(
            "| {size} | {} | {} | {} | {} | {} |",
            number(mean(Scope::Goal)),
            named(least(Scope::Goal)),
            number(mean(Scope::All)),
            named(least(Scope::All)),
            number(geometric_mean(tiny))
        ));
    }
    lines
}

fn number(value: Option<f64>) -> String {
    value.map_or("-".to_owned(), |value| format!("{value:.2}"))
}

/// Every row with its figures.
fn rates(rows: &[Comparison]) -> Vec<String> {
    let mut lines = vec![
        String::new(),
        "| map, size | rays | rilievo | tiny | best Embree | | ratio |".to_owned(),
        "|---|---|---|---|---|---|---|".to_owned(),
    ];
    for row in rows {
        let (name, rate) = &row.embree;
        // A loss stands out.
        let ratio = row.ratio();
        let ratio = if ratio < 1.0 { format!("**{ratio:.2}**") } else { format!("{ratio:.2}") };
        lines.push(format!(
            "| {} {} | {} | {:.2} | {} | {rate:.2} | {name} | {ratio} |",
            row.map,
            row.size,
            row.row_name(),
            row.rilievo,
            number(row.tiny)
        ));
    }
    lines
}

/// Memory and build time of every contender, the mean over the maps of a size.
fn memory(records: &[kernels::Record]) -> Vec<String> {
    type Sums = (u32, [f64; 3]);
    let mut sums: BTreeMap<(u32, &str), Sums> = BTreeMap::new();
    let mut seen: Vec<(&str, u32, &str)> = Vec::new();
    for record in records {
        let build = (record.map.as_str(), record.size, record.contender.as_str());
        if seen.contains(&build) {
            continue;
        }
        seen.push(build);
        let texels = f64::from(record.size) * f64::from(record.size);
        let figures = [
            record.build_seconds * 1e9 / texels,
            record.bytes_per_texel,
            record.peak_bytes_per_texel,
        ];
        let (count, sum) = sums.entry((record.size, &record.contender)).or_default();
        *count += 1;
        for (sum, figure) in sum.iter_mut().zip(figures) {
            *sum += figure;
        }
    }
    let mut lines = vec![
        String::new(),
        "| size | contender | build, CPU ns/texel | B/texel beyond the heights | peak B/texel |"
            .to_owned(),
        "|---|---|---|---|---|".to_owned(),
    ];
    for ((size, contender), (count, sum)) in sums {
        let [build, held, peak] = sum.map(|sum| sum / f64::from(count));
        lines.push(format!("| {size} | {contender} | {build:.2} | {held:.3} | {peak:.3} |"));
    }
    lines
}

fn builds(run: &Run) -> Vec<String> {
    let mut lines = vec![
        String::new(),
        "| size | layout | build, CPU ns/texel | B/texel | edit of 64 x 64, ms |".to_owned(),
        "|---|---|---|---|---|".to_owned(),
    ];
    lines.extend(run.builds.iter().map(|record| {
        let crate::builds::Record { size, layout, ns_per_texel, bytes_per_texel, edit_ms, .. } =
            record;
        format!("| {size} | {layout} | {ns_per_texel:.3} | {bytes_per_texel:.3} | {edit_ms:.4} |")
    }));
    lines
}

fn transforms(run: &Run) -> Vec<String> {
    let mut lines =
        vec![String::new(), "| grid | program | ns/voxel |".to_owned(), "|---|---|---|".to_owned()];
    lines.extend(run.transforms.iter().map(|record| {
        format!("| {} | {} | {:.2} |", record.grid, record.contender, record.ns_per_voxel)
    }));
    lines
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::example;
    use crate::rays::Family;

    #[test]
    fn tables_hold_means_losses_and_memory() {
        let mut run = Run {
            kernels: vec![
                example("rilievo-default", Family::Primary, false, 8.0),
                example("embree-grid", Family::Primary, false, 4.0),
                example("rilievo-default", Family::Shadow, true, 2.0),
                example("embree-quad", Family::Shadow, true, 4.0),
            ],
            ..Run::default()
        };
        for record in run.kernels.iter_mut().filter(|r| r.contender.starts_with("rilievo")) {
            record.against.insert("simd".to_owned(), "avx2".to_owned());
        }
        let text = text(&run).join("\n");
        for part in [
            "## rilievo (avx2) / best Embree",
            "| 1024 | 2.00 | 2.00 (fbm primary) | 1.00 | 0.50 (fbm shadow packets) | - |",
            "| fbm 1024 | shadow packets | 2.00 | - | 4.00 | embree-quad | **0.50** |",
            "| 1024 | embree-grid | 476.84 | 0.270 | 0.270 |",
        ] {
            assert!(text.contains(part), "{part} is not in\n{text}");
        }
    }
}

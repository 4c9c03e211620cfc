//! The table for people: one row a family, one column a contender.

use super::Record;
use crate::report::print;

/// Prints the records of one map and size.
///
/// # Errors
/// When standard output cannot be written.
pub fn print_table(records: &[Record]) -> Result<(), String> {
    text(records).iter().try_for_each(|line| print(line))
}

/// A column: contender and rays a call where it is called in packets.
fn column(record: &Record) -> String {
    if record.rays_a_call > 1 {
        format!("{} x{}", record.contender, record.rays_a_call)
    } else {
        record.contender.clone()
    }
}

fn text(records: &[Record]) -> Vec<String> {
    let Some(first) = records.first() else {
        return Vec::new();
    };
    let mut lines = vec![format!(
        "{} {} x {}, depth {}: Mrays/s of one thread, median of {} passes",
        first.map, first.size, first.size, first.depth, first.passes
    )];
    let mut seen: Vec<&str> = Vec::new();
    for record in records {
        if !seen.contains(&record.contender.as_str()) {
            seen.push(&record.contender);
            lines.push(format!(
                "  {:16} build {:.4} CPU s ({:.2} ns/texel), {:.3} B/texel (peak {:.3})",
                record.contender,
                record.build_seconds,
                record.build_seconds * 1e9 / (f64::from(record.size) * f64::from(record.size)),
                record.bytes_per_texel,
                record.peak_bytes_per_texel
            ));
        }
    }
    let rows = records.chunk_by(|a, b| (a.family, a.packet) == (b.family, b.packet));
    for row in rows {
        let family = row[0].family.row_name(row[0].packet);
        let hits = row[0].hits as f64 / row[0].rays as f64;
        lines.push(format!("  {family}: {} rays, {:.1} % hit", row[0].rays, hits * 100.0));
        for record in row {
            let name = column(record);
            let rate = record.mrays_per_s;
            lines.push(format!("    {name:20} {rate:8.3}  +-{:.0} %", record.spread * 50.0));
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::super::record::tests::example;
    use super::*;
    use crate::rays::Family;

    #[test]
    fn every_record_has_its_line() {
        let mut packet = example("embree-grid", Family::Primary16, true, 9.5);
        packet.rays_a_call = 16;
        let records = [
            example("rilievo-default", Family::Primary, false, 4.0),
            example("embree-grid", Family::Primary, false, 3.0),
            packet,
        ];
        let text = text(&records).join("\n");
        for part in ["fbm 1024", "4.000", "embree-grid x16", "primary16 packets", "50.0 % hit"] {
            assert!(text.contains(part), "{part}: {text}");
        }
        assert_eq!(text.matches("build").count(), 2);
    }
}

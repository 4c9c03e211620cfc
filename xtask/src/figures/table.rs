//! [`Table`]: Markdown tables, and numbers as they stand in them.

/// A table; the first column is text, the others are numbers and stand at the right.
pub struct Table {
    rows: Vec<Vec<String>>,
}

impl Table {
    pub fn new(head: &[&str]) -> Self {
        let head: Vec<_> = head.iter().map(|&cell| cell.to_owned()).collect();
        let rules = (0..head.len()).map(|i| if i == 0 { "---" } else { "---:" }.to_owned());
        Self { rows: vec![head.clone(), rules.collect()] }
    }

    pub fn row(&mut self, cells: Vec<String>) {
        self.rows.push(cells);
    }

    pub fn markdown(&self) -> String {
        self.rows.iter().map(|cells| format!("| {} |\n", cells.join(" | "))).collect()
    }
}

/// Seconds with about two digits; steps of a processor's clock are 10 ms.
pub fn seconds(s: f64) -> String {
    match s {
        s if s < 0.01 => "< 0.01".to_owned(),
        s if s < 10.0 => format!("{s:.2}"),
        s => format!("{s:.0}"),
    }
}

/// Bytes in MiB, with two digits at least.
pub fn mebibytes(bytes: f64) -> String {
    let mebi = bytes / f64::from(1 << 20);
    if mebi < 1.0 { format!("{mebi:.2} MiB") } else { format!("{mebi:.1} MiB") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_markdown() {
        let mut table = Table::new(&["a", "b"]);
        table.row(vec!["x".to_owned(), seconds(0.4)]);
        assert_eq!(table.markdown(), "| a | b |\n| --- | ---: |\n| x | 0.40 |\n");
    }

    #[test]
    fn numbers_keep_two_digits() {
        assert_eq!([0.0, 1.234, 61.7].map(seconds), ["< 0.01", "1.23", "62"]);
        assert_eq!(
            [1.5, 0.043].map(|mebi| mebibytes(mebi * 1024.0 * 1024.0)),
            ["1.5 MiB", "0.04 MiB"]
        );
    }
}

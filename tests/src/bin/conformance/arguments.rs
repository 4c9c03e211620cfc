//! What was typed.

/// What was typed.
pub struct Arguments {
    /// Rays a case.
    pub rays: u64,
    /// 0 for as many as there are cores.
    pub threads: usize,
    /// Whether cases are only named.
    pub list: bool,
    /// Whether only what is recorded is shown.
    pub table: bool,
    /// Parts of names.
    cases: Vec<String>,
}

impl Arguments {
    /// Reads the words after the program's name.
    pub fn parse(mut words: impl Iterator<Item = String>) -> Result<Self, String> {
        let mut all =
            Self { rays: 100_000, threads: 0, list: false, table: false, cases: Vec::new() };
        while let Some(word) = words.next() {
            let mut value = || words.next().ok_or(format!("{word} needs a value"));
            let number = |text: String| {
                text.parse::<u64>().map_err(|_| format!("{word}: '{text}' is no whole number"))
            };
            match word.as_str() {
                "--rays" => all.rays = number(value()?)?,
                "--threads" => all.threads = number(value()?)? as usize,
                "--case" => all.cases.push(value()?),
                "--list" => all.list = true,
                "--table" => all.table = true,
                _ => return Err(format!("unknown word '{word}'")),
            }
        }
        Ok(all)
    }

    /// Whether a case is to be gone through.
    pub fn asks_for(&self, name: &str) -> bool {
        self.cases.is_empty() || self.cases.iter().any(|part| name.contains(part.as_str()))
    }
}

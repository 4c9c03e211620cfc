//! Typed access to TOML with spans: every refusal knows its line.

use std::cell::RefCell;
use std::fmt::Write;
use std::ops::Range;
use std::path::Path;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

#[cfg(test)]
use super::asked;
use super::keys::{Key, Required};
use crate::error::{Error, Excerpt, Fault, Place, Result};

/// Most characters of a value that a message repeats.
const SHOWN: usize = 60;

/// A text being read, for its errors.
#[derive(Clone, Copy)]
pub(super) struct Document<'a> {
    pub path: &'a Path,
    pub text: &'a str,
}

impl Document<'_> {
    /// The fault of the piece `range`.
    pub fn fault(
        &self,
        range: &Range<usize>,
        what: impl Into<String>,
        found: impl Into<String>,
        allowed: impl Into<String>,
    ) -> Fault {
        let place = Place::Text(Excerpt::new(self.text, range.clone()));
        Fault::new(self.path, place, what, found, allowed)
    }

    /// The text is not TOML.
    pub fn syntax_error(&self, error: &toml::de::Error) -> Error {
        let range = error.span().unwrap_or(self.text.len()..self.text.len());
        // The parser's own words, on one line.
        let message = error.message().split_whitespace().collect::<Vec<_>>().join(" ");
        Error::Invalid(Box::new(self.fault(&range, "syntax", message, "TOML 1.0")))
    }
}

/// A value and where it stands.
#[derive(Clone, Debug, PartialEq)]
pub struct Located<T> {
    pub value: T,
    pub at: Range<usize>,
}

/// A table under its dotted name. Keys that nobody asked for are refused by [`Table::finish`].
pub(super) struct Table<'a> {
    doc: Document<'a>,
    name: String,
    entries: &'a DeTable<'a>,
    at: Range<usize>,
    known: RefCell<Vec<&'static str>>,
}

impl<'a> Table<'a> {
    /// The table of a whole document.
    pub fn root(doc: Document<'a>, root: &'a Spanned<DeTable<'a>>) -> Self {
        // What the document lacks is missing at its end.
        let at = doc.text.trim_end().len()..doc.text.len();
        Self { doc, name: String::new(), entries: root.get_ref(), at, known: RefCell::default() }
    }

    /// The table of a key that is missing: nothing is in it.
    pub fn without<K, M>(&self, key: &Key<K, M>, nothing: &'a DeTable<'a>) -> Self {
        let (name, at) = (self.child(key.name), self.at());
        Self { doc: self.doc, name, entries: nothing, at, known: RefCell::default() }
    }

    /// The value of a key, if it is there.
    pub fn get<K, M>(&self, key: &Key<K, M>) -> Option<Value<'a>> {
        let key = key.name;
        #[cfg(test)]
        asked::note(&self.name, key);
        let mut known = self.known.borrow_mut();
        if !known.contains(&key) {
            known.push(key);
        }
        let (_, value) = self.entries.iter().find(|(k, _)| k.get_ref() == key)?;
        Some(Value { doc: self.doc, name: self.child(key), value })
    }

    /// The value of a key that has to be there.
    pub fn require<K>(&self, key: &Key<K, Required>) -> Result<Value<'a>> {
        self.get(key).ok_or_else(|| self.lacks(key.name))
    }

    /// The key `key` is missing.
    pub fn lacks(&self, key: &str) -> Error {
        let found = format!("the key `{key}` is missing");
        self.invalid(self.name_or("scene"), found, format!("`{key}` is required here"))
    }

    /// All entries, whatever their keys.
    pub fn all(&self) -> impl Iterator<Item = (Located<String>, Value<'a>)> {
        self.entries.iter().map(|(key, value)| {
            let name = self.child(key.get_ref());
            let key = Located { value: key.get_ref().to_string(), at: key.span() };
            (key, Value { doc: self.doc, name, value })
        })
    }

    /// Refuses keys that were not asked for.
    pub fn finish(&self) -> Result<()> {
        let known = self.known.borrow();
        // The first in the file, not in the alphabet.
        let unknown = self.entries.keys().filter(|k| !known.contains(&&**k.get_ref()));
        let Some(key) = unknown.min_by_key(|k| k.span().start) else { return Ok(()) };
        let found = format!("unknown key `{}`{}", key.get_ref(), hint(key.get_ref(), &known));
        let fault = self.doc.fault(&key.span(), self.name_or("scene"), found, known.join(", "));
        Err(Error::Invalid(Box::new(fault)))
    }

    /// Where the table begins.
    pub fn at(&self) -> Range<usize> {
        self.at.clone()
    }

    /// The table's name, or `other` for the whole document.
    fn name_or(&self, other: &str) -> String {
        if self.name.is_empty() { other.to_owned() } else { self.name.clone() }
    }

    fn child(&self, key: &str) -> String {
        if self.name.is_empty() { key.to_owned() } else { format!("{}.{key}", self.name) }
    }

    /// The table as a whole is wrong.
    pub fn invalid(
        &self,
        what: impl Into<String>,
        found: impl Into<String>,
        allowed: impl Into<String>,
    ) -> Error {
        Error::Invalid(Box::new(self.doc.fault(&self.at, what, found, allowed)))
    }
}

/// A value under its dotted name.
#[derive(Clone)]
pub(super) struct Value<'a> {
    doc: Document<'a>,
    name: String,
    value: &'a Spanned<DeValue<'a>>,
}

impl<'a> Value<'a> {
    /// Where it stands.
    pub fn at(&self) -> Range<usize> {
        self.value.span()
    }

    /// The value as written, cut short.
    fn found(&self) -> String {
        let text = self.doc.text.get(self.value.span()).unwrap_or_default();
        let line = text.split_whitespace().collect::<Vec<_>>().join(" ");
        match line.char_indices().nth(SHOWN) {
            Some((end, _)) => format!("{}...", &line[..end]),
            None => line,
        }
    }

    /// The value is not allowed.
    pub fn invalid(&self, allowed: impl Into<String>) -> Error {
        Error::Invalid(Box::new(self.fault(self.found(), allowed)))
    }

    fn fault(&self, found: impl Into<String>, allowed: impl Into<String>) -> Fault {
        self.doc.fault(&self.value.span(), &self.name, found, allowed)
    }

    fn wrong_type(&self, allowed: &str) -> Error {
        let found = match self.value.get_ref() {
            DeValue::Table(_) => "a table".to_owned(),
            other => format!("{} ({})", self.found(), other.type_str()),
        };
        Error::Invalid(Box::new(self.fault(found, allowed)))
    }

    /// Text.
    pub fn text(&self) -> Result<&'a str> {
        self.value.get_ref().as_str().ok_or_else(|| self.wrong_type("a string"))
    }

    /// Text that is not empty, with its place.
    pub fn name(&self) -> Result<Located<String>> {
        match self.text()? {
            "" => Err(self.invalid("a string that is not empty")),
            text => Ok(Located { value: text.to_owned(), at: self.at() }),
        }
    }

    /// `true` or `false`.
    pub fn boolean(&self) -> Result<bool> {
        self.value.get_ref().as_bool().ok_or_else(|| self.wrong_type("true or false"))
    }

    /// One of a closed set of words.
    pub fn choice<T: Copy>(&self, all: &[(&'static str, T)]) -> Result<T> {
        let text = self.text()?;
        if let Some(&(_, value)) = all.iter().find(|(name, _)| *name == text) {
            return Ok(value);
        }
        let names: Vec<_> = all.iter().map(|(name, _)| *name).collect();
        let allowed: Vec<_> = names.iter().map(|name| format!("\"{name}\"")).collect();
        let found = format!("{}{}", self.found(), hint(text, &names));
        Err(Error::Invalid(Box::new(self.fault(found, allowed.join(", ")))))
    }

    /// A finite number, whole or not.
    pub fn number(&self) -> Result<f64> {
        let number = match self.value.get_ref() {
            DeValue::Integer(i) => self.whole(i.as_str(), i.radix()).map(|i| i as f64),
            DeValue::Float(f) => f.as_str().parse().ok(),
            _ => return Err(self.wrong_type("a number")),
        };
        number.filter(|n: &f64| n.is_finite()).ok_or_else(|| self.invalid("a finite number"))
    }

    /// A whole number that `allows` takes; `allowed` says so in words.
    pub fn integer<T>(&self, allows: impl Fn(&T) -> bool, allowed: &str) -> Result<T>
    where
        T: TryFrom<i128>,
    {
        let DeValue::Integer(integer) = self.value.get_ref() else {
            return Err(self.wrong_type(allowed));
        };
        self.whole(integer.as_str(), integer.radix())
            .and_then(|i| T::try_from(i).ok())
            .filter(allows)
            .ok_or_else(|| self.invalid(allowed))
    }

    fn whole(&self, digits: &str, radix: u32) -> Option<i128> {
        i128::from_str_radix(digits, radix).ok()
    }

    /// The `N` values of an array, each as `read` reads it; `allowed` in words.
    pub fn array<T, const N: usize>(
        &self,
        allowed: &str,
        read: impl Fn(&Value<'a>) -> Result<T>,
    ) -> Result<[T; N]> {
        let items = self.items(allowed)?;
        let wrong = |count: usize| {
            let found = format!("{} ({count} values)", self.found());
            Error::Invalid(Box::new(self.fault(found, allowed)))
        };
        if items.len() != N {
            return Err(wrong(items.len()));
        }
        let values: Vec<T> = items.iter().map(read).collect::<Result<_>>()?;
        values.try_into().map_err(|values: Vec<T>| wrong(values.len()))
    }

    /// The values of an array.
    pub fn items(&self, allowed: &str) -> Result<Vec<Value<'a>>> {
        let array = self.value.get_ref().as_array().ok_or_else(|| self.wrong_type(allowed))?;
        Ok((array.iter().enumerate())
            .map(|(k, value)| Value { doc: self.doc, name: format!("{}[{k}]", self.name), value })
            .collect())
    }

    /// A table.
    pub fn table(&self) -> Result<Table<'a>> {
        let entries = self.value.get_ref().as_table().ok_or_else(|| self.wrong_type("a table"))?;
        Ok(Table {
            doc: self.doc,
            name: self.name.clone(),
            entries,
            at: self.at(),
            known: RefCell::default(),
        })
    }

    /// Whether it is a table.
    pub fn is_table(&self) -> bool {
        self.value.get_ref().is_table()
    }
}

/// `; did you mean ...` for the nearest of `known`, if one is near.
pub(super) fn hint(word: &str, known: &[&str]) -> String {
    let near = known.iter().map(|k| (distance(word, k), *k)).min();
    match near {
        // A third of the letters may differ.
        Some((steps, name)) if steps * 3 <= name.len().min(word.len()) => {
            format!("; did you mean `{name}`?")
        }
        _ => String::new(),
    }
}

/// Insertions, deletions, changes and swaps of neighbours that turn `a` into `b`.
fn distance(a: &str, b: &str) -> usize {
    let (a, b): (Vec<_>, Vec<_>) = (a.chars().take(SHOWN).collect(), b.chars().collect());
    let mut rows = vec![(0..=b.len()).collect::<Vec<_>>()];
    for i in 1..=a.len() {
        let mut row = vec![i];
        for j in 1..=b.len() {
            let change = rows[i - 1][j - 1] + usize::from(a[i - 1] != b[j - 1]);
            let mut best = change.min(rows[i - 1][j] + 1).min(row[j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                best = best.min(rows[i - 2][j - 2] + 1);
            }
            row.push(best);
        }
        rows.push(row);
    }
    rows[a.len()][b.len()]
}

/// `text` as a TOML string.
pub(crate) fn quoted(text: &str) -> String {
    let mut quoted = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => quoted.extend(['\\', c]),
            c if c.is_control() => {
                let _ = write!(quoted, "\\u{:04X}", c as u32);
            }
            c => quoted.push(c),
        }
    }
    quoted + "\""
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_words_are_found() {
        assert_eq!(distance("positon", "position"), 1);
        assert_eq!(distance("ab", "ba"), 1);
        assert_eq!(distance("", "abc"), 3);
        assert_eq!(hint("fvo", &["position", "fov"]), "; did you mean `fov`?");
        assert_eq!(hint("colour", &["fov", "up"]), "");
        assert_eq!(hint("x", &[]), "");
    }

    #[test]
    fn values_are_read_with_their_places() {
        const fn key(name: &'static str) -> Key<(), Required> {
            Key::new(name, (), Required(""), "")
        }
        let text = "a = 0x10\nb = 1_000.5\nc = [1, 2.5]\nd = -1\ne = inf\nf = \"w\"\n";
        let doc = Document { path: Path::new("t"), text };
        let parsed = DeTable::parse(text).unwrap();
        let root = Table::root(doc, &parsed);
        let get = |name| root.require(&key(name)).unwrap();
        assert_eq!(get("a").integer(|n: &u32| *n <= 16, "").unwrap(), 16);
        assert_eq!(get("b").number().unwrap(), 1000.5);
        assert_eq!(get("c").array::<_, 2>("two", Value::number).unwrap(), [1.0, 2.5]);
        assert_eq!(get("d").number().unwrap(), -1.0);
        let message = |e: Error| e.to_string().lines().next().unwrap().to_owned();
        let e = get("a").integer(|n: &u32| *n < 16, "less").unwrap_err();
        assert_eq!(message(e), "t:1:5: a: 0x10; allowed: less");
        assert!(message(get("e").number().unwrap_err()).contains("e: inf; allowed: a finite"));
        let e = get("c").array::<_, 3>("three", Value::number).unwrap_err();
        assert!(message(e).contains("(2 values)"));
        assert!(message(get("f").number().unwrap_err()).contains("\"w\" (string)"));
        assert!(root.finish().is_ok());
        let lacking = root.require(&key("g")).err().unwrap();
        assert!(message(lacking).contains("the key `g` is missing"));
    }
}

//! Words of a closed set.

use super::super::super::syntax::Value;
use super::{Kind, Read};
use crate::error::Result;

/// One of a closed set of words, with what each stands for.
#[derive(Clone, Copy, Debug)]
pub struct Choice<T: 'static>(pub fn() -> Vec<(&'static str, T)>);

impl<T: Copy + PartialEq> Kind for Choice<T> {
    type Value = T;

    fn name(&self) -> String {
        "string".into()
    }

    fn allowed(&self) -> String {
        let words: Vec<_> = (self.0)().iter().map(|(word, _)| format!("`\"{word}\"`")).collect();
        words.join(", ")
    }

    fn written(&self, value: &T) -> String {
        let word = (self.0)().into_iter().find(|(_, named)| named == value);
        word.map_or(String::new(), |(word, _)| format!("\"{word}\""))
    }
}

impl<T: Copy + PartialEq> Read for Choice<T> {
    fn read(&self, value: &Value<'_>) -> Result<T> {
        value.choice(&(self.0)())
    }
}

/// One choice along u and v, or one along each.
#[derive(Clone, Copy, Debug)]
pub struct OneOrTwo<T: 'static>(pub Choice<T>);

impl<T: Copy + PartialEq> Kind for OneOrTwo<T> {
    type Value = [T; 2];

    fn name(&self) -> String {
        "string, or two".into()
    }

    fn allowed(&self) -> String {
        self.0.allowed()
    }

    fn written(&self, value: &[T; 2]) -> String {
        match value {
            [u, v] if u == v => self.0.written(u),
            [u, v] => format!("[{}, {}]", self.0.written(u), self.0.written(v)),
        }
    }
}

impl<T: Copy + PartialEq> Read for OneOrTwo<T> {
    fn read(&self, value: &Value<'_>) -> Result<[T; 2]> {
        match value.text() {
            Ok(_) => Ok([self.0.read(value)?; 2]),
            Err(_) => {
                value.array("a string, or two: [along u, along v]", |value| self.0.read(value))
            }
        }
    }
}

/// What `K` is, or a table.
#[derive(Clone, Copy, Debug)]
pub struct OrTable<K>(pub K);

impl<K: Kind> Kind for OrTable<K> {
    type Value = K::Value;

    fn name(&self) -> String {
        format!("{} or table", self.0.name())
    }

    fn allowed(&self) -> String {
        self.0.allowed()
    }

    fn written(&self, value: &K::Value) -> String {
        self.0.written(value)
    }
}

/// The first; the caller looks for a table before.
impl<K: Read> Read for OrTable<K> {
    fn read(&self, value: &Value<'_>) -> Result<K::Value> {
        self.0.read(value)
    }
}

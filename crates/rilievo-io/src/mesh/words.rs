//! [`Words`]: text of lines and words that knows where each stands: OBJ, MTL and the like.

use std::ops::Range;
use std::path::Path;
use std::str::FromStr;

use crate::error::{Error, Excerpt, Place};

/// A word of a text and where it stands.
pub(super) type Word<'a> = (&'a str, Range<usize>);

/// A text being read, for its errors.
#[derive(Clone, Copy)]
pub(super) struct Words<'a> {
    /// What errors call it.
    pub path: &'a Path,
    /// All of it.
    pub text: &'a str,
}

impl<'a> Words<'a> {
    /// The lines; one that ends in a backslash goes on in the next.
    pub fn lines(self) -> impl Iterator<Item = Range<usize>> + use<'a> {
        let mut start = 0;
        std::iter::from_fn(move || {
            let line = (start < self.text.len()).then(|| start..self.line_end(start))?;
            start = line.end + 1;
            Some(line)
        })
    }

    fn line_end(&self, start: usize) -> usize {
        let mut from = start;
        loop {
            let Some(length) = self.text[from..].find('\n') else { return self.text.len() };
            let end = from + length;
            if !self.text[from..end].trim_end_matches('\r').ends_with('\\') {
                return end;
            }
            from = end + 1;
        }
    }

    /// The words of a line, without comment and continuation marks.
    pub fn words(self, line: Range<usize>) -> impl Iterator<Item = Word<'a>> + use<'a> {
        let text = self.text;
        let stop = text[line.clone()].find('#').map_or(line.end, |at| line.start + at);
        text[line.start..stop].split([' ', '\t', '\r', '\n', '\\']).filter(|w| !w.is_empty()).map(
            move |word| {
                let at = word.as_ptr() as usize - text.as_ptr() as usize;
                (word, at..at + word.len())
            },
        )
    }

    /// The next `N` words as finite numbers; `at` is the key they belong to.
    pub fn numbers<const N: usize>(
        &self,
        words: &mut impl Iterator<Item = Word<'a>>,
        at: Range<usize>,
        allowed: &str,
    ) -> Result<[f64; N], Error> {
        let mut all = [0.0; N];
        for (place, slot) in all.iter_mut().enumerate() {
            let word = words.next().ok_or_else(|| {
                self.fault(at.clone(), "numbers", format!("only {place}"), allowed)
            })?;
            *slot = self.number(word, allowed)?;
        }
        Ok(all)
    }

    /// A word as a finite number.
    pub fn number(&self, (word, at): Word<'a>, allowed: &str) -> Result<f64, Error> {
        match f64::from_str(word) {
            Ok(number) if number.is_finite() => Ok(number),
            _ => Err(self.fault(at, "number", format!("{word:?}"), allowed)),
        }
    }

    /// The piece `at` is wrong.
    pub fn fault(&self, at: Range<usize>, what: &str, found: String, allowed: &str) -> Error {
        Error::invalid(self.path, Place::Text(Excerpt::new(self.text, at)), what, found, allowed)
    }
}

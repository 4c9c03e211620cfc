//! [`Error`]: why a file was not read or written.
//!
//! Every variant names the file; all but [`Error::Io`] name the place in it, the value found and
//! the values allowed. [`Display`](std::fmt::Display) prints all of it, for text files with the
//! source line and a caret below the value:
//!
//! ```text
//! scene.toml:4:7: camera.fov: 190 is not allowed; allowed: a number above 0 and below 180
//!   |
//! 4 | fov = 190
//!   |       ^^^
//! ```

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

/// Result of reading or writing a file.
pub type Result<T> = std::result::Result<T, Error>;

/// Why a file was not read or written.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The system refused: no such file, no permission, disk full.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The content breaks the rules of its format.
    #[error("{0}")]
    Invalid(Box<Fault>),
    /// The content may be sound, but this library does not read or write it.
    #[error("{0}")]
    Unsupported(Box<Fault>),
    /// The content needs more memory than [`Limits`](crate::Limits) allow.
    #[error("{}: {place}: {what} needs {needed} bytes; allowed: at most {allowed} bytes", path.display())]
    Limit {
        /// The file.
        path: PathBuf,
        /// Where the size is declared.
        place: Place,
        /// What would be allocated.
        what: String,
        /// Bytes it needs.
        needed: u64,
        /// Bytes allowed.
        allowed: u64,
    },
    /// A file named in another file was not read.
    #[error("{fault}\n{source}")]
    Reference {
        /// Where the file is named.
        fault: Box<Fault>,
        /// What is wrong with the named file.
        source: Box<Error>,
    },
}

/// A value that is not allowed, and where it stands.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    /// The file.
    pub path: PathBuf,
    /// Where in it.
    pub place: Place,
    /// What the value is, in the words of the format: `camera.fov`, `width`.
    pub what: String,
    /// The value found.
    pub found: String,
    /// The values allowed; empty where the format has no such list.
    pub allowed: String,
}

/// A place in a file.
#[derive(Clone, Debug, PartialEq)]
pub enum Place {
    /// The file as a whole.
    File,
    /// Its header.
    Header,
    /// A sample of an image, counted from the top left.
    Sample {
        /// Column.
        x: u32,
        /// Row.
        y: u32,
    },
    /// A value of a JSON document, by its pointer (RFC 6901).
    Pointer(String),
    /// A piece of text.
    Text(Excerpt),
}

/// A piece of a text file: where it stands, and the line around it.
#[derive(Clone, Debug, PartialEq)]
pub struct Excerpt {
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// Characters of the piece that stand on this line.
    pub width: usize,
    /// The line itself.
    pub text: String,
}

impl Excerpt {
    /// The excerpt for the bytes `range` of `text`. A range beyond the end means the end.
    pub fn new(text: &str, range: std::ops::Range<usize>) -> Self {
        let floor = |at: usize| {
            let mut at = at.min(text.len());
            while !text.is_char_boundary(at) {
                at -= 1;
            }
            at
        };
        let (start, end) = (floor(range.start), floor(range.end));
        let line_start = text[..start].rfind('\n').map_or(0, |at| at + 1);
        let line_end = text[start..].find('\n').map_or(text.len(), |at| start + at);
        let stop = end.clamp(start, line_end);
        Self {
            line: text[..line_start].matches('\n').count() + 1,
            column: text[line_start..start].chars().count() + 1,
            width: text[start..stop].chars().count().max(1),
            text: text[line_start..line_end].trim_end_matches('\r').to_owned(),
        }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File => f.write_str("file"),
            Self::Header => f.write_str("header"),
            Self::Sample { x, y } => write!(f, "sample ({x}, {y}) from the top left"),
            Self::Pointer(pointer) => f.write_str(pointer),
            Self::Text(e) => write!(f, "{}:{}", e.line, e.column),
        }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let path = self.path.display();
        match &self.place {
            Place::Text(e) => write!(f, "{path}:{}:{}: ", e.line, e.column)?,
            Place::File => write!(f, "{path}: ")?,
            place => write!(f, "{path}: {place}: ")?,
        }
        write!(f, "{}: {}", self.what, self.found)?;
        if !self.allowed.is_empty() {
            write!(f, "; allowed: {}", self.allowed)?;
        }
        if let Place::Text(e) = &self.place {
            let (number, blank) = (e.line.to_string(), " ".repeat(e.line.to_string().len()));
            // Tabs stay tabs, so that the caret stands below its value whatever their width.
            let indent: String = (e.text.chars().take(e.column - 1))
                .map(|c| if c == '\t' { '\t' } else { ' ' })
                .collect();
            write!(f, "\n{blank} |\n{number} | {}\n", e.text)?;
            write!(f, "{blank} | {indent}{}", "^".repeat(e.width))?;
        }
        Ok(())
    }
}

impl Error {
    /// The system refused an operation on `path`.
    pub(crate) fn io(path: &Path, source: io::Error) -> Self {
        Self::Io { path: path.to_owned(), source }
    }

    /// The content of `path` breaks its format.
    pub(crate) fn invalid(
        path: &Path,
        place: Place,
        what: impl Into<String>,
        found: impl Into<String>,
        allowed: impl Into<String>,
    ) -> Self {
        Self::Invalid(Box::new(Fault::new(path, place, what, found, allowed)))
    }

    /// The content of `path` is of a kind this library does not handle.
    pub(crate) fn unsupported(
        path: &Path,
        place: Place,
        what: impl Into<String>,
        found: impl Into<String>,
        allowed: impl Into<String>,
    ) -> Self {
        Self::Unsupported(Box::new(Fault::new(path, place, what, found, allowed)))
    }

    /// The file at fault.
    pub fn path(&self) -> &Path {
        match self {
            Self::Io { path, .. } | Self::Limit { path, .. } => path,
            Self::Invalid(fault) | Self::Unsupported(fault) => &fault.path,
            Self::Reference { source, .. } => source.path(),
        }
    }
}

impl Fault {
    /// A fault.
    pub(crate) fn new(
        path: &Path,
        place: Place,
        what: impl Into<String>,
        found: impl Into<String>,
        allowed: impl Into<String>,
    ) -> Self {
        Self {
            path: path.to_owned(),
            place,
            what: what.into(),
            found: found.into(),
            allowed: allowed.into(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_faults_show_the_line_with_a_caret_below_the_value() {
        let text = "[camera]\n\tfov = 190 # wide\n";
        let at = text.find("190").unwrap();
        let place = Place::Text(Excerpt::new(text, at..at + 3));
        let e = Error::invalid(Path::new("a.toml"), place, "camera.fov", "190", "below 180");
        assert_eq!(
            e.to_string(),
            "a.toml:2:8: camera.fov: 190; allowed: below 180\n  |\n2 | \tfov = 190 # wide\n  | \t      ^^^"
        );
    }

    #[test]
    fn excerpts_stay_inside_their_text() {
        for (text, range) in [("", 0..0), ("ä", 1..9), ("a\nb", 1..3), ("a\r\n", 7..9)] {
            let e = Excerpt::new(text, range);
            assert!(e.line >= 1 && e.column >= 1 && e.width >= 1);
            assert!(!e.text.contains('\n'));
        }
        assert_eq!(Excerpt::new("a\nbc\n", 3..4).line, 2);
        assert_eq!(Excerpt::new("a\nbc\n", 3..4).column, 2);
    }
}

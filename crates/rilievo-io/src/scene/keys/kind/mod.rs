//! Kinds of values: how each is read, what it allows, and how both are put in words.

mod array;
mod choice;
mod number;

use super::super::syntax::{Located, Value};
use crate::error::Result;
use crate::texture_set::MapRole;

pub use array::{Colour, Each, Grey, Point, Points, Span, along_uv};
pub use choice::{Choice, OneOrTwo, OrTable};
pub use number::{Codes, Integer, Number};

/// A kind of value, in words.
pub trait Kind {
    /// What is read.
    type Value;

    /// Its name.
    fn name(&self) -> String;

    /// The values allowed.
    fn allowed(&self) -> String;

    /// A value as in a scene file.
    fn written(&self, value: &Self::Value) -> String;
}

/// A kind of value that is read by itself.
pub trait Read: Kind {
    /// The value, if it is allowed.
    ///
    /// # Errors
    /// Names what is.
    fn read(&self, value: &Value<'_>) -> Result<Self::Value>;
}

/// A kind of value that stands in arrays.
pub trait Item: Read {
    /// `count` of them, with what they allow: `two numbers above 0`.
    fn count(&self, count: usize) -> String;
}

/// `true` or `false`.
#[derive(Clone, Copy, Debug)]
pub struct Flag;

impl Kind for Flag {
    type Value = bool;

    fn name(&self) -> String {
        "boolean".into()
    }

    fn allowed(&self) -> String {
        "`true`, `false`".into()
    }

    fn written(&self, value: &bool) -> String {
        value.to_string()
    }
}

impl Read for Flag {
    fn read(&self, value: &Value<'_>) -> Result<bool> {
        value.boolean()
    }
}

/// Text that is not empty, by what it is: a path, a name.
#[derive(Clone, Copy, Debug)]
pub struct Text(pub &'static str);

impl Kind for Text {
    type Value = Located<String>;

    fn name(&self) -> String {
        self.0.into()
    }

    fn allowed(&self) -> String {
        String::new()
    }

    fn written(&self, value: &Located<String>) -> String {
        format!("\"{}\"", value.value)
    }
}

impl Read for Text {
    fn read(&self, value: &Value<'_>) -> Result<Located<String>> {
        value.name()
    }
}

impl Item for Text {
    fn count(&self, count: usize) -> String {
        counted(count, self.0)
    }
}

/// A number from 0 to 1 or a colour of such, or an image of them: an input of a material.
#[derive(Clone, Copy, Debug)]
pub struct Input(pub MapRole);

impl Kind for Input {
    type Value = f64;

    fn name(&self) -> String {
        "input".into()
    }

    fn allowed(&self) -> String {
        "0 to 1".into()
    }

    fn written(&self, value: &f64) -> String {
        value.to_string()
    }
}

/// What has keys of its own: a table, several, or an image.
#[derive(Clone, Copy, Debug)]
pub struct Form(pub &'static str);

impl Kind for Form {
    type Value = ();

    fn name(&self) -> String {
        self.0.into()
    }

    fn allowed(&self) -> String {
        String::new()
    }

    fn written(&self, _: &()) -> String {
        String::new()
    }
}

/// `a number`, `two numbers`.
fn counted(count: usize, noun: &str) -> String {
    match count {
        1 => format!("a {noun}"),
        2 => format!("two {noun}s"),
        3 => format!("three {noun}s"),
        4 => format!("four {noun}s"),
        _ => format!("{count} {noun}s"),
    }
}

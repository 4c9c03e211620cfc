//! Every key of a scene file, stated once: what the parser accepts, what holds without the key, the lists
//! in error messages, and the tables of docs/SCENE.md.
//!
//! A [`Key`] is a name, a kind of value ([`kind`]) with its range or its choices, what holds where the
//! key is missing, and what it means. The parser (`scene::file`) reads through these constants alone: a
//! [`Table`] gives no value by a bare string. docs/SCENE.md holds the same constants as tables after
//! lines `<!-- keys: SECTION -->`; `cargo xtask reference` writes them there. Tests hold that the page
//! is what is said here, and that each key here is one that the parser asks for.
//!
//! Where a rule spans several keys ("not with `file`") it stands in the meaning, in words, and in the
//! parser.

pub mod camera;
pub mod kind;
pub mod light;
pub mod map;
pub mod material;
pub mod model;
pub mod motion;
mod page;
pub mod place;
pub mod render;
pub mod scene;
pub mod shape;

use super::syntax::{Located, Table, Value};
use crate::error::{Error, Result};
use kind::{Kind, Read};

pub use page::reference;

/// A key of a table of a scene file. `K` is what kind of value it takes, `M` what holds without it:
/// [`Required`], [`Fallback`] or [`Optional`].
#[derive(Clone, Debug)]
pub struct Key<K, M> {
    /// Its name.
    pub name: &'static str,
    /// The values allowed.
    pub kind: K,
    /// What holds without it.
    pub missing: M,
    /// The unit of its numbers, or nothing.
    pub unit: &'static str,
    /// What it means.
    pub meaning: &'static str,
}

/// What holds where a key is missing, if its value is a `T`.
pub trait Missing<T> {
    /// What reading the key gives.
    type Read;

    /// It is there.
    fn found(value: T) -> Self::Read;

    /// It is missing: what holds, or none where that is an error.
    fn missing(&self) -> Option<Self::Read>;

    /// What holds, in words; `written` puts a value as in a scene file.
    fn words(&self, written: &dyn Fn(&T) -> String) -> String;
}

/// A missing key is an error. The text is empty, or names those that require it: `of a sun`.
#[derive(Clone, Copy, Debug)]
pub struct Required(pub &'static str);

/// This value holds where the key is missing.
#[derive(Clone, Copy, Debug)]
pub struct Fallback<T>(pub T);

/// Without the key the reader finds the value elsewhere: where, in words.
#[derive(Clone, Copy, Debug)]
pub struct Optional(pub &'static str);

impl<T> Missing<T> for Required {
    type Read = T;

    fn found(value: T) -> T {
        value
    }

    fn missing(&self) -> Option<T> {
        None
    }

    fn words(&self, _written: &dyn Fn(&T) -> String) -> String {
        format!("required {}", self.0).trim_end().to_owned()
    }
}

impl<T: Clone> Missing<T> for Fallback<T> {
    type Read = T;

    fn found(value: T) -> T {
        value
    }

    fn missing(&self) -> Option<T> {
        Some(self.0.clone())
    }

    fn words(&self, written: &dyn Fn(&T) -> String) -> String {
        format!("`{}`", written(&self.0))
    }
}

impl<T> Missing<T> for Optional {
    type Read = Option<T>;

    fn found(value: T) -> Option<T> {
        Some(value)
    }

    fn missing(&self) -> Option<Option<T>> {
        Some(None)
    }

    fn words(&self, _written: &dyn Fn(&T) -> String) -> String {
        self.0.to_owned()
    }
}

impl<K, M> Key<K, M> {
    /// A key of no unit.
    pub const fn new(name: &'static str, kind: K, missing: M, meaning: &'static str) -> Self {
        Self { name, kind, missing, unit: "", meaning }
    }

    /// The same, its numbers in a unit.
    pub const fn unit(mut self, unit: &'static str) -> Self {
        self.unit = unit;
        self
    }
}

impl<K: Read, M: Missing<K::Value>> Key<K, M> {
    /// What a table says, or what holds without it.
    ///
    /// # Errors
    /// A missing key that is required; a value that is not allowed.
    pub fn of(&self, table: &Table<'_>) -> Result<M::Read> {
        self.located(table).map(|located| located.value)
    }

    /// The same, with the place of the value; of what is missing, that of the table.
    pub fn located(&self, table: &Table<'_>) -> Result<Located<M::Read>> {
        if let Some(value) = table.get(self) {
            return Ok(Located { value: M::found(self.read(&value)?), at: value.at() });
        }
        match self.missing.missing() {
            Some(value) => Ok(Located { value, at: table.at() }),
            None => Err(table.lacks(self.name)),
        }
    }
}

impl<K: Read, M> Key<K, M> {
    /// What a value of this key says.
    ///
    /// # Errors
    /// It is not allowed; the message names the unit.
    pub fn read(&self, value: &Value<'_>) -> Result<K::Value> {
        self.kind.read(value).map_err(|error| match error {
            Error::Invalid(mut fault) if !self.unit.is_empty() => {
                fault.allowed += &format!(" ({})", self.unit);
                Error::Invalid(fault)
            }
            error => error,
        })
    }
}

/// A key as a row of a table of docs/SCENE.md.
pub trait Row {
    /// Its name.
    fn name(&self) -> &'static str;

    /// Kind of value, unit, what holds without it, values allowed, meaning.
    fn cells(&self) -> [String; 5];
}

impl<K: Kind, M: Missing<K::Value>> Row for Key<K, M> {
    fn name(&self) -> &'static str {
        self.name
    }

    fn cells(&self) -> [String; 5] {
        let missing = self.missing.words(&|value| self.kind.written(value));
        [self.kind.name(), self.unit.into(), missing, self.kind.allowed(), self.meaning.into()]
    }
}

/// Keys that are told together.
pub struct Section {
    /// Its name in docs/SCENE.md.
    pub name: &'static str,
    /// The table of a scene file that they stand in: `NAME` for a name of the author's, `[]` for a
    /// place in an array.
    pub table: &'static str,
    /// The keys.
    pub keys: &'static [&'static dyn Row],
}

/// All keys.
pub const SECTIONS: &[Section] = &[
    scene::SCENE,
    camera::CAMERA,
    render::RENDER,
    light::LIGHTS,
    light::ENVIRONMENT,
    map::MAPS,
    material::MATERIALS,
    material::IMAGE,
    material::PAPER,
    model::MODELS,
    model::PRINCIPLED,
    material::NORMALS,
    shape::SHAPES,
    place::PLACES,
    shape::QUAD,
    shape::DISPLACEMENT,
    shape::SPHERE,
    shape::MESH,
    shape::TERRAIN,
    camera::MOTION,
    motion::SHAPE,
    motion::PLACE,
    map::DISTANCE,
    place::PLACE,
    place::DISPLACEMENT,
    place::SCATTER,
    shape::NORMALS,
    place::TRANSFORM,
];

#[cfg(test)]
mod tests {
    use std::collections::{BTreeMap, BTreeSet};
    use std::path::Path;

    use super::super::{SceneFile, asked};
    use super::*;

    /// A shape and a metal that the valid scenes of the tests lack.
    const REST: &str = "[camera]\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\n\
        [[shapes]]\ntype = \"terrain\"\nmap = \"ground\"\n\
        [materials.metal]\nmodel = \"conductor\"\neta = [1, 1, 1]\nk = [3, 3, 3]\n";

    #[test]
    fn every_key_here_is_one_that_the_parser_asks_for() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/scenes/valid");
        asked::start();
        for entry in std::fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_some_and(|extension| extension == "toml") {
                let text = std::fs::read_to_string(&path).unwrap();
                SceneFile::parse(&text, &path).unwrap();
            }
        }
        SceneFile::parse(REST, Path::new("rest.toml")).unwrap();
        let mut told: BTreeMap<String, BTreeSet<&str>> = BTreeMap::new();
        for section in SECTIONS {
            let keys = section.keys.iter().map(|key| key.name());
            told.entry(section.table.to_owned()).or_default().extend(keys);
        }
        let asked = asked::finish();
        for (table, keys) in &asked {
            let empty = BTreeSet::new();
            let told = told.get(table).unwrap_or(&empty);
            let missing: Vec<_> = keys.difference(told).collect();
            assert!(missing.is_empty(), "{table:?}: {missing:?} are read, but in no section");
            let idle: Vec<_> = told.difference(keys).collect();
            assert!(
                idle.is_empty(),
                "{table:?}: {idle:?} are in a section, but no valid test scene has them read"
            );
        }
        let tables: Vec<_> = told.keys().filter(|table| !asked.contains_key(*table)).collect();
        assert!(tables.is_empty(), "{tables:?} are in a section, but in no valid test scene");
    }

    #[test]
    fn a_key_gives_its_value_its_default_and_its_errors() {
        use super::super::syntax::Document;
        use toml::de::DeTable;

        const ANGLE: Key<kind::Number, Fallback<f64>> =
            Key::new("angle", kind::Number::AboveUpTo(0.0, 90.0), Fallback(45.0), "of a cone")
                .unit("degrees");
        const SEED: Key<kind::Integer<u32>, Required> =
            Key::new("seed", kind::Integer::within(1, 9), Required(""), "");
        let read = |text: &str| {
            let parsed = DeTable::parse(text).unwrap();
            let table = Table::root(Document { path: Path::new("t"), text }, &parsed);
            let angle = ANGLE.of(&table).map_err(|e| e.to_string());
            let seed = SEED.of(&table).map_err(|e| e.to_string());
            (angle, seed)
        };
        assert_eq!(read("seed = 9\nangle = 1\n"), (Ok(1.0), Ok(9)));
        let (angle, seed) = read("");
        assert_eq!(angle, Ok(45.0));
        assert!(seed.unwrap_err().contains("the key `seed` is missing"));
        let (angle, seed) = read("angle = 0\nseed = 10\n");
        let angle = angle.unwrap_err();
        assert!(
            angle.contains("angle: 0; allowed: a number above 0, at most 90 (degrees)"),
            "{angle}"
        );
        assert!(seed.unwrap_err().contains("seed: 10; allowed: a whole number from 1 to 9"));
        let words = ["number", "degrees", "`45`", "above 0, at most 90", "of a cone"];
        assert_eq!(ANGLE.cells(), words);
        assert_eq!(SEED.cells(), ["integer", "", "required", "1 to 9", ""]);
    }
}

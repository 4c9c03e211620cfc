//! [`Json`]: a value of a JSON document that knows its pointer, for errors that say where.

use std::path::Path;

use serde_json::Value;

use crate::error::{Error, Fault, Place, Result};

/// A value, its pointer and its file.
#[derive(Clone)]
pub(super) struct Json<'a> {
    pub path: &'a Path,
    pub value: &'a Value,
    pub pointer: String,
}

impl<'a> Json<'a> {
    /// The value is not allowed.
    pub fn fault(&self, what: &str, found: impl Into<String>, allowed: impl Into<String>) -> Error {
        let place = match self.pointer.is_empty() {
            true => Place::File,
            false => Place::Pointer(self.pointer.clone()),
        };
        Error::invalid(self.path, place, what, found, allowed)
    }

    /// The file that this URI names could not be used.
    pub fn referenced(&self, source: Error) -> Error {
        let found = format!("{} cannot be used", self.value);
        let place = Place::Pointer(self.pointer.clone());
        let fault = Fault::new(self.path, place, "uri", found, "");
        Error::Reference { fault: Box::new(fault), source: Box::new(source) }
    }

    fn wrong_type(&self, allowed: &str) -> Error {
        let found = match self.value {
            Value::Null => "null",
            Value::Bool(_) => "a boolean",
            Value::Number(_) => "a number",
            Value::String(_) => "a string",
            Value::Array(_) => "an array",
            Value::Object(_) => "an object",
        };
        self.fault("type", found, allowed)
    }

    fn child(&self, key: impl std::fmt::Display, value: &'a Value) -> Self {
        let key = key.to_string().replace('~', "~0").replace('/', "~1");
        Self { path: self.path, value, pointer: format!("{}/{key}", self.pointer) }
    }

    /// Refuses what is no object.
    pub fn object(self) -> Result<Self> {
        match self.value {
            Value::Object(_) => Ok(self),
            _ => Err(self.wrong_type("an object")),
        }
    }

    /// The property `key` of an object, if it is there.
    pub fn get(&self, key: &str) -> Option<Self> {
        self.value.get(key).map(|value| self.child(key, value))
    }

    /// The property `key`.
    pub fn require(&self, key: &str) -> Result<Self> {
        self.get(key).ok_or_else(|| {
            let found = format!("the property {key:?} is missing");
            self.fault("object", found, format!("{key:?} is required here"))
        })
    }

    /// The properties of an object.
    pub fn properties(&self) -> impl Iterator<Item = (&'a str, Self)> {
        let all = self.value.as_object().into_iter().flatten();
        all.map(|(key, value)| (key.as_str(), self.child(key, value)))
    }

    /// The items of an array.
    pub fn items(&self) -> Result<Vec<Self>> {
        let array = self.value.as_array().ok_or_else(|| self.wrong_type("an array"))?;
        Ok(array.iter().enumerate().map(|(k, value)| self.child(k, value)).collect())
    }

    /// The items of the array `key`, which may be missing but not empty.
    pub fn list(&self, key: &str) -> Result<Vec<Self>> {
        let Some(list) = self.get(key) else { return Ok(Vec::new()) };
        let items = list.items()?;
        match items.is_empty() {
            true => Err(list.fault("array", "empty", "at least one item, or no such property")),
            false => Ok(items),
        }
    }

    /// The objects of the array `key`, which may be missing but not empty.
    pub fn objects(&self, key: &str) -> Result<Vec<Self>> {
        self.list(key)?.into_iter().map(Self::object).collect()
    }

    /// Text.
    pub fn text(&self) -> Result<&'a str> {
        self.value.as_str().ok_or_else(|| self.wrong_type("a string"))
    }

    /// The text `key`, if it is there.
    pub fn text_of(&self, key: &str) -> Result<Option<&'a str>> {
        self.get(key).map(|value| value.text()).transpose()
    }

    /// A finite number.
    pub fn number(&self) -> Result<f64> {
        let number = self.value.as_f64().ok_or_else(|| self.wrong_type("a number"))?;
        match number.is_finite() {
            true => Ok(number),
            false => Err(self.fault("number", number.to_string(), "a finite number")),
        }
    }

    /// The number `key`, or `default`.
    pub fn number_or(&self, key: &str, default: f64) -> Result<f64> {
        self.get(key).map_or(Ok(default), |value| value.number())
    }

    /// A whole number of at least `least`; written as 1.0 it is whole too.
    pub fn whole(&self, least: u64) -> Result<u64> {
        let number = match self.value.as_u64() {
            Some(whole) => Some(whole),
            None => {
                let float = self.number()?;
                // Above 2^53 not every whole number has a float.
                let whole =
                    float.fract() == 0.0 && (0.0..=9_007_199_254_740_992.0).contains(&float);
                whole.then_some(float as u64)
            }
        };
        number.filter(|n| *n >= least).ok_or_else(|| {
            let allowed = format!("a whole number of at least {least}");
            self.fault("number", self.value.to_string(), allowed)
        })
    }

    /// The whole number `key`, or `default`.
    pub fn whole_or(&self, key: &str, default: u64) -> Result<u64> {
        self.get(key).map_or(Ok(default), |value| value.whole(0))
    }

    /// An index into a list of `count` items.
    pub fn index(&self, count: usize) -> Result<usize> {
        let index = self.whole(0)?;
        match index < count as u64 {
            true => Ok(index as usize),
            false => {
                let allowed = format!("below {count}, the number there are");
                Err(self.fault("index", index.to_string(), allowed))
            }
        }
    }

    /// The index `key` into a list of `count` items, if it is there.
    pub fn index_of(&self, key: &str, count: usize) -> Result<Option<usize>> {
        self.get(key).map(|value| value.index(count)).transpose()
    }

    /// `N` finite numbers.
    pub fn numbers<const N: usize>(&self) -> Result<[f64; N]> {
        let items = self.items()?;
        let mut numbers = [0.0; N];
        if items.len() != N {
            let found = format!("{} items", items.len());
            return Err(self.fault("array", found, format!("{N} numbers")));
        }
        for (slot, item) in numbers.iter_mut().zip(&items) {
            *slot = item.number()?;
        }
        Ok(numbers)
    }

    /// The `N` numbers `key`, or `default`.
    pub fn numbers_or<const N: usize>(&self, key: &str, default: [f64; N]) -> Result<[f64; N]> {
        self.get(key).map_or(Ok(default), |value| value.numbers())
    }

    /// The extension `name` of an object.
    pub fn extension(&self, name: &str) -> Option<Self> {
        self.get("extensions")?.get(name)
    }
}

//! Numbers and whole numbers in their ranges.

use std::fmt::Display;

use super::super::super::syntax::Value;
use super::{Item, Kind, Read, counted};
use crate::error::Result;

/// A finite number.
#[derive(Clone, Copy, Debug)]
pub enum Number {
    /// Of any size.
    Finite,
    /// Not 0.
    NotZero,
    /// At least this.
    AtLeast(f64),
    /// More than this, and not denormal.
    Above(f64),
    /// From the first to the second.
    Within(f64, f64),
    /// More than the first, at most the second, and not denormal.
    AboveUpTo(f64, f64),
    /// More than the first, less than the second, and not denormal.
    Between(f64, f64),
}

impl Number {
    fn contains(self, x: f64) -> bool {
        let above = |least: f64| x > least && !x.is_subnormal();
        match self {
            Self::Finite => true,
            Self::NotZero => x != 0.0,
            Self::AtLeast(least) => x >= least,
            Self::Above(least) => above(least),
            Self::Within(least, most) => least <= x && x <= most,
            Self::AboveUpTo(least, most) => above(least) && x <= most,
            Self::Between(least, most) => above(least) && x < most,
        }
    }

    /// What comes after `a number`.
    fn clause(self) -> String {
        match self {
            Self::Finite => String::new(),
            Self::NotZero => " other than 0".into(),
            Self::AtLeast(least) => format!(" of at least {least}"),
            Self::Above(least) => format!(" above {least}"),
            Self::Within(least, most) => format!(" from {least} to {most}"),
            Self::AboveUpTo(least, most) => format!(" above {least}, at most {most}"),
            Self::Between(least, most) => format!(" above {least} and below {most}"),
        }
    }
}

impl Kind for Number {
    type Value = f64;

    fn name(&self) -> String {
        "number".into()
    }

    fn allowed(&self) -> String {
        match *self {
            Self::Finite => "finite".into(),
            Self::NotZero => "not 0".into(),
            Self::AtLeast(least) => format!("at least {least}"),
            Self::Within(least, most) => format!("{least} to {most}"),
            Self::Between(least, most) => format!("above {least}, below {most}"),
            Self::Above(_) | Self::AboveUpTo(..) => self.clause().trim_start().into(),
        }
    }

    fn written(&self, value: &f64) -> String {
        value.to_string()
    }
}

impl Read for Number {
    fn read(&self, value: &Value<'_>) -> Result<f64> {
        match value.number() {
            Ok(number) if self.contains(number) => Ok(number),
            Ok(_) => Err(value.invalid(self.count(1))),
            Err(error) if matches!(self, Self::Finite) => Err(error),
            Err(_) => Err(value.invalid(self.count(1))),
        }
    }
}

impl Item for Number {
    fn count(&self, count: usize) -> String {
        format!("{}{}", counted(count, "number"), self.clause())
    }
}

/// A whole number from `least` to `most`, or the one that is allowed besides.
#[derive(Clone, Copy, Debug)]
pub struct Integer<T> {
    least: T,
    most: T,
    besides: Option<T>,
}

impl Integer<u64> {
    /// A seed: TOML's own integers end at 2^63 - 1.
    pub const SEED: Self = Self::within(0, i64::MAX as u64);
}

impl<T: Copy> Integer<T> {
    /// From `least` to `most`.
    pub const fn within(least: T, most: T) -> Self {
        Self { least, most, besides: None }
    }

    /// And `besides`.
    pub const fn or(self, besides: T) -> Self {
        Self { besides: Some(besides), ..self }
    }
}

impl<T: Display> Kind for Integer<T> {
    type Value = T;

    fn name(&self) -> String {
        "integer".into()
    }

    fn allowed(&self) -> String {
        let most = self.most.to_string();
        let seed = most == i64::MAX.to_string();
        let range = format!("{} to {}", self.least, if seed { "2^63 - 1" } else { &most });
        match &self.besides {
            Some(besides) => format!("{besides}, or {range}"),
            None => range,
        }
    }

    fn written(&self, value: &T) -> String {
        value.to_string()
    }
}

impl<T: Display + Copy + PartialOrd + TryFrom<i128>> Read for Integer<T> {
    fn read(&self, value: &Value<'_>) -> Result<T> {
        let besides = self.besides;
        let allowed = |n: &T| (self.least..=self.most).contains(n) || besides == Some(*n);
        value.integer(allowed, &self.count(1))
    }
}

impl<T: Display + Copy + PartialOrd + TryFrom<i128>> Item for Integer<T> {
    fn count(&self, count: usize) -> String {
        let besides = self.besides.map_or(String::new(), |besides| format!("{besides}, or "));
        let numbers = counted(count, "whole number");
        format!("{besides}{numbers} from {} to {}", self.least, self.most)
    }
}

/// One of a few whole numbers, each of which stands for something.
#[derive(Clone, Copy, Debug)]
pub struct Codes<T: 'static>(pub &'static [(u32, T)]);

impl<T: Copy + PartialEq> Kind for Codes<T> {
    type Value = T;

    fn name(&self) -> String {
        "integer".into()
    }

    fn allowed(&self) -> String {
        let codes: Vec<_> = self.0.iter().map(|(code, _)| code.to_string()).collect();
        codes.join(", ")
    }

    fn written(&self, value: &T) -> String {
        let code = self.0.iter().find(|(_, named)| named == value);
        code.map_or(String::new(), |(code, _)| code.to_string())
    }
}

impl<T: Copy + PartialEq> Read for Codes<T> {
    fn read(&self, value: &Value<'_>) -> Result<T> {
        let codes: Vec<_> = self.0.iter().map(|(code, _)| code.to_string()).collect();
        let known = |n: &u32| self.0.iter().any(|(code, _)| code == n);
        let code = value.integer(known, &codes.join(" or "))?;
        let named = self.0.iter().find(|(named, _)| *named == code);
        named.map(|&(_, named)| named).ok_or_else(|| value.invalid(codes.join(" or ")))
    }
}

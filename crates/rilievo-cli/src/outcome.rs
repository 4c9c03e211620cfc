//! How a command ends: [`Outcome`] and [`Failure`], and the exit code of each.

use std::io;

use crate::interrupt::Signal;

/// The end of a command that did its work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// All of it.
    Done,
    /// Two things that were compared are not as they should be.
    Unequal,
    /// Part of it: a limit was reached, what was done is written.
    Limited,
    /// Part of it: a signal came.
    Interrupted(Signal),
}

impl Outcome {
    /// The exit code.
    pub fn code(self) -> u8 {
        match self {
            Self::Done => 0,
            Self::Unequal => 3,
            Self::Limited => 4,
            Self::Interrupted(signal) => signal.exit_code(),
        }
    }
}

/// Why a command did not do its work. Displayed as one message.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// Flags that are sound one by one but not together.
    #[error("{0}\n\nFor more information, try '--help'.")]
    Usage(String),
    /// A file.
    #[error(transparent)]
    File(#[from] rilievo_io::Error),
    /// What was asked cannot be done.
    #[error("{0}")]
    Refused(String),
    /// Standard output is gone or full.
    #[error("standard output: {0}")]
    Output(io::Error),
    /// Signals cannot be caught.
    #[error("signal handlers: {0}")]
    Signals(io::Error),
}

impl Failure {
    /// Refuses with the message of `error`.
    pub fn refused(error: impl std::fmt::Display) -> Self {
        Self::Refused(error.to_string())
    }

    /// The exit code.
    pub fn code(&self) -> u8 {
        match self {
            Self::Usage(_) => 2,
            _ => 1,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exit_codes_are_those_of_the_help() {
        let interrupted = [Signal::Interrupt, Signal::Terminate].map(Outcome::Interrupted);
        assert_eq!(interrupted.map(Outcome::code), [130, 143]);
        assert_eq!(Outcome::Limited.code(), 4);
        assert_eq!(Failure::Usage(String::new()).code(), 2);
        assert_eq!(Failure::refused("no").code(), 1);
    }
}

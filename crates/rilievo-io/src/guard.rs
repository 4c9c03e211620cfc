//! [`guarded`]: calls a decoder of another crate so that its panics become errors.
//!
//! Decoders of damaged files do panic now and then. A panic is caught at this border, and its
//! message, which would tell a user nothing, is not printed.

use std::cell::Cell;
use std::panic::{self, AssertUnwindSafe};
use std::path::Path;
use std::sync::Once;

use crate::error::{Error, Place, Result};

thread_local! {
    /// Whether this thread is inside [`guarded`].
    static GUARDED: Cell<bool> = const { Cell::new(false) };
}

/// Runs `decode`. A panic in it is an [`Error::Invalid`] of `path`; whatever `decode` had half
/// built is dropped.
pub(crate) fn guarded<T>(path: &Path, decode: impl FnOnce() -> Result<T>) -> Result<T> {
    // Once per process: the hook that was there stays in charge of every other panic.
    static QUIET: Once = Once::new();
    QUIET.call_once(|| {
        let outer = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            if !GUARDED.get() {
                outer(info);
            }
        }));
    });
    let before = GUARDED.replace(true);
    let outcome = panic::catch_unwind(AssertUnwindSafe(decode));
    GUARDED.set(before);
    outcome.unwrap_or_else(|panic| {
        let text = (panic.downcast_ref::<String>().map(String::as_str))
            .or_else(|| panic.downcast_ref::<&str>().copied())
            .unwrap_or("no message");
        let found = format!("damaged beyond what its decoder expects ({text})");
        Err(Error::invalid(path, Place::File, "content", found, ""))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_becomes_an_error_and_the_guard_is_lifted_again() {
        let e = guarded::<()>(Path::new("x.exr"), || panic!("index {}", 7)).unwrap_err();
        assert!(
            e.to_string().contains("x.exr: content: damaged") && e.to_string().contains("index 7")
        );
        assert!(!GUARDED.get());
        assert_eq!(guarded(Path::new("x"), || Ok(3)).unwrap(), 3);
    }
}

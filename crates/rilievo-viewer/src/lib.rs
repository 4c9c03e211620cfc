//! The state of rilievo's viewer, free of any window.
//!
//! A scene is looked at and edited as the text of its file ([`session`]); a thread of its own ([`worker`])
//! loads it, paints on its maps and renders it, coarse pictures first. The window, which is the program
//! `rilievo-viewer`, turns mouse and keys into [`session::Action`]s and shows the frames that come out.
//!
//! - [`session`]: what is shown, edits, undo, presets.
//! - [`navigation`]: ways to move a camera.
//! - [`studio`]: scenes in memory; picking, painting.
//! - [`brush`], [`histogram`]: what is done to heights, and how often they occur.
//! - [`passes`]: the order in which a picture gets better; frames.
//! - [`backend`]: what renders a pass.
//! - [`worker`]: the thread.
//! - [`watch`]: files that change on the disk.
//! - [`save`]: picture, map and scene as files.

#![forbid(unsafe_code)]

pub mod backend;
pub mod brush;
pub mod histogram;
pub mod navigation;
pub mod passes;
pub mod save;
pub mod session;
pub mod studio;
pub mod watch;
pub mod worker;

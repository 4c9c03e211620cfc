//! [`History`]: what was done, to be taken back.

use std::mem::Discriminant;

use super::action::Action;
use super::document::Document;

/// Most steps that are remembered.
const MOST: usize = 200;

/// Something that was done.
#[derive(Clone, Debug)]
pub enum Step {
    /// The text was this.
    Text(Box<Document>),
    /// A stroke of the brush, by its number: painted, or taken back.
    Stroke(u32),
}

/// Steps done and steps taken back.
#[derive(Debug, Default)]
pub struct History {
    done: Vec<Step>,
    undone: Vec<Step>,
    /// The kind of edit that is going on: more of it is the same step.
    going_on: Option<Discriminant<Action>>,
}

impl History {
    /// An edit of the text, which was `before`.
    pub fn text(&mut self, before: &Document, kind: Discriminant<Action>) {
        self.undone.clear();
        if self.going_on == Some(kind) {
            return;
        }
        self.going_on = Some(kind);
        self.push(Step::Text(Box::new(before.clone())));
    }

    /// A stroke of the brush.
    pub fn stroke(&mut self, stroke: u32) {
        self.undone.clear();
        self.going_on = None;
        self.push(Step::Stroke(stroke));
    }

    /// What comes next is a step of its own.
    pub fn settle(&mut self) {
        self.going_on = None;
    }

    fn push(&mut self, step: Step) {
        self.done.push(step);
        let extra = self.done.len().saturating_sub(MOST);
        self.done.drain(..extra);
    }

    /// The last step, as it must be taken back while the text is `now`.
    pub fn undo(&mut self, now: &Document) -> Option<Step> {
        let step = self.done.pop()?;
        self.undone.push(turned(&step, now));
        self.going_on = None;
        Some(step)
    }

    /// The last step taken back, as it must be done again.
    pub fn redo(&mut self, now: &Document) -> Option<Step> {
        let step = self.undone.pop()?;
        self.done.push(turned(&step, now));
        self.going_on = None;
        Some(step)
    }
}

/// What takes `step` back once it is done.
fn turned(step: &Step, now: &Document) -> Step {
    match step {
        Step::Text(_) => Step::Text(Box::new(now.clone())),
        Step::Stroke(stroke) => Step::Stroke(*stroke),
    }
}

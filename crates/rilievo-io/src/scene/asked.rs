//! Which keys a parser asks for, noted in tests: by the place of their table.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};

type Asked = BTreeMap<String, BTreeSet<&'static str>>;

thread_local! {
    static ASKED: RefCell<Option<Asked>> = const { RefCell::new(None) };
}

/// From here on this thread takes note.
pub fn start() {
    ASKED.set(Some(Asked::new()));
}

/// What was asked for since.
pub fn finish() -> Asked {
    ASKED.take().unwrap_or_default()
}

pub fn note(table: &str, key: &'static str) {
    ASKED.with_borrow_mut(|asked| {
        if let Some(asked) = asked {
            asked.entry(place(table)).or_default().insert(key);
        }
    });
}

/// A table's name without numbers and names of the author's: `maps.NAME`, `shapes[].transform`;
/// of images `materials.NAME.IMAGE`.
fn place(table: &str) -> String {
    let mut place = String::new();
    for (depth, word) in table.split('.').enumerate() {
        let word = match (depth, place.as_str()) {
            (1, "maps" | "materials") => "NAME",
            (2, "materials.NAME") if word != "normals" => "IMAGE",
            _ => word,
        };
        let bare = word.split('[').next().unwrap_or(word);
        place += if depth > 0 { "." } else { "" };
        place += bare;
        place += if word.ends_with(']') { "[]" } else { "" };
    }
    place
}

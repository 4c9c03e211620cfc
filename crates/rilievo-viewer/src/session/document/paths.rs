//! The files that a scene names, when the scene moves to another folder.

use std::path::{Component, Path, PathBuf};

use toml_edit::{Item, Value};

use super::Document;

impl Document {
    /// The same scene as the file `path`: what it names by relative paths is written as seen from there. None if that
    /// cannot be done.
    pub fn moved(&self, path: &Path) -> Option<Self> {
        let folder = |path: &Path| path.parent().unwrap_or(Path::new("")).to_owned();
        let [old, new] = [folder(&self.path), folder(path)].map(|folder| plain(&folder));
        let (old, new) = (old?, new?);
        let mut moved = Self { path: path.to_owned(), ..self.clone() };
        if old == new {
            return Some(moved);
        }
        let named = self.parse().ok()?.references();
        let beside = |text: &str| self.path.parent().unwrap_or(Path::new("")).join(text);
        let rewrite = |text: &str| {
            let file = beside(text);
            // A folder is told from a name by its last stroke.
            let is_file = named.iter().any(|name| name.as_os_str() == file.as_os_str());
            (is_file && Path::new(text).is_relative())
                .then(|| seen_from(&new, &plain(&file)?, text))
        };
        for (_, item) in moved.toml.iter_mut() {
            rewrite_item(item, &|text| rewrite(text).flatten());
        }
        let all = |document: &Self| -> Option<Vec<PathBuf>> {
            document.parse().ok()?.references().iter().map(|file| plain(file)).collect()
        };
        (all(self)? == all(&moved)?).then_some(moved)
    }
}

fn rewrite_item(item: &mut Item, rewrite: &impl Fn(&str) -> Option<String>) {
    match item {
        Item::None => {}
        Item::Value(value) => rewrite_value(value, rewrite),
        Item::Table(table) => {
            table.iter_mut().for_each(|(_, item)| rewrite_item(item, rewrite));
        }
        Item::ArrayOfTables(all) => {
            let items = all.iter_mut().flat_map(|table| table.iter_mut());
            items.for_each(|(_, item)| rewrite_item(item, rewrite));
        }
    }
}

fn rewrite_value(value: &mut Value, rewrite: &impl Fn(&str) -> Option<String>) {
    match value {
        Value::String(text) => {
            if let Some(new) = rewrite(text.value()) {
                let decor = value.decor().clone();
                *value = new.into();
                *value.decor_mut() = decor;
            }
        }
        Value::Array(all) => all.iter_mut().for_each(|value| rewrite_value(value, rewrite)),
        Value::InlineTable(table) => {
            table.iter_mut().for_each(|(_, value)| rewrite_value(value, rewrite));
        }
        _ => {}
    }
}

/// A path from the root on, without steps back and forth; links are not followed.
fn plain(path: &Path) -> Option<PathBuf> {
    let whole = if path.as_os_str().is_empty() { Path::new(".") } else { path };
    let mut plain = PathBuf::new();
    for component in std::path::absolute(whole).ok()?.components() {
        match component {
            Component::ParentDir => {
                plain.pop();
            }
            Component::CurDir => {}
            other => plain.push(other),
        }
    }
    Some(plain)
}

/// A file as seen from a folder; whole if there is no way. A folder keeps the stroke at the end of `text`.
fn seen_from(folder: &Path, file: &Path, text: &str) -> Option<String> {
    let common = folder.components().zip(file.components()).take_while(|(a, b)| a == b).count();
    let up = folder.components().count() - common;
    let mut way: Vec<_> = std::iter::repeat_n("..", if common == 0 { 0 } else { up }).collect();
    let down = file.components().skip(common).map(|c| c.as_os_str().to_str());
    let down: Vec<_> = down.collect::<Option<_>>()?;
    way.extend(down);
    let way = if common == 0 { file.to_str()?.to_owned() } else { way.join("/") };
    let way = if way.is_empty() { ".".to_owned() } else { way };
    Some(if text.ends_with('/') && !way.ends_with('/') { way + "/" } else { way })
}

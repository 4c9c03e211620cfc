//! [`Watch`]: files that change on the disk while they are shown.
//!
//! Sizes and times of change are asked for, a few times a second: no service of the system is needed, and
//! network folders are as good as others.

use std::path::PathBuf;

use rilievo_io::scene::{SceneFile, Stamp};

/// Most files of a folder that are looked at.
const MOST_ENTRIES: usize = 256;

/// What has changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Changed {
    /// The scene file itself.
    Scene,
    /// A map, an image, a model.
    Files,
}

/// A scene file and the files it names, as they were when they were last looked at.
#[derive(Debug)]
pub struct Watch {
    path: PathBuf,
    references: Vec<PathBuf>,
    scene: Stamp,
    files: Stamp,
}

impl Watch {
    /// Watches the files of a scene.
    pub fn new(file: &SceneFile) -> Self {
        let path = file.path().to_owned();
        let references = file.references();
        let (scene, files) = (Stamp::of([path.as_path()]), stamp(&references));
        Self { path, references, scene, files }
    }

    /// What has changed since the last time; a file on its way to be replaced has not.
    pub fn look(&mut self) -> Option<Changed> {
        let (scene, files) = (Stamp::of([self.path.as_path()]), stamp(&self.references));
        let changed = if scene != self.scene {
            Some(Changed::Scene)
        } else if files != self.files {
            Some(Changed::Files)
        } else {
            None
        };
        (self.scene, self.files) = (scene, files);
        changed
    }
}

/// Files, and what is in folders.
fn stamp(paths: &[PathBuf]) -> Stamp {
    let mut all = Vec::new();
    for path in paths {
        all.push(path.clone());
        if let Ok(entries) = std::fs::read_dir(path) {
            let mut inside: Vec<_> =
                entries.flatten().take(MOST_ENTRIES).map(|entry| entry.path()).collect();
            inside.sort();
            all.extend(inside);
        }
    }
    Stamp::of(all.iter().map(PathBuf::as_path))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCENE: &str = "[camera]\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\n[maps.m]\nfile = \"m.png\"\n\
                         [maps.s]\nfile = \"set/\"\n";

    #[test]
    fn changes_are_seen_once() {
        let dir = tempfile::tempdir().unwrap();
        let at = |name: &str| dir.path().join(name);
        std::fs::create_dir(at("set")).unwrap();
        std::fs::write(at("scene.toml"), SCENE).unwrap();
        let file = SceneFile::parse(SCENE, &at("scene.toml")).unwrap();
        let mut watch = Watch::new(&file);
        assert_eq!(watch.look(), None);
        std::fs::write(at("m.png"), "one").unwrap();
        assert_eq!(watch.look(), Some(Changed::Files));
        assert_eq!(watch.look(), None);
        std::fs::write(at("set/height.png"), "two").unwrap();
        assert_eq!(watch.look(), Some(Changed::Files));
        std::fs::write(at("set/height.png"), "three").unwrap();
        assert_eq!(watch.look(), Some(Changed::Files));
        std::fs::write(at("scene.toml"), "# gone").unwrap();
        assert_eq!(watch.look(), Some(Changed::Scene));
        assert_eq!(watch.look(), None);
    }
}

//! Wavefront OBJ: positions, texture coordinates, normals, faces and materials.
//!
//! | line | read as |
//! |---|---|
//! | `v x y z ...` | a position; weight and colours after it are ignored |
//! | `vt u v ...`, `vn x y z` | a texture coordinate, a normal |
//! | `f a b c ...` | a face, fanned from its first corner |
//! | `mtllib a.mtl ...`, `usemtl name` | a material library beside the file, the material of what follows |
//! | `s n`, `s off` | smoothing group of what follows |
//! | `#`, groups, points, lines, curves | ignored |
//!
//! A corner is `p`, `p/t`, `p//n` or `p/t/n`; indices count from 1, negative ones back from the
//! latest. A face of which a corner has no normal is smooth within its smoothing group, flat
//! without one; a face without texture coordinates gets the mesh's own. Indices into a list that
//! the file lacks altogether are as if left out. The three lists stay apart as the file has them,
//! so neighbours keep sharing positions across uv seams. A library that cannot be opened costs the
//! materials, not the mesh. Written here, because errors should name their line.

use std::collections::HashMap;
use std::ops::Range;
use std::path::Path;

use glam::{DVec2, DVec3};
use rilievo::mesh::Triangle;

use super::model::{Model, NO_MATERIAL};
use super::mtl;
use super::words::{Word, Words};
use crate::error::{Error, Place, Result};
use crate::limits::Limits;

/// Reads a model from the bytes of an OBJ file; `name` is what errors call it. `library` gives the
/// bytes of a material library by its name.
///
/// # Errors
/// Of its size; a line that is wrong; a library that is wrong.
pub(super) fn read(
    bytes: &[u8],
    name: &Path,
    limits: &Limits,
    library: &dyn Fn(&Path) -> Result<Vec<u8>>,
) -> Result<Model> {
    // Only names and comments may hold anything but ASCII, and they are not looked at.
    let text = String::from_utf8_lossy(bytes);
    let mut reader = Reader {
        words: Words { path: name, text: &text },
        library,
        limits,
        model: Model::default(),
        groups: Vec::new(),
        group: 0,
        material: NO_MATERIAL,
        named: HashMap::new(),
        highest: [None; 3],
    };
    for line in reader.words.lines() {
        reader.line(line)?;
        let (data, groups) = (&reader.model.mesh, &reader.groups);
        let bytes = size_of_val(&*data.positions)
            + size_of_val(&*data.normals)
            + size_of_val(&*data.uvs)
            + size_of_val(&*data.triangles)
            + 2 * size_of_val(&**groups);
        limits.check(name, Place::File, "the mesh", &[bytes as u64])?;
    }
    reader.check_indices()?;
    let mut model = reader.model;
    model.mesh.smooth(&reader.groups);
    Ok(model)
}

/// An attribute of a corner.
#[derive(Clone, Copy)]
enum Attribute {
    Position,
    Uv,
    Normal,
}

impl Attribute {
    const ALL: [Self; 3] = [Self::Position, Self::Uv, Self::Normal];

    fn name(self) -> &'static str {
        match self {
            Self::Position => "position",
            Self::Uv => "texture coordinate",
            Self::Normal => "normal",
        }
    }
}

/// A corner of a face: indices from 0, in the order of [`Attribute::ALL`].
type Corner = [Option<u32>; 3];

struct Reader<'a> {
    words: Words<'a>,
    library: &'a dyn Fn(&Path) -> Result<Vec<u8>>,
    limits: &'a Limits,
    model: Model,
    /// The smoothing group of each triangle.
    groups: Vec<u32>,
    group: u32,
    material: u32,
    /// Places of materials by their names, known or not.
    named: HashMap<String, u32>,
    /// The highest index used of each attribute, and where: faces may come before what they name.
    highest: [Option<(u32, usize)>; 3],
}

impl<'a> Reader<'a> {
    fn line(&mut self, line: Range<usize>) -> Result<()> {
        let (all, data) = (self.words, &mut self.model.mesh);
        let mut words = all.words(line.clone());
        let Some((key, at)) = words.next() else { return Ok(()) };
        match key {
            "v" => {
                let p = all.numbers(&mut words, at, "three numbers: x y z")?;
                data.positions.push(DVec3::from_array(p));
            }
            "vn" => {
                let n = all.numbers(&mut words, at, "three numbers: x y z")?;
                data.normals.push(DVec3::from_array(n));
            }
            "vt" => {
                let [u] = all.numbers(&mut words, at.clone(), "two numbers: u v")?;
                // A one-dimensional coordinate is allowed; v is 0 then.
                let [v] = match words.next() {
                    Some(word) => [all.number(word, "two numbers: u v")?],
                    None => [0.0],
                };
                data.uvs.push(DVec2::new(u, v));
            }
            "f" => self.face(words, at)?,
            "s" => {
                // `off`, and whatever is no number, is no group.
                self.group = words.next().and_then(|(word, _)| word.parse().ok()).unwrap_or(0);
            }
            "usemtl" => {
                let name = words.next().map_or(String::new(), |(word, _)| word.to_owned());
                self.material = self.named.get(&name).copied().unwrap_or_else(|| {
                    let note = format!("material {name:?} is in no library");
                    self.model.notes.push(note);
                    NO_MATERIAL
                });
                self.named.insert(name, self.material);
            }
            "mtllib" => self.open_libraries(line, at)?,
            _ => {}
        }
        Ok(())
    }

    /// Reads the libraries of a line: one name with spaces, or several without.
    fn open_libraries(&mut self, line: Range<usize>, key: Range<usize>) -> Result<()> {
        let rest = self.words.text[key.end..line.end].trim();
        let names: Vec<&str> = match rest.to_lowercase().matches(".mtl").count() {
            0 | 1 => vec![rest],
            _ => rest.split_whitespace().collect(),
        };
        for name in names.into_iter().filter(|name| !name.is_empty()) {
            let path = self.words.path.parent().unwrap_or(Path::new("")).join(name);
            match (self.library)(&path) {
                Ok(bytes) => {
                    for material in mtl::read(&bytes, &path, self.limits)? {
                        let place = self.model.materials.len() as u32;
                        self.named.insert(material.name.clone(), place);
                        self.model.materials.push(material);
                    }
                }
                Err(e @ Error::Limit { .. }) => return Err(e),
                Err(e) => self.model.notes.push(format!("no materials: {e}")),
            }
        }
        Ok(())
    }

    fn face(&mut self, words: impl Iterator<Item = Word<'a>>, at: Range<usize>) -> Result<()> {
        let (mut first, mut before, mut count) = (None, None, 0);
        for word in words {
            let corner = self.corner(word)?;
            count += 1;
            match (first, before) {
                (None, _) => first = Some(corner),
                (Some(_), None) => before = Some(corner),
                (Some(a), Some(b)) => {
                    self.model.mesh.triangles.push(triangle([a, b, corner]));
                    self.model.material_of.push(self.material);
                    self.groups.push(self.group);
                    before = Some(corner);
                }
            }
        }
        if count < 3 {
            let found = format!("{count} corners");
            return Err(self.words.fault(at, "face", found, "at least 3 corners"));
        }
        Ok(())
    }

    fn counts(&self) -> [usize; 3] {
        let data = &self.model.mesh;
        [data.positions.len(), data.uvs.len(), data.normals.len()]
    }

    fn corner(&mut self, (word, at): Word<'a>) -> Result<Corner> {
        let counts = self.counts();
        let mut corner = [None; 3];
        let mut parts = word.split('/');
        for attribute in Attribute::ALL {
            let slot = attribute as usize;
            let part = parts.next().unwrap_or("");
            if part.is_empty() && slot > 0 {
                continue;
            }
            let count = counts[slot];
            let index = match part.parse::<i64>() {
                Ok(index @ 1..=0xffff_ffff) => index - 1,
                Ok(back) if back < 0 && back >= -(count as i64) => count as i64 + back,
                _ => {
                    let allowed = "an index from 1, or down to minus the number so far";
                    let what = format!("{} of a face", attribute.name());
                    return Err(self.words.fault(at, &what, format!("{word:?}"), allowed));
                }
            };
            let index = index as u32;
            if self.highest[slot].is_none_or(|(high, _)| index > high) {
                self.highest[slot] = Some((index, at.start));
            }
            corner[slot] = Some(index);
        }
        if parts.next().is_some() {
            let allowed = "p, p/t, p//n or p/t/n";
            return Err(self.words.fault(at, "corner of a face", format!("{word:?}"), allowed));
        }
        Ok(corner)
    }

    /// Checks that everything faces name is there. What the file lacks altogether is forgotten.
    fn check_indices(&mut self) -> Result<()> {
        let counts = self.counts();
        for attribute in Attribute::ALL {
            let (slot, name) = (attribute as usize, attribute.name());
            let Some((high, at)) = self.highest[slot].filter(|h| h.0 as usize >= counts[slot])
            else {
                continue;
            };
            match (attribute, counts[slot]) {
                (Attribute::Uv, 0) => {
                    self.model.mesh.triangles.iter_mut().for_each(|t| t.uvs = None);
                }
                (Attribute::Normal, 0) => {
                    self.model.mesh.triangles.iter_mut().for_each(|t| t.normals = None);
                }
                (_, count) => {
                    let text = self.words.text;
                    let end = text[at..].find(char::is_whitespace).map_or(text.len(), |n| at + n);
                    let found = format!("{}", u64::from(high) + 1);
                    let allowed = match count {
                        0 => "none: the file has no such lines".to_owned(),
                        count => format!("1 to {count}, the number in the file"),
                    };
                    let what = format!("{name} of a face");
                    return Err(self.words.fault(at..end, &what, found, &allowed));
                }
            }
        }
        Ok(())
    }
}

/// The triangle of three corners; an attribute that one of them lacks is left out.
fn triangle(corners: [Corner; 3]) -> Triangle {
    let all = |slot: usize| {
        let [a, b, c] = corners.map(|corner| corner[slot]);
        Some([a?, b?, c?])
    };
    // A corner without a position is refused before it gets here.
    let positions = corners.map(|corner| corner[0].unwrap_or(0));
    Triangle { positions, uvs: all(1), normals: all(2) }
}

#[cfg(test)]
mod tests {
    use rilievo::mesh::Mesh;

    use super::*;

    fn model(bytes: &[u8]) -> Result<Model> {
        let library = |path: &Path| match path.to_str() {
            Some("two words.mtl") => Ok(b"newmtl x\nKd 1 0 0\nnewmtl y\n".to_vec()),
            _ => Err(Error::io(path, std::io::ErrorKind::NotFound.into())),
        };
        super::read(bytes, Path::new("a.obj"), &Limits { max_bytes: 100_000 }, &library)
    }

    fn read(text: &str) -> Result<Mesh> {
        let mesh = Mesh::new(model(text.as_bytes())?.mesh);
        mesh.map_err(|e| Error::invalid(Path::new("a.obj"), Place::File, "mesh", e.to_string(), ""))
    }

    const SQUARE: &str =
        "v 0 0 0\nv 1 0 0 0.5 nan 0.5\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvn 0 0 1\n";

    #[test]
    fn polygons_are_fanned_and_lists_stay_apart() {
        let text = format!(
            "# caf\u{e9}\n{SQUARE}g a\nusemtl x\ns off\nl 1 2\np 1\nf 1/1/1 2/2/1 \\\n 3/1/1 4/2/1\n"
        );
        let mesh = read(&text).unwrap();
        let data = mesh.data();
        assert_eq!(data.triangles.len(), 2);
        assert_eq!(data.triangles[0].positions, [0, 1, 2]);
        assert_eq!(data.triangles[1].positions, [0, 2, 3]);
        assert_eq!(data.triangles[1].uvs, Some([0, 0, 1]));
        assert_eq!(data.triangles[1].normals, Some([0, 0, 0]));
        assert_eq!(data.positions[1], DVec3::X);
        let latin = [b"# caf\xe9\n", text.as_bytes()].concat();
        assert!(model(&latin).is_ok());
    }

    #[test]
    fn negative_indices_count_back_and_faces_may_come_first() {
        let back = read(&format!("{SQUARE}f -4 -3 -2\nv 9 9 9\nf -1//-1 1//1 2//1")).unwrap();
        assert_eq!(back.data().triangles[0].positions, [0, 1, 2]);
        assert_eq!(back.data().triangles[1].positions, [4, 0, 1]);
        assert_eq!(back.data().triangles[1].uvs, None);
        assert_eq!(read(&format!("f 1 2 3\r\n{SQUARE}")).unwrap().data().triangles.len(), 1);
        let mixed = read(&format!("{SQUARE}f 1//1 2 3//1")).unwrap();
        assert_eq!(mixed.data().triangles[0].normals, None);
    }

    #[test]
    fn errors_name_their_line() {
        for (tail, want) in [
            ("f 1 2", "a.obj:8:1: face: 2 corners; allowed: at least 3 corners"),
            ("f 1 2 9", "a.obj:8:7: position of a face: 9; allowed: 1 to 4"),
            (
                "vt 0 0\nf 1/4 2/1 3/1",
                "a.obj:9:3: texture coordinate of a face: 4; allowed: 1 to 3",
            ),
            ("f 0 1 2", "a.obj:8:3: position of a face: \"0\""),
            ("f -5 1 2", "\"-5\""),
            ("f 1/1/1/1 2 3", "p/t/n"),
            ("f /1 2 3", "position of a face: \"/1\""),
            ("f 1 2 x", "\"x\""),
            ("v 1 2", "a.obj:8:1: numbers: only 2; allowed: three numbers"),
            ("v 1 2 inf", "a.obj:8:7: number: \"inf\""),
            ("vn 1 2 nan", "\"nan\""),
            ("vt a", "\"a\""),
            ("f 99999999999 1 2", "99999999999"),
            ("", "the mesh has no triangles"),
        ] {
            let error = read(&format!("{SQUARE}{tail}")).unwrap_err().to_string();
            assert!(error.contains(want), "{tail}: {error}");
        }
        assert!(read("").unwrap_err().to_string().contains("no triangles"));
    }

    #[test]
    fn lists_that_are_not_there_are_not_needed() {
        let mesh = read("v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1/1/1 2/2/2 3/3/3\n").unwrap();
        let triangle = mesh.data().triangles[0];
        assert_eq!((triangle.uvs, triangle.normals), (None, None));
    }

    #[test]
    fn smoothing_groups_get_normals() {
        let text = format!("{SQUARE}s 1\nf 1 2 3\ns off\nf 1 2 3\ns 2\nf 1//1 2//1 3//1\n");
        let triangles = read(&text).unwrap().data().triangles.clone();
        let smooth: Vec<_> = triangles.iter().map(|t| t.normals).collect();
        assert_eq!(smooth, [Some([1, 2, 3]), None, Some([0, 0, 0])]);
    }

    #[test]
    fn libraries_give_materials_and_may_be_missing() {
        let text = format!(
            "mtllib two words.mtl\n{SQUARE}f 1 2 3\nusemtl y\nf 1 2 3\nusemtl x\nf 1 2 3 4\n"
        );
        let found = model(text.as_bytes()).unwrap();
        assert_eq!(found.material_of, [NO_MATERIAL, 1, 0, 0]);
        assert_eq!(found.materials[0].colour, DVec3::X);
        assert!(found.notes.is_empty(), "{:?}", found.notes);
        let parts = found.by_material();
        let sizes: Vec<_> = parts.iter().map(|(d, m)| (d.triangles.len(), *m)).collect();
        assert_eq!(sizes, [(2, Some(0)), (1, Some(1)), (1, None)]);
        assert_eq!(parts[1].0.positions.len(), 3);
        let lost = model(format!("mtllib gone.mtl\nusemtl x\n{SQUARE}f 1 2 3").as_bytes()).unwrap();
        assert_eq!((lost.material_of.as_slice(), lost.notes.len()), (&[NO_MATERIAL][..], 2));
    }

    #[test]
    fn memory_is_limited_and_no_prefix_panics() {
        let many = format!("{SQUARE}f{}", " 1".repeat(3000));
        assert!(matches!(read(&many), Err(Error::Limit { .. })));
        let text = format!("{SQUARE}f 1/1/1 2/2/1 \\\n 3/1/1 -1/-2/-1\n");
        for end in 0..text.len() {
            let _ = read(&text[..end]);
        }
    }
}

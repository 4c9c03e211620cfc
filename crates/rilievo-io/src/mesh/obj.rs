//! Wavefront OBJ: positions, texture coordinates, normals and faces.
//!
//! | line | read as |
//! |---|---|
//! | `v x y z ...` | a position; weight and colours after it are ignored |
//! | `vt u v ...`, `vn x y z` | a texture coordinate, a normal |
//! | `f a b c ...` | a face, fanned from its first corner |
//! | `#`, groups, materials, points, lines, curves | ignored |
//!
//! A corner is `p`, `p/t`, `p//n` or `p/t/n`; indices count from 1, negative ones back from the
//! latest. A face of which a corner has no normal is shaded flat, one without texture coordinates
//! gets the mesh's own. The three lists stay apart as the file has them, so neighbours keep sharing
//! positions across uv seams. Written here, because errors should name their line.

use std::ops::Range;
use std::path::Path;
use std::str::FromStr;

use glam::{DVec2, DVec3};
use rilievo::mesh::{Mesh, MeshData, Triangle};

use crate::error::{Error, Excerpt, Place, Result};
use crate::limits::Limits;

/// Reads a mesh from a file.
///
/// # Errors
/// Of the file or its size; a line that is wrong; a file without faces.
pub fn read_obj(path: &Path, limits: &Limits) -> Result<Mesh> {
    read_obj_bytes(&limits.read(path)?, path, limits)
}

/// Reads a mesh from bytes; `name` is what errors call them.
///
/// # Errors
/// As [`read_obj`].
pub fn read_obj_bytes(bytes: &[u8], name: &Path, limits: &Limits) -> Result<Mesh> {
    // Only names and comments may hold anything but ASCII, and they are not looked at.
    let text = String::from_utf8_lossy(bytes);
    let mut reader =
        Reader { path: name, text: &text, data: MeshData::default(), highest: [None; 3] };
    let mut start = 0;
    while start < text.len() {
        let end = reader.line_end(start);
        reader.line(start..end)?;
        let data = &reader.data;
        let bytes = size_of_val(&*data.positions)
            + size_of_val(&*data.normals)
            + size_of_val(&*data.uvs)
            + size_of_val(&*data.triangles);
        limits.check(name, Place::File, "the mesh", &[bytes as u64])?;
        start = end + 1;
    }
    reader.check_indices()?;
    let invalid = |found: String| {
        Error::invalid(name, Place::File, "mesh", found, "at least one face, finite numbers")
    };
    Mesh::new(reader.data).map_err(|e| invalid(e.to_string()))
}

/// A word of the text and where it stands.
type Word<'a> = (&'a str, Range<usize>);

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
    path: &'a Path,
    text: &'a str,
    data: MeshData,
    /// The highest index used of each attribute, and where: faces may come before what they name.
    highest: [Option<(u32, usize)>; 3],
}

impl<'a> Reader<'a> {
    /// Where the line that starts at `start` ends, lines that go on after a backslash included.
    fn line_end(&self, start: usize) -> usize {
        let mut from = start;
        loop {
            let Some(length) = self.text[from..].find('\n') else { return self.text.len() };
            let end = from + length;
            if !self.text[from..end].trim_end_matches('\r').ends_with('\\') {
                return end;
            }
            from = end + 1;
        }
    }

    /// The words of a line, without comment and continuation marks.
    fn words(&self, line: Range<usize>) -> impl Iterator<Item = Word<'a>> + use<'a> {
        let text = self.text;
        let stop = text[line.clone()].find('#').map_or(line.end, |at| line.start + at);
        text[line.start..stop].split([' ', '\t', '\r', '\n', '\\']).filter(|w| !w.is_empty()).map(
            move |word| {
                let at = word.as_ptr() as usize - text.as_ptr() as usize;
                (word, at..at + word.len())
            },
        )
    }

    fn line(&mut self, line: Range<usize>) -> Result<()> {
        let mut words = self.words(line);
        let Some((key, at)) = words.next() else { return Ok(()) };
        match key {
            "v" => {
                let p = self.numbers(&mut words, at, "three numbers: x y z")?;
                self.data.positions.push(DVec3::from_array(p));
            }
            "vn" => {
                let n = self.numbers(&mut words, at, "three numbers: x y z")?;
                self.data.normals.push(DVec3::from_array(n));
            }
            "vt" => {
                let [u] = self.numbers(&mut words, at.clone(), "two numbers: u v")?;
                // A one-dimensional coordinate is allowed; v is 0 then.
                let [v] = match words.next() {
                    Some(word) => [self.number(word, "two numbers: u v")?],
                    None => [0.0],
                };
                self.data.uvs.push(DVec2::new(u, v));
            }
            "f" => self.face(words, at)?,
            _ => {}
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
                    self.data.triangles.push(triangle([a, b, corner]));
                    before = Some(corner);
                }
            }
        }
        if count < 3 {
            let found = format!("{count} corners");
            return Err(self.fault(at, "face", found, "at least 3 corners"));
        }
        Ok(())
    }

    fn corner(&mut self, (word, at): Word<'a>) -> Result<Corner> {
        let counts = [self.data.positions.len(), self.data.uvs.len(), self.data.normals.len()];
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
                    return Err(self.fault(at, &what, format!("{word:?}"), allowed));
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
            return Err(self.fault(at, "corner of a face", format!("{word:?}"), allowed));
        }
        Ok(corner)
    }

    fn numbers<const N: usize>(
        &self,
        words: &mut impl Iterator<Item = Word<'a>>,
        at: Range<usize>,
        allowed: &str,
    ) -> Result<[f64; N]> {
        let mut all = [0.0; N];
        for (place, slot) in all.iter_mut().enumerate() {
            let word = words.next().ok_or_else(|| {
                self.fault(at.clone(), "numbers", format!("only {place}"), allowed)
            })?;
            *slot = self.number(word, allowed)?;
        }
        Ok(all)
    }

    fn number(&self, (word, at): Word<'a>, allowed: &str) -> Result<f64> {
        match f64::from_str(word) {
            Ok(number) if number.is_finite() => Ok(number),
            _ => Err(self.fault(at, "number", format!("{word:?}"), allowed)),
        }
    }

    /// Checks that everything faces name is there.
    fn check_indices(&self) -> Result<()> {
        let counts = [self.data.positions.len(), self.data.uvs.len(), self.data.normals.len()];
        for attribute in Attribute::ALL {
            let (slot, name) = (attribute as usize, attribute.name());
            if let Some((high, at)) = self.highest[slot]
                && high as usize >= counts[slot]
            {
                let end =
                    self.text[at..].find(char::is_whitespace).map_or(self.text.len(), |n| at + n);
                let found = format!("{}", u64::from(high) + 1);
                let allowed = match counts[slot] {
                    0 => "none: the file has no such lines".to_owned(),
                    count => format!("1 to {count}, the number in the file"),
                };
                return Err(self.fault(at..end, &format!("{name} of a face"), found, &allowed));
            }
        }
        Ok(())
    }

    fn fault(&self, at: Range<usize>, what: &str, found: String, allowed: &str) -> Error {
        Error::invalid(self.path, Place::Text(Excerpt::new(self.text, at)), what, found, allowed)
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
    use super::*;

    fn read(text: &str) -> Result<Mesh> {
        read_obj_bytes(text.as_bytes(), Path::new("a.obj"), &Limits { max_bytes: 100_000 })
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
        assert!(read_obj_bytes(&latin, Path::new("a.obj"), &Limits::default()).is_ok());
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
            ("f 1/3 2/1 3/1", "a.obj:8:3: texture coordinate of a face: 3; allowed: 1 to 2"),
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
    fn memory_is_limited_and_no_prefix_panics() {
        let many = format!("{SQUARE}f{}", " 1".repeat(3000));
        assert!(matches!(read(&many), Err(Error::Limit { .. })));
        let text = format!("{SQUARE}f 1/1/1 2/2/1 \\\n 3/1/1 -1/-2/-1\n");
        for end in 0..text.len() {
            let _ = read(&text[..end]);
        }
    }
}

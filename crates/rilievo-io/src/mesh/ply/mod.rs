//! PLY, the Stanford polygon format: text, or binary of either byte order.
//!
//! | element | property | read as |
//! |---|---|---|
//! | `vertex` | `x y z` | positions |
//! | | `nx ny nz` | normals |
//! | | `s t`, `u v`, `texture_u texture_v` | texture coordinates, v upwards |
//! | `face` | list `vertex_indices` or `vertex_index` | polygons, fanned from their first corner |
//! | | list `texcoord` | texture coordinates of the corners, in place of those of the vertices |
//! | `tristrips` | list `vertex_indices` | strips of triangles; -1 starts a new one |
//!
//! Everything else is read over. A file without faces is a model without triangles.

mod header;
mod values;

use std::path::Path;

use glam::{DVec2, DVec3};
use rilievo::mesh::{MeshData, Triangle};

use super::model::{Model, NO_MATERIAL};
use crate::error::{Error, Place, Result};
use crate::limits::Limits;
use header::{Element, Header, Property};
use values::Values;

/// Reads a model from the bytes of a PLY file; `name` is what errors call it.
///
/// # Errors
/// Of its header, its size, an index that is not there, a file that ends early.
pub(super) fn read(bytes: &[u8], name: &Path, limits: &Limits) -> Result<Model> {
    let header = Header::read(bytes, name)?;
    let values = Values::new(name, header.encoding, bytes, header.end);
    let mut reader = Reader { path: name, values, mesh: MeshData::default(), vertices: None };
    for element in &header.elements {
        let declared = [element.count, element.least_bytes(header.encoding)];
        if declared[0].saturating_mul(declared[1]) > reader.values.left() as u64 + 1 {
            let found = format!("{} of {:?} in {} bytes", element.count, element.name, {
                reader.values.left()
            });
            let allowed = "no more than the file holds";
            return Err(Error::invalid(name, Place::Header, "element", found, allowed));
        }
        match element.name.as_str() {
            "vertex" => reader.vertices(element, limits)?,
            "face" => reader.polygons(element, limits, Polygons::Fan)?,
            "tristrips" => reader.polygons(element, limits, Polygons::Strip)?,
            _ => reader.skip(element)?,
        }
    }
    reader.check()?;
    let material_of = vec![NO_MATERIAL; reader.mesh.triangles.len()];
    Ok(Model { mesh: reader.mesh, material_of, ..Model::default() })
}

/// How a list of indices becomes triangles.
#[derive(Clone, Copy, PartialEq)]
enum Polygons {
    Fan,
    Strip,
}

/// What a vertex has beside its position.
#[derive(Clone, Copy)]
struct Attributes {
    normals: bool,
    uvs: bool,
}

struct Reader<'a> {
    path: &'a Path,
    values: Values<'a>,
    mesh: MeshData,
    vertices: Option<Attributes>,
}

/// What a property of a vertex is: a slot of the record, or nothing.
fn slot(name: &str) -> Option<usize> {
    Some(match name {
        "x" => 0,
        "y" => 1,
        "z" => 2,
        "nx" => 3,
        "ny" => 4,
        "nz" => 5,
        "s" | "u" | "texture_u" => 6,
        "t" | "v" | "texture_v" => 7,
        _ => return None,
    })
}

impl Reader<'_> {
    fn vertices(&mut self, element: &Element, limits: &Limits) -> Result<()> {
        let slots: Vec<_> = element.properties.iter().map(|p| slot(&p.name)).collect();
        let has = |wanted: [usize; 2]| (wanted[0]..wanted[1]).all(|s| slots.contains(&Some(s)));
        if !has([0, 3]) {
            let allowed = "properties x, y and z";
            return Err(Error::invalid(self.path, Place::Header, "vertex", "no position", allowed));
        }
        let found = Attributes { normals: has([3, 6]), uvs: has([6, 8]) };
        let each = size_of::<DVec3>() * (1 + usize::from(found.normals)) + size_of::<DVec2>();
        let factors = [element.count, each as u64];
        limits.check(self.path, Place::Header, "the vertices", &factors)?;
        for _ in 0..element.count {
            let mut record = [0.0; 8];
            for (property, slot) in element.properties.iter().zip(&slots) {
                let value = self.value(property)?;
                let Some(slot) = *slot else { continue };
                if !value.is_finite() {
                    let what = format!("{} of a vertex", property.name);
                    return Err(self.values.last(&what, value.to_string(), "a finite number"));
                }
                record[slot] = value;
            }
            let [x, y, z, nx, ny, nz, u, v] = record;
            self.mesh.positions.push(DVec3::new(x, y, z));
            if found.normals {
                self.mesh.normals.push(DVec3::new(nx, ny, nz));
            }
            if found.uvs {
                self.mesh.uvs.push(DVec2::new(u, v));
            }
        }
        self.vertices = Some(found);
        Ok(())
    }

    /// The value of a property; of a list it is not needed, and read over.
    fn value(&mut self, property: &Property) -> Result<f64> {
        match property.count {
            None => self.values.next(property.value),
            Some(_) => {
                for _ in 0..self.count(property)? {
                    self.values.next(property.value)?;
                }
                Ok(0.0)
            }
        }
    }

    /// The number of values of a list that begins here.
    fn count(&mut self, property: &Property) -> Result<usize> {
        let Some(scalar) = property.count else { return Ok(1) };
        let count = self.values.next(scalar)?;
        // As text every value takes a byte at least.
        match count >= 0.0 && count <= self.values.left() as f64 && count.fract() == 0.0 {
            true => Ok(count as usize),
            false => {
                let what = format!("count of {}", property.name);
                Err(self.values.last(&what, count.to_string(), "no more than the file holds"))
            }
        }
    }

    fn skip(&mut self, element: &Element) -> Result<()> {
        for _ in 0..element.count {
            for property in &element.properties {
                self.value(property)?;
            }
        }
        Ok(())
    }

    fn polygons(&mut self, element: &Element, limits: &Limits, kind: Polygons) -> Result<()> {
        let (mut corners, mut texture) = (Vec::new(), Vec::new());
        for _ in 0..element.count {
            corners.clear();
            texture.clear();
            for property in &element.properties {
                match (property.name.as_str(), property.count) {
                    ("vertex_indices" | "vertex_index", Some(_)) => {
                        for _ in 0..self.count(property)? {
                            corners.push(self.values.next(property.value)?);
                        }
                    }
                    ("texcoord", Some(_)) => {
                        for _ in 0..self.count(property)? {
                            texture.push(self.values.next(property.value)?);
                        }
                    }
                    _ => drop(self.value(property)?),
                }
            }
            match kind {
                Polygons::Fan => self.fan(&corners, &texture)?,
                Polygons::Strip => self.strip(&corners)?,
            }
            let MeshData { triangles, uvs, .. } = &self.mesh;
            let bytes = size_of_val(triangles.as_slice()) + size_of_val(uvs.as_slice());
            limits.check(self.path, Place::File, "the faces", &[bytes as u64])?;
        }
        Ok(())
    }

    /// An index of a vertex; whether it is there is checked at the end.
    fn index(&self, value: f64) -> Result<u32> {
        match value >= 0.0 && value <= f64::from(u32::MAX) && value.fract() == 0.0 {
            true => Ok(value as u32),
            false => Err(self.values.last("index of a face", value.to_string(), "from 0")),
        }
    }

    fn fan(&mut self, corners: &[f64], texture: &[f64]) -> Result<()> {
        let indices = corners.iter().map(|&c| self.index(c)).collect::<Result<Vec<_>>>()?;
        let [first, rest @ ..] = indices.as_slice() else { return Ok(()) };
        // Two numbers a corner, or they mean something else.
        let own = match texture.len() == 2 * indices.len() && texture.iter().all(|t| t.is_finite())
        {
            true => {
                let start = self.mesh.uvs.len() as u32;
                let pairs = texture.chunks_exact(2).map(|uv| DVec2::new(uv[0], uv[1]));
                self.mesh.uvs.extend(pairs);
                Some(start)
            }
            false => None,
        };
        for (k, pair) in (1..).zip(rest.windows(2)) {
            let uvs = own.map(|start| [start, start + k, start + k + 1]);
            self.mesh.triangles.push(Triangle {
                positions: [*first, pair[0], pair[1]],
                normals: None,
                uvs,
            });
        }
        Ok(())
    }

    fn strip(&mut self, corners: &[f64]) -> Result<()> {
        for strip in corners.split(|&c| c == -1.0) {
            for (k, three) in strip.windows(3).enumerate() {
                let [a, b, c] =
                    [self.index(three[0])?, self.index(three[1])?, self.index(three[2])?];
                // Every second triangle of a strip runs the other way.
                let positions = if k % 2 == 0 { [a, b, c] } else { [b, a, c] };
                self.mesh.triangles.push(Triangle { positions, normals: None, uvs: None });
            }
        }
        Ok(())
    }

    /// Checks indices and gives corners the attributes of their vertices.
    fn check(&mut self) -> Result<()> {
        let Some(found) = self.vertices else {
            return match self.mesh.triangles.is_empty() {
                true => Ok(()),
                false => Err(self.missing(0)),
            };
        };
        let count = self.mesh.positions.len();
        for t in &mut self.mesh.triangles {
            if let Some(&index) = t.positions.iter().find(|&&i| i as usize >= count) {
                return Err(self.missing(index));
            }
            t.normals = found.normals.then_some(t.positions);
            t.uvs = t.uvs.or(found.uvs.then_some(t.positions));
        }
        Ok(())
    }

    fn missing(&self, index: u32) -> Error {
        let allowed = format!("below {}, the number of vertices", self.mesh.positions.len());
        Error::invalid(self.path, Place::File, "index of a face", index.to_string(), allowed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEAD: &str = "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
                        property uchar red\nproperty float s\nproperty float t\n\
                        element face 1\nproperty list uchar int vertex_indices\nend_header\n";

    fn read(text: &[u8]) -> Result<Model> {
        super::read(text, Path::new("a.ply"), &Limits { max_bytes: 1 << 20 })
    }

    fn square(binary: Option<bool>) -> Vec<u8> {
        let corners = [[0.0_f32, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let format = match binary {
            None => "ascii",
            Some(false) => "binary_little_endian",
            Some(true) => "binary_big_endian",
        };
        let mut bytes = format!("ply\r\nformat {format} 1.0\n{HEAD}").into_bytes();
        let Some(big) = binary else {
            for [x, y] in corners {
                bytes.extend(format!("{x} {y} 0 255 {x} {y}\n").bytes());
            }
            bytes.extend(b"4 0 1 2 3\n");
            return bytes;
        };
        let float = |v: f32| if big { v.to_be_bytes() } else { v.to_le_bytes() };
        let int = |v: i32| if big { v.to_be_bytes() } else { v.to_le_bytes() };
        for [x, y] in corners {
            [x, y, 0.0].iter().for_each(|&v| bytes.extend(float(v)));
            bytes.push(255);
            [x, y].iter().for_each(|&v| bytes.extend(float(v)));
        }
        bytes.push(4);
        (0..4).for_each(|i| bytes.extend(int(i)));
        bytes
    }

    #[test]
    fn text_and_both_byte_orders_are_the_same_square() {
        let all = [None, Some(false), Some(true)].map(|binary| read(&square(binary)).unwrap().mesh);
        assert_eq!(all[0].triangles.len(), 2);
        assert_eq!(all[0].triangles[1].positions, [0, 2, 3]);
        assert_eq!(all[0].triangles[1].uvs, Some([0, 2, 3]));
        assert_eq!(all[0].positions[2], DVec3::new(1.0, 1.0, 0.0));
        assert!(all[1] == all[0] && all[2] == all[0]);
    }

    #[test]
    fn uvs_of_corners_and_strips_are_read() {
        let text = "ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\nproperty double y\n\
                    property double z\nelement face 1\nproperty list uchar uint vertex_index\n\
                    property list uchar float texcoord\nelement tristrips 1\n\
                    property list int int vertex_indices\nend_header\n0 0 0 1 0 0 1 1 0 0 1 0\n\
                    3 0 1 2 6 0 0 0.5 0 0.5 0.5\n8 0 1 2 3 -1 1 2 3\n";
        let mesh = read(text.as_bytes()).unwrap().mesh;
        let positions: Vec<_> = mesh.triangles.iter().map(|t| t.positions).collect();
        assert_eq!(positions, [[0, 1, 2], [0, 1, 2], [2, 1, 3], [1, 2, 3]]);
        assert_eq!(mesh.triangles[0].uvs, Some([0, 1, 2]));
        assert_eq!((mesh.triangles[1].uvs, mesh.uvs[1]), (None, DVec2::new(0.5, 0.0)));
    }

    #[test]
    fn faults_are_named() {
        let text = String::from_utf8(square(None)).unwrap();
        for (from, to, want) in [
            ("ply", "plx", "a.ply:1:1: first line: plx; allowed: ply"),
            ("ascii", "utf8", "format: utf8; allowed: ascii"),
            ("float x", "float q", "vertex: no position"),
            ("float x", "half x", "property: property half x"),
            ("vertex 4", "vertex 4000000000", "element: 4000000000 of \"vertex\" in"),
            ("vertex 4", "vertex -1", "element: -1; allowed: a count"),
            ("end_header", "end", "line of the header: end"),
            ("4 0 1 2 3", "4 0 1 2 9", "index of a face: 9; allowed: below 4"),
            ("4 0 1 2 3", "4 0 1 2 -3", "index of a face: -3"),
            ("4 0 1 2 3", "200 0 1 2 3", "count of vertex_indices: 200"),
            ("4 0 1 2 3", "4 0 1 2", "the file ends before its data"),
            ("1 1 0 255 1", "1 nan 0 255 1", "y of a vertex: NaN; allowed: a finite number"),
            ("4 0 1 2 3", "4 0 1 2 x", "a.ply:17:9: value: \"x\""),
        ] {
            assert!(text.contains(from), "{from}");
            let error = read(text.replacen(from, to, 1).as_bytes()).unwrap_err().to_string();
            assert!(error.contains(want), "{to}: {error}");
        }
    }

    #[test]
    fn no_part_of_a_file_panics_and_memory_is_limited() {
        for binary in [None, Some(false), Some(true)] {
            let bytes = square(binary);
            for end in 0..bytes.len() - 1 {
                assert!(read(&bytes[..end]).is_err() || binary.is_none());
            }
        }
        let limits = Limits { max_bytes: 100 };
        let refused = super::read(&square(None), Path::new("a.ply"), &limits);
        assert!(matches!(refused, Err(Error::Limit { .. })));
    }
}

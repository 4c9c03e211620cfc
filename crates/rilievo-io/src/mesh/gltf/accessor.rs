//! Accessors: typed elements in views, with sparse replacements.

use super::buffers::{Buffers, Usage};
use super::json::Json;
use crate::error::{Place, Result};
use crate::limits::Limits;

/// The type of a component.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn of(code: u64) -> Option<Self> {
        Some(match code {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return None,
        })
    }

    pub fn bytes(self) -> u64 {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    /// The value of the first bytes of `raw`, which has enough of them.
    fn value(self, raw: &[u8], normalized: bool) -> f64 {
        let share =
            |value: f64, most: f64| if normalized { (value / most).max(-1.0) } else { value };
        match (self, raw) {
            (Self::I8, [a, ..]) => share(f64::from(*a as i8), 127.0),
            (Self::U8, [a, ..]) => share(f64::from(*a), 255.0),
            (Self::I16, [a, b, ..]) => share(f64::from(i16::from_le_bytes([*a, *b])), 32767.0),
            (Self::U16, [a, b, ..]) => share(f64::from(u16::from_le_bytes([*a, *b])), 65535.0),
            (Self::U32, [a, b, c, d, ..]) => f64::from(u32::from_le_bytes([*a, *b, *c, *d])),
            (Self::F32, [a, b, c, d, ..]) => f64::from(f32::from_le_bytes([*a, *b, *c, *d])),
            _ => 0.0,
        }
    }
}

/// How the components of an element are arranged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shape {
    Scalar,
    Vec2,
    Vec3,
    Vec4,
    /// A square matrix of so many rows.
    Matrix(u64),
}

impl Shape {
    fn of(name: &str) -> Option<Self> {
        Some(match name {
            "SCALAR" => Self::Scalar,
            "VEC2" => Self::Vec2,
            "VEC3" => Self::Vec3,
            "VEC4" => Self::Vec4,
            "MAT2" => Self::Matrix(2),
            "MAT3" => Self::Matrix(3),
            "MAT4" => Self::Matrix(4),
            _ => return None,
        })
    }

    fn components(self) -> u64 {
        match self {
            Self::Scalar => 1,
            Self::Vec2 => 2,
            Self::Vec3 => 3,
            Self::Vec4 => 4,
            Self::Matrix(rows) => rows * rows,
        }
    }

    /// Bytes of an element, and without the padding after the last column of a matrix.
    fn bytes(self, component: Component) -> [u64; 2] {
        match self {
            // Columns begin at multiples of 4 bytes.
            Self::Matrix(rows) => {
                let column = rows * component.bytes();
                let padded = column.next_multiple_of(4);
                [padded * rows, padded * (rows - 1) + column]
            }
            _ => [self.components() * component.bytes(); 2],
        }
    }
}

/// Replacements of some elements.
struct Sparse {
    count: u64,
    /// View, offset in it, type of indices.
    indices: (usize, u64, Component),
    /// View and offset in it.
    values: (usize, u64),
}

/// An accessor, checked against its views.
pub(super) struct Accessor<'a> {
    pub json: Json<'a>,
    /// None if the file names types that are not known.
    pub format: Option<(Shape, Component)>,
    pub normalized: bool,
    pub count: u64,
    pub view: Option<usize>,
    pub offset: u64,
    /// Whether the file tells the range of values.
    pub bounded: bool,
    sparse: Option<Sparse>,
}

impl<'a> Accessor<'a> {
    /// Reads an accessor.
    pub fn read(json: Json<'a>, buffers: &mut Buffers<'_>) -> Result<Self> {
        let component = Component::of(json.require("componentType")?.whole(0)?);
        let count = json.require("count")?.whole(1)?;
        let shape = Shape::of(json.require("type")?.text()?);
        let view = json.index_of("bufferView", buffers.views.len())?;
        let offset = json.whole_or("byteOffset", 0)?;
        let normalized = json.get("normalized").is_some_and(|value| value.value == true);
        let bounded = json.get("min").is_some() && json.get("max").is_some();
        if view.is_none() && json.get("byteOffset").is_some() {
            return Err(json.fault("byteOffset", "without bufferView", "a bufferView beside it"));
        }
        if normalized && matches!(component, Some(Component::F32 | Component::U32)) {
            let allowed = "integers of 8 or 16 bits";
            return Err(json.fault("normalized", "of floats or 32-bit integers", allowed));
        }
        let mut accessor = Self {
            format: shape.zip(component),
            normalized,
            count,
            view,
            offset,
            bounded,
            sparse: None,
            json,
        };
        accessor.check(buffers)?;
        if let Some(json) = accessor.json.get("sparse") {
            accessor.sparse = Some(accessor.read_sparse(&json.object()?, buffers)?);
        }
        Ok(accessor)
    }

    /// Checks that the elements lie in the view.
    fn check(&self, buffers: &Buffers<'_>) -> Result<()> {
        let (Some((shape, component)), Some(view)) = (self.format, self.view) else {
            return Ok(());
        };
        let view = &buffers.views[view];
        let unit = component.bytes();
        let fault = |what: &str, found: u64, allowed: &str| {
            Err(self.json.fault(what, found.to_string(), allowed))
        };
        if let Shape::Matrix(_) = shape
            && !self.offset.is_multiple_of(4)
        {
            return fault("byteOffset", self.offset, "a multiple of 4 for matrices");
        }
        if !self.offset.is_multiple_of(unit) {
            let allowed = "a multiple of the size of a component";
            return fault("byteOffset", self.offset, allowed);
        }
        if !self.offset.saturating_add(view.offset).is_multiple_of(unit) {
            let allowed = "a multiple of the size of a component, counted in the buffer";
            return fault("byteOffset", self.offset.saturating_add(view.offset), allowed);
        }
        let [size, last] = shape.bytes(component);
        let stride = view.stride.unwrap_or(size);
        if stride < size {
            return fault("byteStride", stride, "at least the size of an element");
        }
        let end = (self.count - 1).saturating_mul(stride).saturating_add(last);
        if self.offset.saturating_add(end) > view.length {
            let found = format!("{} elements, {end} bytes from {} on", self.count, self.offset);
            let allowed = format!("within {} bytes of the view", view.length);
            return Err(self.json.fault("accessor", found, allowed));
        }
        Ok(())
    }

    fn read_sparse(&self, json: &Json<'_>, buffers: &mut Buffers<'_>) -> Result<Sparse> {
        let count = json.require("count")?.whole(1)?;
        if count > self.count {
            let allowed = format!("at most {}, the elements there are", self.count);
            return Err(json.fault("count", count.to_string(), allowed));
        }
        let mut part = |key: &str| {
            let json = json.require(key)?.object()?;
            let view = json.require("bufferView")?;
            let index = view.index(buffers.views.len())?;
            buffers.mark(index, Usage::Other, &view)?;
            Ok((json.clone(), index, json.whole_or("byteOffset", 0)?))
        };
        let (indices, index_view, index_offset) = part("indices")?;
        let (values, value_view, value_offset) = part("values")?;
        let component = Component::of(indices.require("componentType")?.whole(0)?);
        let component = component
            .filter(|c| matches!(c, Component::U8 | Component::U16 | Component::U32))
            .ok_or_else(|| {
                indices.fault("componentType", "no unsigned integer", "5121, 5123, 5125")
            })?;
        let value = self.format.map_or(1, |(shape, component)| shape.bytes(component)[0]);
        for (json, view, offset, size) in [
            (&indices, index_view, index_offset, component.bytes()),
            (&values, value_view, value_offset, value),
        ] {
            let (end, most) = (count.saturating_mul(size), buffers.views[view].length);
            if offset.saturating_add(end) > most {
                let found = format!("{count} elements from byte {offset} on");
                return Err(json.fault(
                    "sparse",
                    found,
                    format!("within {most} bytes of the view"),
                ));
            }
        }
        let (indices, values) = ((index_view, index_offset, component), (value_view, value_offset));
        Ok(Sparse { count, indices, values })
    }

    /// Bytes of an element.
    pub fn element_bytes(&self) -> u64 {
        self.format.map_or(0, |(shape, component)| shape.bytes(component)[0])
    }

    /// The first `N` components of every element.
    pub fn elements<const N: usize>(
        &self,
        buffers: &Buffers<'_>,
        limits: &Limits,
    ) -> Result<Vec<[f64; N]>> {
        let Some((shape, component)) = self.format.filter(|(s, _)| s.components() >= N as u64)
        else {
            return Err(self.json.fault("type", "of too few components, or not known", "another"));
        };
        let place = Place::Pointer(self.json.pointer.clone());
        let sizes = [self.count, 8 * N as u64];
        limits.check(self.json.path, place, "the accessor", &sizes)?;
        let size = component.bytes() as usize;
        let decode = |raw: &[u8]| {
            std::array::from_fn(|k| {
                raw.get(k * size..).map_or(0.0, |raw| component.value(raw, self.normalized))
            })
        };
        let mut all = vec![[0.0; N]; self.count as usize];
        if let Some((view, bytes)) = self.view.and_then(|v| Some((v, buffers.bytes(v)?))) {
            let stride = buffers.views[view].stride.unwrap_or(shape.bytes(component)[0]);
            for (k, element) in all.iter_mut().enumerate() {
                let start = self.offset as usize + k * stride as usize;
                *element = decode(bytes.get(start..).unwrap_or_default());
            }
        }
        let Some(sparse) = &self.sparse else { return Ok(all) };
        let (index_view, index_offset, index) = sparse.indices;
        let (value_view, value_offset) = sparse.values;
        let parts = buffers.bytes(index_view).zip(buffers.bytes(value_view));
        let Some((indices, values)) = parts else { return Ok(all) };
        for k in 0..sparse.count as usize {
            let at = index_offset as usize + k * index.bytes() as usize;
            let place = index.value(indices.get(at..).unwrap_or_default(), false) as usize;
            let at = value_offset as usize + k * shape.bytes(component)[0] as usize;
            match all.get_mut(place) {
                Some(element) => *element = decode(values.get(at..).unwrap_or_default()),
                None => {
                    let allowed = format!("below {}, the elements there are", self.count);
                    return Err(self.json.fault("sparse index", place.to_string(), allowed));
                }
            }
        }
        Ok(all)
    }
}

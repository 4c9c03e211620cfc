//! [`SurfaceRecord`]: a surface of the world as the shaders read it, the struct `Surface` of `shaders/params.wgsl`.

use crate::records::NOTHING;

/// Words of a surface.
pub(crate) const SURFACE_WORDS: usize = 4;

/// Bit of a surface that rays from behind pass through.
const ONE_SIDED: u32 = 4;
/// Bit of a surface that is elsewhere at every time.
const MOVES: u32 = 16;

/// A surface of the world, or what an instance shows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SurfaceRecord {
    kind: u32,
    data: u32,
    one_sided: bool,
    /// Place of the transform in `numbers`, if it stands elsewhere.
    transform: Option<u32>,
    /// Whether a motion follows the transform.
    moves: bool,
}

impl SurfaceRecord {
    /// A displaced face by its number.
    pub fn face(number: u32) -> Self {
        Self { kind: 1, data: number, one_sided: false, transform: None, moves: false }
    }

    /// A sphere by the place of its centre and radius.
    pub fn sphere(place: u32) -> Self {
        Self { kind: 2, data: place, one_sided: false, transform: None, moves: false }
    }

    /// Triangles by the root of their tree.
    pub fn triangles(root: u32, one_sided: bool) -> Self {
        Self { kind: 3, data: root, one_sided, transform: None, moves: false }
    }

    /// A displaced sphere by the place of its numbers.
    pub fn relief_sphere(place: u32) -> Self {
        Self { kind: 4, data: place, one_sided: false, transform: None, moves: false }
    }

    /// A displaced mesh by the place of its numbers.
    pub fn relief_mesh(place: u32) -> Self {
        Self { kind: 5, data: place, one_sided: false, transform: None, moves: false }
    }

    /// A surface that no ray meets.
    pub fn nothing() -> Self {
        Self { kind: 0, data: 0, one_sided: false, transform: None, moves: false }
    }

    /// The same surface as an instance shows it, by the place of the transform in `numbers`.
    pub fn shown_at(self, transform: u32) -> Self {
        Self { transform: Some(transform), ..self }
    }

    /// The same surface in motion, by the place of the transform and the motion in `numbers`.
    pub fn moving_at(self, transform: u32) -> Self {
        Self { transform: Some(transform), moves: true, ..self }
    }

    /// Appends the record.
    pub fn write(&self, words: &mut Vec<u32>) {
        let flags = u32::from(self.one_sided) * ONE_SIDED + u32::from(self.moves) * MOVES;
        words.extend([self.kind, self.data, self.transform.unwrap_or(NOTHING), flags]);
    }
}

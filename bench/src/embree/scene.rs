//! [`Scene`]: a height map or a mesh as Embree geometry, committed.

use std::ptr::NonNull;
use std::slice;

use rilievo::map::HeightMap;

use super::device::Device;
use super::ffi;

/// What a height map is tessellated to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// Two triangles a cell, medium quality.
    Triangles,
    /// A quad a cell, medium quality.
    Quads,
    /// One GRID over the whole map in a compact scene.
    Grid,
}

impl Shape {
    /// Most bytes a cell while a scene is built, rounded up from what was measured at 4096 x 4096.
    pub fn peak_bytes_per_cell(self) -> u64 {
        match self {
            Self::Triangles => 235,
            Self::Quads => 150,
            Self::Grid => 30,
        }
    }

    /// Scene flags and build quality, as words for the record.
    pub fn flags(self) -> &'static str {
        match self {
            Self::Triangles | Self::Quads => "quality medium, scene flags none, not robust",
            Self::Grid => "quality medium, scene flags compact, not robust",
        }
    }

    fn geometry_type(self) -> u32 {
        match self {
            Self::Triangles => ffi::GEOMETRY_TYPE_TRIANGLE,
            Self::Quads => ffi::GEOMETRY_TYPE_QUAD,
            Self::Grid => ffi::GEOMETRY_TYPE_GRID,
        }
    }
}

/// A committed scene with the device it lives on.
pub struct Scene {
    raw: NonNull<ffi::SceneTy>,
    device: Device,
}

/// A geometry that is released when it goes out of scope.
struct Geometry(NonNull<ffi::GeometryTy>);

impl Scene {
    /// `map` on the unit square with heights from 0 to `depth` scene units, tessellated sample by
    /// sample.
    ///
    /// # Errors
    /// What Embree refuses; a map of more than 32767 samples a side.
    pub fn of_heights(
        config: &str,
        shape: Shape,
        map: &HeightMap,
        depth: f64,
    ) -> Result<Self, String> {
        let device = Device::new(config)?;
        let (width, height) = (map.width(), map.height());
        if width.max(height) > 32767 {
            return Err("Embree's GRID has at most 32767 vertices a side".to_owned());
        }
        let mut geometry = Geometry::new(&device, shape)?;
        let count = width as usize * height as usize;
        let vertices =
            geometry.buffer::<[f32; 3]>(ffi::BUFFER_TYPE_VERTEX, ffi::FORMAT_FLOAT3, count)?;
        fill_vertices(vertices, map, depth);
        let cells = (width as usize - 1) * (height as usize - 1);
        match shape {
            Shape::Triangles => {
                let kind = ffi::BUFFER_TYPE_INDEX;
                let all = geometry.buffer::<[u32; 3]>(kind, ffi::FORMAT_UINT3, 2 * cells)?;
                for (two, [a, b, c, d]) in all.chunks_exact_mut(2).zip(corners(width, height)) {
                    two[0] = [a, b, d];
                    two[1] = [c, d, b];
                }
            }
            Shape::Quads => {
                let kind = ffi::BUFFER_TYPE_INDEX;
                let all = geometry.buffer::<[u32; 4]>(kind, ffi::FORMAT_UINT4, cells)?;
                for (quad, corners) in all.iter_mut().zip(corners(width, height)) {
                    *quad = corners;
                }
            }
            Shape::Grid => {
                let all =
                    geometry.buffer::<ffi::Grid>(ffi::BUFFER_TYPE_GRID, ffi::FORMAT_GRID, 1)?;
                let (side_x, side_y) = (width as u16, height as u16);
                all[0] =
                    ffi::Grid { start_vertex_id: 0, stride: width, width: side_x, height: side_y };
            }
        }
        let flags = match shape {
            Shape::Triangles | Shape::Quads => ffi::SCENE_FLAG_NONE,
            Shape::Grid => ffi::SCENE_FLAG_COMPACT,
        };
        Self::committed(device, &geometry, flags)
    }

    /// Triangles, in a robust scene of medium quality.
    ///
    /// # Errors
    /// What Embree refuses.
    pub fn of_triangles(
        config: &str,
        positions: &[[f32; 3]],
        triangles: &[[u32; 3]],
    ) -> Result<Self, String> {
        let device = Device::new(config)?;
        let mut geometry = Geometry::new(&device, Shape::Triangles)?;
        let (kind, format) = (ffi::BUFFER_TYPE_VERTEX, ffi::FORMAT_FLOAT3);
        geometry.buffer::<[f32; 3]>(kind, format, positions.len())?.copy_from_slice(positions);
        let (kind, format) = (ffi::BUFFER_TYPE_INDEX, ffi::FORMAT_UINT3);
        geometry.buffer::<[u32; 3]>(kind, format, triangles.len())?.copy_from_slice(triangles);
        Self::committed(device, &geometry, ffi::SCENE_FLAG_ROBUST)
    }

    /// A scene of one filled geometry of its device.
    fn committed(device: Device, geometry: &Geometry, flags: u32) -> Result<Self, String> {
        // SAFETY: device and geometry are alive; all buffers are set and filled.
        let raw = unsafe { ffi::rtcNewScene(device.as_ptr()) };
        let scene = Self { raw: NonNull::new(raw).ok_or("Embree makes no scene")?, device };
        // SAFETY: scene and geometry are alive and belong to one device; the scene takes its own
        // reference to the geometry.
        unsafe {
            ffi::rtcSetGeometryBuildQuality(geometry.0.as_ptr(), ffi::BUILD_QUALITY_MEDIUM);
            ffi::rtcCommitGeometry(geometry.0.as_ptr());
            ffi::rtcSetSceneFlags(scene.as_ptr(), flags);
            ffi::rtcSetSceneBuildQuality(scene.as_ptr(), ffi::BUILD_QUALITY_MEDIUM);
            ffi::rtcAttachGeometry(scene.as_ptr(), geometry.0.as_ptr());
            ffi::rtcCommitScene(scene.as_ptr());
        }
        scene.device.check()?;
        Ok(scene)
    }

    /// The handle; valid as long as `self`.
    pub(super) fn as_ptr(&self) -> *mut ffi::SceneTy {
        self.raw.as_ptr()
    }

    /// Bytes of buffers and hierarchy: now, and at most while they were built.
    pub fn bytes(&self) -> (u64, u64) {
        self.device.bytes()
    }

    /// The library's version, as `3.13.5`.
    pub fn version(&self) -> String {
        let v = self.device.version();
        format!("{}.{}.{}", v / 10000, v / 100 % 100, v % 100)
    }
}

impl Drop for Scene {
    fn drop(&mut self) {
        // SAFETY: made by `of_heights`, released once, before its device.
        unsafe { ffi::rtcReleaseScene(self.as_ptr()) };
    }
}

impl Geometry {
    fn new(device: &Device, shape: Shape) -> Result<Self, String> {
        // SAFETY: the device is alive and the type is one of the header's.
        let raw = unsafe { ffi::rtcNewGeometry(device.as_ptr(), shape.geometry_type()) };
        NonNull::new(raw).map(Self).ok_or_else(|| "Embree makes no geometry".to_owned())
    }

    /// A new buffer of `count` items, owned by the geometry. `T` is the item of `format`.
    fn buffer<T: Default + Copy>(
        &mut self,
        kind: u32,
        format: u32,
        count: usize,
    ) -> Result<&mut [T], String> {
        // SAFETY: the geometry is alive and not committed; the stride is the item's size.
        let raw = unsafe {
            let stride = size_of::<T>();
            ffi::rtcSetNewGeometryBuffer(self.0.as_ptr(), kind, 0, format, stride, count)
        };
        let items = NonNull::new(raw.cast::<T>()).ok_or("Embree is out of memory")?;
        // SAFETY: Embree aligns buffers to 16 bytes and keeps them as long as the geometry; every
        // call makes a new one, so no two slices overlap. All bytes are written here first.
        unsafe {
            for k in 0..count {
                items.add(k).write(T::default());
            }
            Ok(slice::from_raw_parts_mut(items.as_ptr(), count))
        }
    }
}

impl Drop for Geometry {
    fn drop(&mut self) {
        // SAFETY: made by `new`, released once; a scene holds a reference of its own.
        unsafe { ffi::rtcReleaseGeometry(self.0.as_ptr()) };
    }
}

/// Vertices row-major: sample (i, j) at (i / (w - 1), j / (h - 1), depth * height).
fn fill_vertices(vertices: &mut [[f32; 3]], map: &HeightMap, depth: f64) {
    let scale = map.unit() * depth;
    let width = map.width() as usize;
    for (j, row) in (0..).zip(vertices.chunks_exact_mut(width)) {
        let y = map.y().parameter(f64::from(j)) as f32;
        for (i, vertex) in (0..).zip(row) {
            let z = (f64::from(map.raw(i, j)) * scale) as f32;
            *vertex = [map.x().parameter(f64::from(i)) as f32, y, z];
        }
    }
}

/// Vertex numbers of each cell's corners, counterclockwise seen from above.
fn corners(width: u32, height: u32) -> impl Iterator<Item = [u32; 4]> {
    (0..height - 1).flat_map(move |j| {
        (0..width - 1).map(move |i| {
            let first = j * width + i;
            [first, first + 1, first + width + 1, first + width]
        })
    })
}

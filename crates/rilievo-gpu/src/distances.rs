//! [`Distances`]: the distance maps of a world, on their way to a 3-D texture.
//!
//! All of them lie in one texture of 16-bit codes, one above the other along z, so that worlds of any number of them bind
//! the same. What else a walk asks of a map is told in words among the bounds: [`HEADER`] of them, then the lowest and the
//! highest height of each column. Lengths are in units of the metric's largest side: a step is a ratio of
//! lengths, and floats hold any metric so.

use std::collections::HashMap;

use rayon::prelude::*;
use rilievo::map::{Codes, DistanceKind, DistanceMap, HeightMap};

use crate::device::Gpu;
use crate::error::GpuError;
use crate::records::Words;

/// Words that tell of a map; `load_distance_map` of `shaders/distance.wgsl` reads them in their order.
const HEADER: u64 = 16;

/// Distance maps and their places.
#[derive(Default)]
pub(crate) struct Distances<'a> {
    maps: Vec<Planned<'a>>,
    /// By address.
    places: HashMap<usize, u32>,
    /// Slices of all.
    slices: u32,
}

struct Planned<'a> {
    map: &'a DistanceMap,
    heights: &'a HeightMap,
    /// First word among the bounds.
    place: u32,
    /// First slice in the texture.
    slice: u32,
}

/// What the places of a distance map depend on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct DistanceShape {
    kind: DistanceKind,
    place: u32,
    slice: u32,
    size: [u32; 3],
}

impl Planned<'_> {
    fn shape(&self) -> DistanceShape {
        let Self { map, place, slice, .. } = *self;
        DistanceShape { kind: map.kind(), place, slice, size: map.size() }
    }

    fn write_codes(&self, gpu: &Gpu, texture: &wgpu::Texture) {
        let widened: Vec<u16>;
        let codes = match self.map.codes() {
            Codes::U16(codes) => codes,
            Codes::U8(codes) => {
                widened = codes.iter().map(|&code| code.into()).collect();
                &widened
            }
        };
        let [x, y, _] = self.map.size();
        gpu.traffic.add_maps(2 * codes.len());
        gpu.queue.write_texture(
            wgpu::TexelCopyTextureInfo {
                texture,
                mip_level: 0,
                origin: wgpu::Origin3d { x: 0, y: 0, z: self.slice },
                aspect: wgpu::TextureAspect::All,
            },
            bytemuck::cast_slice(codes),
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(2 * x),
                rows_per_image: Some(y),
            },
            extent(self.map.size()),
        );
    }
}

impl<'a> Distances<'a> {
    /// Where a map is told of; `end` is where the bounds end so far.
    pub fn place(&mut self, map: &'a DistanceMap, heights: &'a HeightMap, end: &mut u64) -> u32 {
        let address = std::ptr::from_ref(map).addr();
        if let Some(place) = self.places.get(&address) {
            return *place;
        }
        let place = *end as u32;
        let [x, y] = footprints(map);
        *end += HEADER + 2 * u64::from(x) * u64::from(y);
        self.maps.push(Planned { map, heights, place, slice: self.slices });
        self.slices = self.slices.saturating_add(map.size()[2]);
        self.places.insert(address, place);
        place
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.maps.is_empty()
    }

    /// The texture of all codes; none for no maps.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] if a side is larger than the device allows; [`GpuError::OutOfMemory`],
    /// [`GpuError::Lost`].
    pub fn texture(&self, gpu: &Gpu) -> Result<Option<wgpu::Texture>, GpuError> {
        if self.is_empty() {
            return Ok(None);
        }
        let side =
            |axis: usize| self.maps.iter().map(|map| map.map.size()[axis]).max().unwrap_or(1);
        let sides = [side(0), side(1), self.slices];
        let allowed = gpu.device.limits().max_texture_dimension_3d;
        if sides.iter().any(|&side| side > allowed) {
            let bytes = |sides: [u32; 3]| 2 * sides.iter().map(|&n| u64::from(n)).product::<u64>();
            let most = bytes(sides.map(|side| side.min(allowed)));
            return Err(gpu.too_large("distance maps", bytes(sides), most));
        }
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("distance maps"),
            size: extent(sides),
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D3,
            format: wgpu::TextureFormat::R16Uint,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        gpu.check()?;
        self.maps.iter().for_each(|planned| planned.write_codes(gpu, &texture));
        gpu.check()?;
        Ok(Some(texture))
    }

    /// Where maps lie and how large they are.
    pub fn shapes(&self) -> Vec<DistanceShape> {
        self.maps.iter().map(Planned::shape).collect()
    }

    /// Brings those over that lie over a height map, which was edited: codes into the texture, and the words that tell of
    /// them, each with its place, to `write`.
    pub fn follow(
        &self,
        gpu: &Gpu,
        texture: &wgpu::Texture,
        heights: &HeightMap,
        write: impl Fn(u32, &[u32]),
    ) {
        let own = self.maps.iter().filter(|planned| std::ptr::eq(planned.heights, heights));
        for planned in own {
            planned.write_codes(gpu, texture);
            write(planned.place, &words(planned));
        }
    }

    /// The words that tell of each map, and where they go.
    pub fn words(&self) -> impl Iterator<Item = (u32, Vec<u32>)> {
        self.maps.iter().map(|planned| (planned.place, words(planned)))
    }
}

fn extent([width, height, depth_or_array_layers]: [u32; 3]) -> wgpu::Extent3d {
    wgpu::Extent3d { width, height, depth_or_array_layers }
}

/// Voxels, or steps between nodes, along x and y.
fn footprints(map: &DistanceMap) -> [u32; 2] {
    let [x, y, _] = map.size().map(|n| n + 1 - map.kind().least_size());
    [x, y]
}

fn words(&Planned { map, heights, place, slice }: &Planned<'_>) -> Vec<u32> {
    let kind = match map.kind() {
        DistanceKind::Boxes => 0,
        DistanceKind::Corrected => 1,
        DistanceKind::Published => 2,
    };
    let mut words = vec![kind, slice];
    words.extend(map.size());
    let (low, high) = map.raw_range();
    let [cells_x, cells_y] = map.cells().map(f64::from);
    let extents = [cells_x, cells_y, f64::from(high) - f64::from(low)];
    let steps = map.size().map(|n| f64::from(n + 1 - map.kind().least_size()));
    let metric = map.metric();
    let metric = [metric.x, metric.y, metric.z];
    let axes = [0, 1, 2];
    // Lengths of rays are about 1 then, whatever the unit of heights, and their squares are floats.
    let largest = axes.map(|a| extents[a] * metric[a]).into_iter().fold(0.0, f64::max);
    let metric = metric.map(|side| side / largest);
    let density = axes.map(|a| if extents[a] > 0.0 { steps[a] / extents[a] } else { 0.0 });
    let sides = axes.map(|a| extents[a] * metric[a] / steps[a]);
    for number in density.into_iter().chain(sides).chain(metric).chain([map.quantum() / largest]) {
        words.float(number as f32);
    }
    words.push(place.wrapping_add(HEADER as u32));
    debug_assert_eq!(words.len() as u64, HEADER);
    words.extend(columns(heights, footprints(map)));
    words
}

/// Lowest and highest height under each footprint, as `map/distance/columns.rs` has them.
pub(crate) fn columns(heights: &HeightMap, [nx, ny]: [u32; 2]) -> Vec<u32> {
    let cells = |i: u32, n: u32, cells: u32| {
        let [i, n, cells] = [i, n, cells].map(u64::from);
        (i * cells / n) as u32..((i + 1) * cells).div_ceil(n) as u32
    };
    let column = |at: u32| {
        let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
        for cy in cells(at / nx, ny, heights.y().cells()) {
            for cx in cells(at % nx, nx, heights.x().cells()) {
                for h in heights.stored_corners(cx, cy) {
                    (low, high) = (low.min(h), high.max(h));
                }
            }
        }
        [low.to_bits(), high.to_bits()]
    };
    (0..nx * ny).into_par_iter().flat_map_iter(column).collect()
}

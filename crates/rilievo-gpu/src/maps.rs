//! [`Maps`]: heights and bounds of a world's maps on a device.
//!
//! Heights are copied as the CPU holds them, bounds are built on the device (`pyramid_build`), and an
//! edit brings over the samples of its rectangle and makes anew what lies above them. Places are words in one address space
//! for all maps, cut into pages where a device binds less at once (`pages`).

use std::collections::HashMap;
use std::ops::Range;

use rilievo::map::{Code, DistanceKind, HeightMap, Layout, NodeRuns, Pyramid, Samples};
use rilievo::relief::{Method, Relief};

use crate::bounds::{self, LEVEL_WORDS};
use crate::device::{Gpu, Kernel};
use crate::distances::{DistanceShape, Distances};
use crate::error::GpuError;
use crate::pages::{Paged, Pages};
use crate::pyramid_build::PyramidBuild;
use crate::records::{FaceWalk, MapPlace};
use crate::shaders::Walks;

/// The maps of a world and where they are to lie, before anything is on the device.
#[derive(Default)]
pub(crate) struct MapPlan<'a> {
    maps: Vec<PlannedMap<'a>>,
    /// By address.
    numbers: HashMap<usize, usize>,
    heights: u64,
    bounds: u64,
    distances: Distances<'a>,
    walks: Walks,
}

struct PlannedMap<'a> {
    relief: &'a Relief,
    shape: Shape,
}

/// What the place of a map in the buffers depends on, and the build of its pyramid.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Shape {
    pub samples: [u32; 2],
    pub cells: [u32; 2],
    /// Whether stored cell 0 begins a cell before sample 0.
    pub padded: bool,
    pub floats: bool,
    pub place: MapPlace,
    /// Finest first.
    pub levels: Vec<LevelPlace>,
}

/// Where a level of a pyramid lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LevelPlace {
    pub nodes: [u32; 2],
    pub maxima: u32,
    pub minima: u32,
}

/// Words of a node's maxima or minima.
const NODE_SIDE: u64 = 8;

impl Shape {
    /// That of a map whose samples and table begin at these words; and the words that its bounds take. Places past
    /// 32 bits are wrong here, and refused when the buffers are made.
    fn new(map: &HeightMap, [heights, bounds]: [u64; 2]) -> (Self, u64) {
        let cells = [map.x().cells(), map.y().cells()];
        let count = bounds::levels(map);
        let mut at = bounds + u64::from(count) * LEVEL_WORDS as u64;
        let mut level = |level: u32| {
            let nodes = cells.map(|n| n.div_ceil(16 << (2 * level)));
            let side = NODE_SIDE * u64::from(nodes[0]) * u64::from(nodes[1]);
            let place = LevelPlace { nodes, maxima: at as u32, minima: (at + side) as u32 };
            at += 2 * side;
            place
        };
        let levels = (0..count).map(&mut level).collect();
        let shape = Self {
            samples: [map.width(), map.height()],
            cells,
            padded: map.x().first_cell() < 0,
            floats: matches!(map.samples(), Samples::F32(_)),
            place: MapPlace { heights: heights as u32, bounds: bounds as u32 },
            levels,
        };
        (shape, at - bounds)
    }

    /// Words of the samples.
    fn height_words(&self) -> u64 {
        let samples = self.samples.iter().map(|&n| u64::from(n)).product::<u64>();
        if self.floats { samples } else { samples.div_ceil(2) }
    }

    /// All nodes of the finest level.
    fn all_runs(&self) -> [NodeRuns; 2] {
        self.levels[0].nodes.map(|n| [0..n, 0..0])
    }

    /// The table of the pyramid.
    fn table(&self) -> Vec<u32> {
        self.levels.iter().flat_map(|level| [level.nodes[0], level.maxima, level.minima]).collect()
    }
}

impl<'a> MapPlan<'a> {
    /// Where the map of a relief is to lie; each map lies there once.
    pub fn place(&mut self, relief: &'a Relief) -> MapPlace {
        let Self { maps, numbers, heights, bounds, .. } = self;
        let number = *numbers.entry(std::ptr::from_ref(relief).addr()).or_insert_with(|| {
            let (shape, words) = Shape::new(relief.heights(), [*heights, *bounds]);
            *heights += shape.height_words();
            *bounds += words;
            maps.push(PlannedMap { relief, shape });
            maps.len() - 1
        });
        maps[number].shape.place
    }

    /// How a method walks a relief.
    pub fn place_walk(&mut self, relief: &'a Relief, method: Method) -> FaceWalk {
        if method == Method::March {
            self.walks.marched = true;
            return FaceWalk::March;
        }
        let map = method.distance_kind().and_then(|kind| relief.distance(kind));
        let Some(map) = map else {
            self.walks.bounds = true;
            return FaceWalk::Bounds;
        };
        self.walks.published |= map.kind() == DistanceKind::Published;
        self.walks.distances |= map.kind() != DistanceKind::Published;
        FaceWalk::Distance(self.distances.place(map, relief.heights(), &mut self.bounds))
    }

    /// All walks that are asked for, at least one: a kernel without any would bind something else.
    fn all_walks(&self) -> Walks {
        let nothing = self.walks == Walks::default();
        Walks { bounds: self.walks.bounds || nothing, ..self.walks }
    }

    /// More walks that the surfaces over these maps ask for.
    pub fn add_walks(&mut self, walks: Walks) {
        self.walks = self.walks.and(walks);
    }

    /// Which of the maps is that of a relief.
    pub fn number(&self, relief: &Relief) -> Option<usize> {
        self.numbers.get(&std::ptr::from_ref(relief).addr()).copied()
    }
}

/// Heights and bounds on a device.
pub(crate) struct Maps {
    heights: Paged,
    bounds: Paged,
    /// The codes of distance maps, if there are any.
    distances: Option<wgpu::Texture>,
    distance_shapes: Vec<DistanceShape>,
    walks: Walks,
    maps: Vec<MapOnDevice>,
}

struct MapOnDevice {
    shape: Shape,
    /// What its bounds mean.
    code: Code,
}

impl Maps {
    /// Brings maps to a device and builds their pyramids there.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`], [`GpuError::OutOfMemory`], [`GpuError::Lost`].
    pub fn new(gpu: &Gpu, plan: &MapPlan<'_>) -> Result<Self, GpuError> {
        let heights = Paged::new(gpu, "height maps", plan.heights)?;
        let bounds = Paged::new(gpu, "bounds", plan.bounds)?;
        gpu.check_pages(heights.pages().count + bounds.pages().count, 4 * plan.heights)?;
        let distances = plan.distances.texture(gpu)?;
        let walks = plan.all_walks();
        let distance_shapes = plan.distances.shapes();
        let maps = Vec::new();
        let mut made = Self { heights, bounds, distances, distance_shapes, walks, maps };
        for (place, words) in plan.distances.words() {
            made.bounds.write(gpu, place.into(), bytemuck::cast_slice(&words));
        }
        let mut build = PyramidBuild::default();
        for PlannedMap { relief, shape } in &plan.maps {
            let first = u64::from(shape.place.heights);
            match relief.heights().samples() {
                Samples::U16(codes) => made.heights.write(gpu, first, bytemuck::cast_slice(codes)),
                Samples::F32(all) => made.heights.write(gpu, first, bytemuck::cast_slice(all)),
            }
            let table = shape.table();
            let place = u64::from(shape.place.bounds);
            made.bounds.write(gpu, place, bytemuck::cast_slice(&table));
            let code = relief.pyramid().code();
            let map = MapOnDevice { shape: shape.clone(), code };
            made.rebuild(gpu, &map, (relief, None), &mut build);
            made.maps.push(map);
        }
        build.run(gpu, &made)?;
        Ok(made)
    }

    /// Whether a plan's maps lie where these do, so that an edit is all that parts them.
    pub fn fits(&self, plan: &MapPlan<'_>) -> bool {
        let own = self.maps.iter().map(|map| &map.shape);
        own.eq(plan.maps.iter().map(|map| &map.shape))
            && self.distance_shapes == plan.distances.shapes()
    }

    /// Follows edits of maps, each by its number and the columns and rows that may have changed, and whatever else the
    /// surfaces over them are now.
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`], [`GpuError::Lost`].
    pub fn edit(
        &mut self,
        gpu: &Gpu,
        plan: &MapPlan<'_>,
        edits: &[(usize, [Range<u32>; 2])],
    ) -> Result<(), GpuError> {
        self.walks = plan.all_walks();
        let mut build = PyramidBuild::default();
        for (number, [x, y]) in edits {
            let Some(PlannedMap { relief, .. }) = plan.maps.get(*number) else { continue };
            let Some(map) = self.maps.get_mut(*number) else { continue };
            let code = relief.pyramid().code();
            let same = map.code == code;
            map.code = code;
            let map = &self.maps[*number];
            let [width, height] = map.shape.samples;
            let rect = [x.start..x.end.min(width), y.start..y.end.min(height)];
            if rect.iter().any(Range::is_empty) {
                continue;
            }
            self.write_rect(gpu, &map.shape, relief.heights(), rect.clone());
            self.rebuild(gpu, map, (relief, same.then_some(rect)), &mut build);
            if let Some(texture) = &self.distances {
                let write = |place: u32, words: &[u32]| {
                    self.bounds.write(gpu, place.into(), bytemuck::cast_slice(words));
                };
                plan.distances.follow(gpu, texture, relief.heights(), write);
            }
        }
        build.run(gpu, self)
    }

    /// The build of all pyramids that the device makes.
    pub fn full_build(&self) -> PyramidBuild {
        let mut build = PyramidBuild::default();
        for map in self.maps.iter().filter(|map| PyramidBuild::knows(map.code)) {
            build.add(&map.shape, map.code, map.shape.all_runs());
        }
        build
    }

    /// The kernel that finds nearest hits among these maps.
    pub fn closest(&self) -> Kernel {
        Kernel::Closest(self.walks)
    }

    /// How heights and bounds are cut, in this order.
    pub fn pages(&self) -> [Pages; 2] {
        [self.heights.pages(), self.bounds.pages()]
    }

    /// Groups of bounds, heights and, if there are any, distances for a kernel that traces: groups 1, 2 and 3.
    pub fn groups(&self, gpu: &Gpu, pipeline: &wgpu::ComputePipeline) -> Vec<wgpu::BindGroup> {
        let mut groups = self.build_groups(gpu, pipeline, true);
        if let Some(texture) = &self.distances {
            let view = texture.create_view(&Default::default());
            groups.push(gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("distances"),
                layout: &pipeline.get_bind_group_layout(3),
                entries: &[wgpu::BindGroupEntry {
                    binding: 0,
                    resource: wgpu::BindingResource::TextureView(&view),
                }],
            }));
        }
        groups
    }

    /// The group of heights for a kernel that shades: group 1.
    pub fn heights_group(&self, gpu: &Gpu, pipeline: &wgpu::ComputePipeline) -> wgpu::BindGroup {
        let entries: Vec<_> = (0..)
            .zip(self.heights.buffers())
            .map(|(binding, buffer)| wgpu::BindGroupEntry {
                binding,
                resource: buffer.as_entire_binding(),
            })
            .collect();
        gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("heights"),
            layout: &pipeline.get_bind_group_layout(1),
            entries: &entries,
        })
    }

    /// Groups of bounds and, if the kernel reads them, of heights: groups 1 and 2.
    pub fn build_groups(
        &self,
        gpu: &Gpu,
        pipeline: &wgpu::ComputePipeline,
        heights: bool,
    ) -> Vec<wgpu::BindGroup> {
        let sides = [Some(&self.bounds), heights.then_some(&self.heights)];
        let group = |(index, side): (u32, &Paged)| {
            let entries: Vec<_> = (0..)
                .zip(side.buffers())
                .map(|(binding, buffer)| wgpu::BindGroupEntry {
                    binding,
                    resource: buffer.as_entire_binding(),
                })
                .collect();
            gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("maps"),
                layout: &pipeline.get_bind_group_layout(index),
                entries: &entries,
            })
        };
        (1..).zip(sides.into_iter().flatten()).map(group).collect()
    }

    /// Has the pyramid of a map made on the device: all of it, or what lies above a rectangle of samples. Codes that
    /// a device may not tell from 0 are taken from the CPU.
    fn rebuild(
        &self,
        gpu: &Gpu,
        map: &MapOnDevice,
        (relief, touched): (&Relief, Option<[Range<u32>; 2]>),
        build: &mut PyramidBuild,
    ) {
        if !PyramidBuild::knows(map.code) {
            let mut words = Vec::new();
            let first = map.shape.place.bounds;
            if !bounds::write_bounds(&mut words, first, relief.pyramid()) {
                let own = Pyramid::build_as(relief.heights(), Layout::Default);
                words.clear();
                bounds::write_bounds(&mut words, first, &own);
            }
            self.bounds.write(gpu, u64::from(first), bytemuck::cast_slice(&words));
            return;
        }
        let runs = match touched {
            None => map.shape.all_runs(),
            Some([x, y]) => {
                let heights = relief.heights();
                [(heights.x(), x), (heights.y(), y)]
                    .map(|(axis, changed)| Pyramid::touched_nodes(axis, &changed))
            }
        };
        build.add(&map.shape, map.code, runs);
    }

    /// Writes the samples of a rectangle, which is not empty, row by row in whole words.
    fn write_rect(&self, gpu: &Gpu, shape: &Shape, map: &HeightMap, [x, y]: [Range<u32>; 2]) {
        let width = u64::from(shape.samples[0]);
        let whole = u64::from(x.end - x.start) == width;
        // Rows that are whole lie one behind the other.
        let rows = if whole { vec![y] } else { y.map(|j| j..j + 1).collect() };
        for rows in rows {
            let first = u64::from(rows.start) * width + u64::from(x.start);
            let end = u64::from(rows.end - 1) * width + u64::from(x.end);
            let place = u64::from(shape.place.heights);
            match map.samples() {
                Samples::U16(codes) => {
                    let (first, end) =
                        (first / 2 * 2, (end.div_ceil(2) * 2).min(codes.len() as u64));
                    let part = &codes[first as usize..end as usize];
                    self.heights.write(gpu, place + first / 2, bytemuck::cast_slice(part));
                }
                Samples::F32(all) => {
                    let part = &all[first as usize..end as usize];
                    self.heights.write(gpu, place + first, bytemuck::cast_slice(part));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests;

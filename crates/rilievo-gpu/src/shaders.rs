//! The shaders, in one text for each entry point: WGSL has no modules, so files are joined here. Each
//! file is the twin of the CPU's module of its name. How the words of maps are bound is written here, for
//! they lie in one buffer or in several.

use rilievo_render::device::{HEAD, Parts};
use rilievo_render::light::{LIGHT_WORDS, TREE_WORDS};

use crate::forms::{SHELL_FORM, SHELL_WALL_FORM, SURFACE_RECORD, TRIANGLE_FORM};
use crate::pages::Pages;

/// Group of the words of bounds.
const BOUNDS: (&str, u32) = ("bound", 1);
/// Group of the words of heights.
const HEIGHTS: (&str, u32) = ("height", 2);

/// Which kinds of walk the displaced surfaces of a world ask for. A kernel holds these and no others: each takes drivers seconds
/// to compile.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(crate) struct Walks {
    /// By bounds.
    pub bounds: bool,
    /// By safe distances.
    pub distances: bool,
    /// As the paper has it.
    pub published: bool,
    /// By fixed steps.
    pub marched: bool,
    /// Displaced spheres.
    pub spheres: bool,
    /// Displaced meshes.
    pub meshes: bool,
    /// Surfaces that move, of any kind.
    pub moving: bool,
}

/// The nearest hit of many rays, by these walks, with heights and bounds that are cut into these pages.
pub(crate) fn closest(walks: Walks, [heights, bounds]: [Pages; 2]) -> String {
    let maps = [words(BOUNDS, bounds, false), words(HEIGHTS, heights, false)];
    [CLOSEST, &walks.text(), &maps.concat()].concat()
}

/// How light is worked out on the device.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(crate) struct Light {
    /// What the scene asks for; the rest is left out.
    pub parts: Parts,
    /// Whether there are displaced faces, spheres and meshes, and instances.
    pub faces: bool,
    pub relief_spheres: bool,
    pub relief_meshes: bool,
    pub instances: bool,
    /// Whether any of those move.
    pub moving: bool,
    /// Points of a tree of rays that wait at once.
    pub points: u32,
}

/// The next step of every camera ray on its way, with heights that are cut into these pages.
pub(crate) fn advance(light: Light, heights: Pages) -> String {
    let integrator = if light.parts.path { PATH } else { TREES };
    [SHADED, integrator, &light.text(), &words((HEIGHTS.0, 1), heights, false)].concat()
}

impl Light {
    /// The names of words, as `rilievo_render::device` places them, and what is left out.
    fn text(self) -> String {
        let Parts { images, normals, sky, metals, glass, principled, mixes, emitters, .. } =
            self.parts;
        let Self { faces, relief_spheres, relief_meshes, instances, moving, .. } = self;
        let jittered = self.parts.jittered;
        let flags = [
            ("IMAGES", images),
            ("NORMALS", normals),
            ("HAS_SKY", sky),
            ("METALS", metals),
            ("GLASSES", glass),
            ("PRINCIPLEDS", principled),
            ("MIXES", mixes),
            ("EMITTERS", emitters),
            ("JITTERED", jittered),
            ("FACES", faces),
            ("RELIEF_SPHERES", relief_spheres),
            ("RELIEF_MESHES", relief_meshes),
            ("INSTANCES", instances),
            ("MOVING", moving),
        ];
        let flags = flags.map(|(name, is)| format!("const {name}: bool = {is};\n"));
        let lengths = [
            ("LIGHT_RECORD", LIGHT_WORDS),
            ("TREE_RECORD", TREE_WORDS),
            ("SURFACE_RECORD", SURFACE_RECORD),
            ("TRIANGLE_FORM", TRIANGLE_FORM as u32),
            ("SHELL_FORM", SHELL_FORM as u32),
            ("SHELL_WALL_FORM", SHELL_WALL_FORM as u32),
            ("POINTS", self.points),
        ];
        let places = (0..).zip(HEAD).filter(|(_, name)| !name.is_empty());
        let places = places.map(|(place, name)| (name, place)).chain(lengths);
        let places = places.map(|(name, number)| format!("const {name}: u32 = {number}u;\n"));
        flags.into_iter().chain(places).collect()
    }
}

impl Walks {
    /// All that either asks for.
    pub fn and(self, other: Self) -> Self {
        Self {
            bounds: self.bounds || other.bounds,
            distances: self.distances || other.distances,
            published: self.published || other.published,
            marched: self.marched || other.marched,
            spheres: self.spheres || other.spheres,
            meshes: self.meshes || other.meshes,
            moving: self.moving || other.moving,
        }
    }

    /// The functions by which `shaders/trace.wgsl` walks the face at hand.
    fn text(self) -> String {
        let no_distance = "shown_map.distance == NOTHING";
        let by_bounds = "return walk_pyramid(tile, admitted());";
        let by_distance = "return walk_distance(tile, larger(begin, tile.enter), \
                           smaller(end, tile.leave), admitted());";
        let walk = match (self.bounds, self.distances) {
            (true, true) => format!("if {no_distance} {{ {by_bounds} }} {by_distance}"),
            (true, false) => by_bounds.to_owned(),
            (false, true) => by_distance.to_owned(),
            (false, false) => "return no_hit();".to_owned(),
        };
        let mut points = Vec::new();
        if self.marched {
            points.push(("shown_map.distance == MARCHED", "return meet_marched(t_max, number);"));
        }
        if self.published {
            points.push(("walks_published()", "return meet_published(t_max, number);"));
        }
        let meets = match (points.as_slice(), self.bounds || self.distances) {
            ([], _) => "false".to_owned(),
            (_, false) => "true".to_owned(),
            (points, true) => points.iter().map(|(is, _)| *is).collect::<Vec<_>>().join(" || "),
        };
        let meet = match points.as_slice() {
            [] => "var hit: Hit; hit.surface = NOTHING; return hit;".to_owned(),
            [(_, only)] => (*only).to_owned(),
            [(is, first), (_, second), ..] => format!("if {is} {{ {first} }} {second}"),
        };
        let faces = self.bounds || self.distances || !points.is_empty();
        let Self { spheres, meshes, moving, .. } = self;
        format!(
            "const FACES: bool = {faces};\n\
             const RELIEF_SPHERES: bool = {spheres};\n\
             const RELIEF_MESHES: bool = {meshes};\n\
             const MOVING: bool = {moving};\n\
             fn walk_tile(tile: Tile, begin: f32, end: f32) -> LeafHit {{ {walk} }}\n\
             fn meets_points() -> bool {{ return {meets}; }}\n\
             fn meet_points(t_max: Double, number: u32) -> Hit {{ {meet} }}\n"
        )
    }
}

/// Building pyramids.
pub(crate) fn pyramid([heights, bounds]: [Pages; 2]) -> String {
    let maps = [words(BOUNDS, bounds, true), words(HEIGHTS, heights, false)];
    PYRAMID.to_owned() + &maps.concat()
}

/// Making distance maps of kind boxes.
pub(crate) fn boxes([heights, _]: [Pages; 2]) -> String {
    BOXES.to_owned() + &words((HEIGHTS.0, 1), heights, false)
}

/// Making distance maps of the other kinds.
pub(crate) fn nearest([heights, bounds]: [Pages; 2]) -> String {
    let maps = [words(BOUNDS, bounds, false), words(HEIGHTS, heights, false)];
    NEAREST.to_owned() + &maps.concat()
}

/// Bindings of words in a group, and `<name>_word` that reads one; `set_<name>_word` where they may be written.
fn words((name, group): (&str, u32), pages: Pages, writable: bool) -> String {
    let access = if writable { "read_write" } else { "read" };
    let mut text = String::new();
    for page in 0..pages.count {
        text += &format!(
            "@group({group}) @binding({page}) var<storage, {access}> {name}_{page}: array<u32>;\n"
        );
    }
    let mask = (1u32 << pages.shift) - 1;
    // The last page answers for all that are not there.
    let choose = |each: &dyn Fn(u32, &str) -> String| {
        if pages.count == 1 {
            return each(0, "at");
        }
        let inner = format!("at & {mask}u");
        let cases =
            (0..pages.count - 1).map(|page| format!("case {page}u: {{ {} }} ", each(page, &inner)));
        let last = each(pages.count - 1, &inner);
        format!(
            "switch at >> {}u {{ {}default: {{ {last} }} }}",
            pages.shift,
            cases.collect::<String>()
        )
    };
    let read = choose(&|page, place| format!("return {name}_{page}[{place}];"));
    text += &format!("fn {name}_word(at: u32) -> u32 {{ {read} }}\n");
    if writable {
        let write = choose(&|page, place| format!("{name}_{page}[{place}] = word;"));
        text += &format!("fn set_{name}_word(at: u32, word: u32) {{ {write} }}\n");
    }
    text
}

const PYRAMID: &str = concat!(
    include_str!("shaders/float.wgsl"),
    include_str!("shaders/double.wgsl"),
    include_str!("shaders/samples.wgsl"),
    include_str!("shaders/pyramid.wgsl"),
);

const BOXES: &str = concat!(
    include_str!("shaders/samples.wgsl"),
    include_str!("shaders/whole.wgsl"),
    include_str!("shaders/exact.wgsl"),
    include_str!("shaders/boxes.wgsl"),
);

const NEAREST: &str = concat!(
    include_str!("shaders/float.wgsl"),
    include_str!("shaders/double.wgsl"),
    include_str!("shaders/samples.wgsl"),
    include_str!("shaders/nearest.wgsl"),
);

const CLOSEST: &str = concat!(
    include_str!("shaders/params.wgsl"),
    include_str!("shaders/bindings/closest.wgsl"),
    include_str!("shaders/float.wgsl"),
    include_str!("shaders/double.wgsl"),
    include_str!("shaders/map_ray.wgsl"),
    include_str!("shaders/height.wgsl"),
    include_str!("shaders/leaf.wgsl"),
    include_str!("shaders/refine.wgsl"),
    include_str!("shaders/tile.wgsl"),
    include_str!("shaders/walk.wgsl"),
    include_str!("shaders/distance.wgsl"),
    include_str!("shaders/approximate.wgsl"),
    include_str!("shaders/published.wgsl"),
    include_str!("shaders/walls.wgsl"),
    include_str!("shaders/trace.wgsl"),
    include_str!("shaders/triangle.wgsl"),
    include_str!("shaders/sphere.wgsl"),
    include_str!("shaders/sphere/radii.wgsl"),
    include_str!("shaders/sphere/leaf.wgsl"),
    include_str!("shaders/sphere/clip.wgsl"),
    include_str!("shaders/sphere/segment.wgsl"),
    include_str!("shaders/sphere/sweep.wgsl"),
    include_str!("shaders/sphere/walk.wgsl"),
    include_str!("shaders/sphere/crossing.wgsl"),
    include_str!("shaders/mesh/line.wgsl"),
    include_str!("shaders/mesh/frame.wgsl"),
    include_str!("shaders/mesh/prism.wgsl"),
    include_str!("shaders/mesh/patch.wgsl"),
    include_str!("shaders/mesh/leaf.wgsl"),
    include_str!("shaders/mesh/wall.wgsl"),
    include_str!("shaders/mesh/departure.wgsl"),
    include_str!("shaders/mesh/walk.wgsl"),
    include_str!("shaders/motion.wgsl"),
    include_str!("shaders/world.wgsl"),
    include_str!("shaders/closest.wgsl"),
);

/// What all integrators share.
const SHADED: &str = concat!(
    include_str!("shaders/params.wgsl"),
    include_str!("shaders/bindings/advance.wgsl"),
    include_str!("shaders/float.wgsl"),
    include_str!("shaders/double.wgsl"),
    include_str!("shaders/map_ray.wgsl"),
    include_str!("shaders/height.wgsl"),
    include_str!("shaders/scene/words.wgsl"),
    include_str!("shaders/scene/angle.wgsl"),
    include_str!("shaders/sampler/hash.wgsl"),
    include_str!("shaders/sampler/warp.wgsl"),
    include_str!("shaders/texture/image.wgsl"),
    include_str!("shaders/texture/input.wgsl"),
    include_str!("shaders/motion.wgsl"),
    include_str!("shaders/hit/point.wgsl"),
    include_str!("shaders/hit/face.wgsl"),
    include_str!("shaders/hit/flat.wgsl"),
    include_str!("shaders/hit/sphere.wgsl"),
    include_str!("shaders/hit/mesh.wgsl"),
    include_str!("shaders/light/light.wgsl"),
    include_str!("shaders/light/rectangle.wgsl"),
    include_str!("shaders/light/environment.wgsl"),
    include_str!("shaders/bsdf/frame.wgsl"),
);

const TREES: &str = include_str!("shaders/integrator/distributed.wgsl");

const PATH: &str = concat!(
    include_str!("shaders/sampler/path.wgsl"),
    include_str!("shaders/light/tree.wgsl"),
    include_str!("shaders/light/emitter.wgsl"),
    include_str!("shaders/light/lighting.wgsl"),
    include_str!("shaders/bsdf/microfacet.wgsl"),
    include_str!("shaders/bsdf/diffuse.wgsl"),
    include_str!("shaders/bsdf/part.wgsl"),
    include_str!("shaders/bsdf/conductor.wgsl"),
    include_str!("shaders/bsdf/glass.wgsl"),
    include_str!("shaders/bsdf/principled.wgsl"),
    include_str!("shaders/bsdf/mod.wgsl"),
    include_str!("shaders/integrator/path.wgsl"),
);

#[cfg(test)]
mod tests;

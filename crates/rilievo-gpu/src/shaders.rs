//! The shaders, in one text for each entry point: WGSL has no modules, so files are joined here. Each
//! file is the twin of the CPU's module of its name.

/// The nearest hit of many rays.
pub(crate) const CLOSEST: &str = concat!(
    include_str!("shaders/params.wgsl"),
    include_str!("shaders/float.wgsl"),
    include_str!("shaders/double.wgsl"),
    include_str!("shaders/map_ray.wgsl"),
    include_str!("shaders/height.wgsl"),
    include_str!("shaders/leaf.wgsl"),
    include_str!("shaders/refine.wgsl"),
    include_str!("shaders/tile.wgsl"),
    include_str!("shaders/walk.wgsl"),
    include_str!("shaders/walls.wgsl"),
    include_str!("shaders/trace.wgsl"),
    include_str!("shaders/triangle.wgsl"),
    include_str!("shaders/sphere.wgsl"),
    include_str!("shaders/world.wgsl"),
    include_str!("shaders/closest.wgsl"),
);

#[cfg(test)]
mod tests {
    use wgpu::naga;

    use super::*;
    use crate::records;

    /// The shader as every device without optional features must take it.
    fn validated(text: &str) -> naga::Module {
        let module = naga::front::wgsl::parse_str(text)
            .unwrap_or_else(|error| panic!("{}", error.emit_to_string(text)));
        let mut validator = naga::valid::Validator::new(
            naga::valid::ValidationFlags::all(),
            naga::valid::Capabilities::empty(),
        );
        if let Err(error) = validator.validate(&module) {
            panic!("{}", error.emit_to_string(text));
        }
        module
    }

    #[test]
    fn shaders_are_valid_without_optional_features() {
        let module = validated(CLOSEST);
        assert_eq!(module.entry_points.len(), 1);
    }

    #[test]
    fn structs_take_the_bytes_that_are_written() {
        let module = validated(CLOSEST);
        for (name, words) in [
            ("Ray", records::RAY_WORDS),
            ("Hit", records::HIT_WORDS),
            ("Face", records::FACE_WORDS),
            ("Surface", records::SURFACE_WORDS),
            ("Node", records::NODE_WORDS),
        ] {
            let found = module.types.iter().find_map(|(_, ty)| match &ty.inner {
                naga::TypeInner::Struct { span, .. } if ty.name.as_deref() == Some(name) => {
                    Some(*span as usize)
                }
                _ => None,
            });
            assert_eq!(found, Some(4 * words), "{name}");
        }
    }
}

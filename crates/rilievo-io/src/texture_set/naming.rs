//! What a file name says about a map, by the habits of ambientCG, Poly Haven, 3DTextures and
//! Substance.
//!
//! | role | words |
//! |---|---|
//! | albedo | `Color`, `albedo`, `basecolor`, `Base_Color`, `diff`, `Diffuse`, `col` |
//! | normal | `Normal`, `NormalGL`, `NormalDX`, `nor_gl`, `nor_dx`, `nrm`, `norm` |
//! | roughness, glossiness | `Roughness`, `rough`, `rgh`; `gloss`, `glossiness`, `smoothness` |
//! | metalness | `Metalness`, `metallic`, `metal` |
//! | displacement | `Displacement`, `disp`, `height`, `heightmap`, `elevation`, `dem`, last `h`; after these `bump` |
//! | others | `AmbientOcclusion`, `ao`, `occ`; `arm`, `orm`; `opacity`, `alpha`, `mask`; `emission`; `specular` |
//!
//! A name is cut into words at everything that is no letter or digit and where a small letter
//! meets a capital; case does not matter. The *last* word that means something decides, since
//! names of materials come first: `metal_plate_diff_1k` is an albedo.

use rilievo::map::NormalConvention;

/// What a map of a texture set is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum MapRole {
    /// Diffuse colour, sRGB.
    Albedo,
    /// Heights.
    Displacement,
    /// Tangent-space normals.
    Normal,
    /// Spread of reflection, linear.
    Roughness,
    /// One minus roughness.
    Glossiness,
    /// Metal or not, linear.
    Metalness,
    /// Ambient occlusion, linear.
    Occlusion,
    /// Occlusion, roughness and metalness in red, green and blue.
    Packed,
    /// Opacity.
    Opacity,
    /// Emitted light.
    Emission,
    /// Specular colour or level.
    Specular,
}

impl MapRole {
    /// The name used in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Albedo => "albedo",
            Self::Displacement => "displacement",
            Self::Normal => "normal",
            Self::Roughness => "roughness",
            Self::Glossiness => "glossiness",
            Self::Metalness => "metalness",
            Self::Occlusion => "ambient occlusion",
            Self::Packed => "occlusion, roughness, metalness",
            Self::Opacity => "opacity",
            Self::Emission => "emission",
            Self::Specular => "specular",
        }
    }
}

/// What a name says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Meaning {
    pub role: MapRole,
    /// Of a normal map, if the name tells.
    pub convention: Option<NormalConvention>,
    /// Whether the word is a second choice for its role.
    pub vague: bool,
}

/// What the name `stem`, without its ending, says; none if no word of it is known.
pub(super) fn meaning(stem: &str) -> Option<Meaning> {
    let words = words(stem);
    let mut convention = None;
    for (k, word) in words.iter().enumerate().rev() {
        let role = match word.as_str() {
            "gl" | "ogl" | "opengl" => {
                convention = Some(NormalConvention::OpenGl);
                continue;
            }
            "dx" | "directx" | "direct" => {
                convention = Some(NormalConvention::DirectX);
                continue;
            }
            "normalgl" => {
                convention = Some(NormalConvention::OpenGl);
                MapRole::Normal
            }
            "normaldx" => {
                convention = Some(NormalConvention::DirectX);
                MapRole::Normal
            }
            // `DisplacementH`, `rock_h`.
            "h" if k > 0 && k + 1 == words.len() => MapRole::Displacement,
            word => match role(word) {
                Some(role) => role,
                None => continue,
            },
        };
        let convention = convention.filter(|_| role == MapRole::Normal);
        return Some(Meaning { role, convention, vague: word == "bump" });
    }
    None
}

fn role(word: &str) -> Option<MapRole> {
    Some(match word {
        "color" | "colour" | "albedo" | "basecolor" | "basecolour" | "diffuse" | "diff" | "col" => {
            MapRole::Albedo
        }
        "normal" | "normals" | "normalmap" | "nor" | "nrm" | "norm" => MapRole::Normal,
        "roughness" | "rough" | "rgh" => MapRole::Roughness,
        "glossiness" | "gloss" | "smoothness" => MapRole::Glossiness,
        "metalness" | "metallic" | "metal" => MapRole::Metalness,
        "displacement" | "disp" | "displace" | "height" | "heightmap" | "elevation" | "dem"
        | "bump" => MapRole::Displacement,
        "ambientocclusion" | "occlusion" | "ao" | "occ" => MapRole::Occlusion,
        "arm" | "orm" => MapRole::Packed,
        "opacity" | "alpha" | "mask" => MapRole::Opacity,
        "emission" | "emissive" => MapRole::Emission,
        "specular" | "spec" | "reflection" => MapRole::Specular,
        _ => return None,
    })
}

/// The words of a name, in small letters.
fn words(stem: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut before = ' ';
    for c in stem.chars() {
        let cut = !c.is_alphanumeric() || (before.is_lowercase() && c.is_uppercase());
        if cut && words.last().is_some_and(|word| !word.is_empty()) {
            words.push(String::new());
        }
        if c.is_alphanumeric()
            && let Some(word) = words.last_mut()
        {
            word.extend(c.to_lowercase());
        }
        before = c;
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_four_libraries_are_understood() {
        use MapRole::*;
        for (stem, want) in [
            ("Rock058_1K_Color", Albedo),
            ("Facade001_1K-JPG_Displacement", Displacement),
            ("Facade001_1K_Metalness", Metalness),
            ("RoofingTiles009_1K_AmbientOcclusion", Occlusion),
            ("metal_plate_diff_1k", Albedo),
            ("metal_plate_disp_4k", Displacement),
            ("metal_plate_rough_2k", Roughness),
            ("metal_plate_metal_2k", Metalness),
            ("rock_wall_arm_2k", Packed),
            ("Fabric_Padded_004_basecolor", Albedo),
            ("Fabric_Padded_004_height", Displacement),
            ("Fabric_Padded_004_ambientOcclusion", Occlusion),
            ("lambert1_Base_Color", Albedo),
            ("lambert1_BaseColor", Albedo),
            ("lambert1_Height", Displacement),
            ("lambert1_Metallic", Metalness),
            ("Canyon-Diffuse", Albedo),
            ("elevation_surface", Displacement),
            ("base_color", Albedo),
            ("normal_map", Normal),
            ("rock_h", Displacement),
        ] {
            assert_eq!(meaning(stem).map(|m| m.role), Some(want), "{stem}");
        }
        for stem in ["preview", "Rock058", "h", "", "___", "WAC_GLD100_E000N1800_004P"] {
            assert_eq!(meaning(stem), None, "{stem}");
        }
    }

    #[test]
    fn names_of_normal_maps_tell_where_green_points() {
        let of = |stem| meaning(stem).map(|m| (m.role, m.convention));
        let (gl, dx) = (Some(NormalConvention::OpenGl), Some(NormalConvention::DirectX));
        assert_eq!(of("Facade001_1K_NormalGL"), Some((MapRole::Normal, gl)));
        assert_eq!(of("Facade001_1K_NormalDX"), Some((MapRole::Normal, dx)));
        assert_eq!(of("rock_nor_gl_4k"), Some((MapRole::Normal, gl)));
        assert_eq!(of("x_Normal_DirectX"), Some((MapRole::Normal, dx)));
        assert_eq!(of("wood_normaldx"), Some((MapRole::Normal, dx)));
        assert_eq!(of("wood_normal"), Some((MapRole::Normal, None)));
        assert_eq!(of("gl_color"), Some((MapRole::Albedo, None)));
        assert!(meaning("rock_bump").is_some_and(|m| m.vague));
    }
}

//! Wavefront MTL: the materials of OBJ files.
//!
//! | line | read as |
//! |---|---|
//! | `newmtl name` | the next material |
//! | `Kd`, `Ks`, `Ke` `r g b` | colour, mirror reflectance, emission |
//! | `Ns n` | roughness, where `Pr` does not say it: `(2 / (n + 2))^(1/4)`, the GGX lobe as wide as the Phong lobe \[Walter2007\] |
//! | `illum n` | below 3 there is no mirror reflectance, whatever `Ks` says: it is a highlight then |
//! | `Pr x`, `Pm x` | roughness, metalness |
//! | `Pc x`, `Pcr x`, `Ps x` | coat, its roughness; sheen |
//! | `d x`, `Tr x` | opacity, or 1 less it |
//! | `Ni x` | index of refraction |
//! | `illum 4`, `6`, `7`, `9` | glass |
//! | `map_Kd`, `map_Ke`, `map_Pr`, `map_Pm`, `map_d` | images of colour, emission, roughness, metalness, opacity |
//! | `norm` | normal map, green up |
//! | `map_Bump`, `bump` | heights that only bend normals; `-bm` is their strength |
//! | `disp`, `map_disp` | displacement: `base + gain * H` along the normal, by `-mm base gain` |
//!
//! Images take `-s u v` (repetitions), `-o u v` (shift), looked up at `uv * s + o`, and `-clamp on`. Other options
//! are known by their number of words and skipped. The name is what is left of the line, spaces
//! included. `spectral` and `xyz` colours and other lines are ignored.

use std::ops::Range;
use std::path::{Path, PathBuf};

use glam::DVec3;
use rilievo::map::{NormalConvention, Wrap};

use super::model::{ImageSource, ImageUse, ModelDisplacement, ModelMaterial};
use super::words::Words;
use crate::error::{Place, Result};
use crate::limits::Limits;

/// Reads the materials of a library; `name` is what errors call it and where images are looked for.
///
/// # Errors
/// A line that is wrong, more materials than the limits allow.
pub(super) fn read(bytes: &[u8], name: &Path, limits: &Limits) -> Result<Vec<ModelMaterial>> {
    let text = String::from_utf8_lossy(bytes);
    let mut reader = Reader { words: Words { path: name, text: &text }, all: Vec::new() };
    for line in reader.words.lines() {
        reader.line(line)?;
        let factors = [reader.all.len(), size_of::<Draft>()].map(|n| n as u64);
        limits.check(name, Place::File, "the materials", &factors)?;
    }
    Ok(reader.all.into_iter().map(Draft::finish).collect())
}

/// A material whose lines are still coming.
#[derive(Default)]
struct Draft {
    material: ModelMaterial,
    specular: DVec3,
    shininess: Option<f64>,
    roughness: Option<f64>,
    illumination: Option<f64>,
}

impl Draft {
    fn finish(self) -> ModelMaterial {
        let shiny = self.shininess.map(|n| (2.0 / (n.max(0.0) + 2.0)).powf(0.25));
        let mirrors = self.illumination.is_some_and(|n| n >= 3.0);
        // Glass by the illumination models of the format: what is left of `d` is not see-through too.
        let glass = self.illumination.is_some_and(|n| matches!(n as u32, 4 | 6 | 7 | 9));
        let emitted = match self.material.emission_map {
            Some(_) if self.material.emitted == DVec3::ZERO => DVec3::ONE,
            _ => self.material.emitted,
        };
        ModelMaterial {
            transmission: if glass { 1.0 } else { 0.0 },
            opacity: if glass { 1.0 } else { self.material.opacity },
            emitted,
            roughness: self.roughness.or(shiny).unwrap_or(1.0).clamp(0.0, 1.0),
            reflective: if mirrors && !glass { self.specular } else { DVec3::ZERO },
            ..self.material
        }
    }
}

struct Reader<'a> {
    words: Words<'a>,
    all: Vec<Draft>,
}

/// An image with its options.
struct Image {
    image: ImageUse,
    base: f64,
    gain: f64,
    bump: f64,
}

impl<'a> Reader<'a> {
    fn line(&mut self, line: Range<usize>) -> Result<()> {
        let all = self.words;
        let mut words = all.words(line.clone());
        let Some((key, at)) = words.next() else { return Ok(()) };
        if key == "newmtl" {
            let name = words.next().map_or("", |(word, _)| word).to_owned();
            let material = ModelMaterial { name, ..ModelMaterial::default() };
            self.all.push(Draft { material, ..Draft::default() });
            return Ok(());
        }
        // Lines before the first material belong to none.
        let Some(draft) = self.all.last_mut() else { return Ok(()) };
        let material = &mut draft.material;
        let mut number = |allowed| all.numbers::<1>(&mut words, at.clone(), allowed);
        match key.to_ascii_lowercase().as_str() {
            "kd" => material.colour = colour(all, line, at)?.unwrap_or(material.colour),
            "ks" => draft.specular = colour(all, line, at)?.unwrap_or(draft.specular),
            "ke" => material.emitted = colour(all, line, at)?.unwrap_or(material.emitted),
            "ns" => draft.shininess = Some(number("a number of at least 0")?[0]),
            "illum" => draft.illumination = Some(number("a number from 0 to 10")?[0]),
            "pc" => material.coat = number("a number from 0 to 1")?[0].clamp(0.0, 1.0),
            "pcr" => material.coat_roughness = number("a number from 0 to 1")?[0].clamp(0.0, 1.0),
            "ps" => {
                material.sheen = DVec3::splat(number("a number from 0 to 1")?[0].clamp(0.0, 1.0));
            }
            "d" if all.text[line.clone()].contains("-halo") => {}
            "d" => material.opacity = number("a number from 0 to 1")?[0].clamp(0.0, 1.0),
            "tr" => material.opacity = 1.0 - number("a number from 0 to 1")?[0].clamp(0.0, 1.0),
            "ni" => material.ior = number("a number from 0.1 to 10")?[0].clamp(0.1, 10.0),
            "map_ke" => material.emission_map = Some(image(all, line, at)?.image),
            "map_d" => material.opacity_map = Some(image(all, line, at)?.image),
            "pr" => draft.roughness = Some(number("a number from 0 to 1")?[0]),
            "pm" => material.metalness = number("a number from 0 to 1")?[0].clamp(0.0, 1.0),
            "map_kd" => material.colour_map = Some(image(all, line, at)?.image),
            "map_pr" => material.roughness_map = Some(image(all, line, at)?.image),
            "map_pm" => material.metalness_map = Some(image(all, line, at)?.image),
            "norm" => {
                let image = image(all, line, at)?.image;
                material.normal_map = Some((image, NormalConvention::OpenGl));
            }
            "bump" | "map_bump" => {
                let Image { image, bump, .. } = image(all, line, at)?;
                material.bump_map = Some((image, bump));
            }
            "disp" | "map_disp" => {
                let Image { image, base, gain, .. } = image(all, line, at.clone())?;
                if gain == 0.0 {
                    let found = "a gain of 0".to_owned();
                    return Err(all.fault(at, "-mm", found, "-mm base gain, with a gain"));
                }
                // base + gain H = gain (H - zero)
                let (scale, zero) = (gain, 0.0 - base / gain);
                material.displacement = Some(ModelDisplacement { image, scale, zero });
            }
            _ => {}
        }
        Ok(())
    }
}

/// `r g b`, or `r` for all three; none for a colour of another kind.
fn colour(all: Words<'_>, line: Range<usize>, at: Range<usize>) -> Result<Option<DVec3>> {
    let mut words = all.words(line).skip(1).peekable();
    if words.peek().is_some_and(|(word, _)| matches!(*word, "spectral" | "xyz")) {
        return Ok(None);
    }
    let allowed = "three numbers of at least 0: r g b";
    let [red] = all.numbers(&mut words, at.clone(), allowed)?;
    let rgb = match words.peek() {
        None => [red; 3],
        Some(_) => {
            let [green, blue] = all.numbers(&mut words, at.clone(), allowed)?;
            [red, green, blue]
        }
    };
    match rgb.iter().all(|c| *c >= 0.0) {
        true => Ok(Some(DVec3::from_array(rgb))),
        false => Err(all.fault(at, "colour", format!("{rgb:?}"), allowed)),
    }
}

/// An image: options, then a name.
fn image(all: Words<'_>, line: Range<usize>, at: Range<usize>) -> Result<Image> {
    let mut found = Image {
        image: ImageUse::new(ImageSource::File(PathBuf::new())),
        base: 0.0,
        gain: 1.0,
        bump: 1.0,
    };
    let mut words = all.words(line.clone()).skip(1).peekable();
    let mut start = at.end;
    while let Some((option, place)) = words.next_if(|(word, _)| word.starts_with('-')) {
        start = place.end;
        let mut take = |most: usize| {
            let mut numbers = Vec::new();
            while numbers.len() < most
                && let Some((word, at)) = words.next_if(|(word, _)| word.parse::<f64>().is_ok())
            {
                start = at.end;
                numbers.push(all.number((word, at), "a finite number")?);
            }
            Ok(numbers)
        };
        match option {
            "-s" | "-o" | "-t" => {
                let numbers = take(3)?;
                let slot = match option {
                    "-s" => &mut found.image.tile,
                    "-o" => &mut found.image.shift,
                    _ => continue,
                };
                if let Some(u) = numbers.first() {
                    slot.x = *u;
                    slot.y = numbers.get(1).copied().unwrap_or(slot.y);
                }
            }
            "-mm" => {
                let numbers = take(2)?;
                let [base, gain] = *numbers.as_slice() else {
                    let found = format!("{} numbers", numbers.len());
                    return Err(all.fault(place, "-mm", found, "two numbers: base gain"));
                };
                (found.base, found.gain) = (base, gain);
            }
            "-bm" => found.bump = take(1)?.first().copied().unwrap_or(1.0),
            "-boost" | "-texres" => drop(take(1)?),
            "-clamp" => {
                if let Some((word, at)) = words.next() {
                    start = at.end;
                    if word.eq_ignore_ascii_case("on") {
                        found.image.wrap = [Wrap::Clamp; 2];
                    }
                }
            }
            "-blendu" | "-blendv" | "-imfchan" | "-cc" | "-type" | "-colorspace" => {
                start = words.next().map_or(start, |(_, at)| at.end);
            }
            _ => {
                let allowed = "-s -o -t -mm -bm -boost -texres -clamp -blendu -blendv -imfchan -cc \
                               -type";
                return Err(all.fault(place, "option of an image", format!("{option:?}"), allowed));
            }
        }
    }
    let end = all.text[start..line.end].find('#').map_or(line.end, |n| start + n);
    let name = all.text[start..end].trim();
    if name.is_empty() {
        return Err(all.fault(at, "image", "no name".to_owned(), "options, then a file"));
    }
    // Names were often written under Windows.
    let name = name.replace('\\', "/");
    let path = all.path.parent().unwrap_or(Path::new("")).join(name);
    found.image.source = ImageSource::File(path);
    Ok(found)
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;

    fn one(text: &str) -> ModelMaterial {
        let text = format!("# a\nnewmtl stone\n{text}\n");
        let all = read(text.as_bytes(), Path::new("dir/a.mtl"), &Limits::default());
        let [material] = <[_; 1]>::try_from(all.unwrap()).unwrap();
        material
    }

    fn file(image: &ImageUse) -> &str {
        match &image.source {
            ImageSource::File(path) => path.to_str().unwrap(),
            ImageSource::Embedded { .. } => panic!("embedded"),
        }
    }

    #[test]
    fn numbers_arrive() {
        let m = one("Kd 0.1 0.2 0.3\nKe 1\nPm 0.5\nPr 0.25\nKs 0.9 0.9 0.9\nNs 10\nillum 2");
        assert_eq!((m.name.as_str(), m.colour), ("stone", DVec3::new(0.1, 0.2, 0.3)));
        assert_eq!((m.emitted, m.metalness, m.roughness), (DVec3::ONE, 0.5, 0.25));
        assert_eq!(m.reflective, DVec3::ZERO);
        let m = one("Ks 0.5 0.5 0.5\nNs 30\nillum 3");
        assert_eq!((m.reflective, m.roughness), (DVec3::splat(0.5), 0.5));
        assert_eq!(one("Kd spectral a.rfl 1").colour, DVec3::ONE);
    }

    #[test]
    fn displacement_and_its_options_arrive() {
        let m = one("disp -mm -0.05 0.1 -s 2 3 1 -o 0.5 -clamp on my rock 1.png # end");
        let d = m.displacement.unwrap();
        assert_eq!((d.scale, d.zero), (0.1, 0.5));
        assert_eq!((d.image.tile, d.image.shift), (DVec2::new(2.0, 3.0), DVec2::new(0.5, 0.0)));
        assert_eq!(file(&d.image), "dir/my rock 1.png");
        let m = one("map_disp a.png");
        assert_eq!(m.displacement.map(|d| (d.scale, d.zero)), Some((1.0, 0.0)));
    }

    #[test]
    fn images_arrive() {
        let m = one("map_Kd -s 4 maps\\a.png\nmap_Bump -bm 0.3 b.png\nnorm n.png\nmap_Pr r.png");
        assert_eq!(m.colour_map.as_ref().map(file), Some("dir/maps/a.png"));
        assert_eq!(m.colour_map.map(|i| i.tile), Some(DVec2::new(4.0, 1.0)));
        assert_eq!(m.bump_map.map(|(_, strength)| strength), Some(0.3));
        assert!(m.normal_map.is_some() && m.roughness_map.is_some());
    }

    #[test]
    fn errors_name_their_line_and_lines_without_a_material_are_skipped() {
        let library = |text: &str| read(text.as_bytes(), Path::new("a.mtl"), &Limits::default());
        assert!(library("Kd 1 0 0\nmap_Kd\n").unwrap().is_empty());
        for (text, want) in [
            ("Kd 1 0", "a.mtl:2:1: numbers: only 1"),
            ("Kd 1 0 -1", "colour: [1.0, 0.0, -1.0]"),
            ("map_Kd -s 1 1", "image: no name"),
            ("disp -mm 1 a.png", "-mm: 1 numbers; allowed: two numbers: base gain"),
            ("disp -mm 1 0 a.png", "a gain of 0"),
            ("map_Kd -what a.png", "a.mtl:2:8: option of an image: \"-what\""),
            ("Ns x", "number: \"x\""),
        ] {
            let error = library(&format!("newmtl a\n{text}")).unwrap_err().to_string();
            assert!(error.contains(want), "{text}: {error}");
        }
        assert!(
            read(&b"newmtl a\n".repeat(2000), Path::new("a"), &Limits { max_bytes: 9999 }).is_err()
        );
    }
}

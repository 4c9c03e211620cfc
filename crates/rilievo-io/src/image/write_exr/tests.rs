//! What is written is read back, by the `exr` crate too.

use super::super::Channel;
use super::*;
use crate::Limits;

fn sample(width: u32, height: u32) -> ChannelImage {
    let noise = |k: u32| (k.wrapping_mul(2_654_435_761) >> 8) as f32 / 65536.0 - 100.0;
    let channels = ["R", "G", "B", "P.X", "Z", "a name that is longer than thirty-one bytes"];
    let channels = (channels.iter().enumerate())
        .map(|(c, name)| {
            let mut samples: Vec<_> = (0..width * height).map(|k| noise(k + c as u32)).collect();
            samples[0] = [f32::NAN, f32::INFINITY, -0.0, 1e-45, f32::MAX, 1.0][c];
            Channel { name: (*name).to_owned(), samples }
        })
        .collect();
    let matrix = [[1.0, 2.0, 3.0, 4.0], [0.5; 4], [-1.0; 4], [0.0, 0.0, 0.0, 1.0]];
    let attributes = vec![
        ("rilievo/seed".to_owned(), Attribute::Text("12345678901234567890".to_owned())),
        ("samplesPerPixel".to_owned(), Attribute::Integer(16)),
        ("renderTimeSeconds".to_owned(), Attribute::Number(1.5)),
        ("software".to_owned(), Attribute::Text("rilievo \u{e9}\u{4e2d}".to_owned())),
        ("worldToCamera".to_owned(), Attribute::Matrix(matrix)),
    ];
    ChannelImage { width, height, channels, attributes }
}

fn bits(values: &[f32]) -> Vec<u32> {
    values.iter().map(|v| v.to_bits()).collect()
}

#[test]
fn pictures_come_back_bit_for_bit() {
    let dir = tempfile::tempdir().unwrap();
    for (width, height) in [(1, 1), (3, 16), (17, 33), (64, 50)] {
        for blocks in [Blocks::Lines, Blocks::Tiles(16), Blocks::Tiles(40)] {
            let (path, image) = (dir.path().join("a.exr"), sample(width, height));
            let write = || Picture { blocks, ..image.picture() }.write_exr(&path).unwrap();
            write();
            let back = ChannelImage::read(&path, &Limits::default()).unwrap();
            assert_eq!((back.width, back.height), (width, height));
            assert_eq!(back.channels.len(), image.channels.len());
            for channel in &image.channels {
                let other = back.channel(&channel.name).unwrap();
                assert_eq!(bits(&other.samples), bits(&channel.samples), "{}", channel.name);
            }
            assert_eq!(back.attribute("samplesPerPixel"), Some(&Attribute::Integer(16)));
            assert_eq!(back.attribute("renderTimeSeconds"), Some(&Attribute::Number(1.5)));
            for name in ["rilievo/seed", "worldToCamera"] {
                assert_eq!(back.attribute(name), image.attribute(name), "{name}");
            }
            let software = Attribute::Text("rilievo \u{e9}?".to_owned());
            assert_eq!(back.attribute("software"), Some(&software));
            let first = std::fs::read(&path).unwrap();
            write();
            assert_eq!(std::fs::read(&path).unwrap(), first, "same picture, same bytes");
        }
    }
}

#[test]
fn halves_come_back_as_the_nearest() {
    let dir = tempfile::tempdir().unwrap();
    let (path, image) = (dir.path().join("a.exr"), sample(17, 33));
    for blocks in [Blocks::Lines, Blocks::Tiles(8)] {
        let mut picture = Picture { blocks, ..image.picture() };
        for channel in &mut picture.channels[..3] {
            channel.stored = Stored::Half;
        }
        picture.write_exr(&path).unwrap();
        let back = ChannelImage::read(&path, &Limits::default()).unwrap();
        for (c, channel) in image.channels.iter().enumerate() {
            let samples = &back.channel(&channel.name).unwrap().samples;
            if c < 3 {
                let pairs = samples.iter().zip(&channel.samples).skip(1);
                // Eleven bits.
                assert!(pairs.clone().all(|(a, b)| (a - b).abs() <= b.abs() / 2048.0));
            } else {
                assert_eq!(bits(samples), bits(&channel.samples));
            }
        }
    }
}

#[test]
fn a_crop_is_the_data_window() {
    let dir = tempfile::tempdir().unwrap();
    let (path, image) = (dir.path().join("a.exr"), sample(20, 24));
    for blocks in [Blocks::Lines, Blocks::Tiles(16)] {
        let crop = Some(Crop { corner: [7, 5], full: [100, 50] });
        Picture { blocks, crop, ..image.picture() }.write_exr(&path).unwrap();
        let meta = exr::meta::MetaData::read_from_file(&path, true).unwrap();
        let header = &meta.headers[0];
        let display = header.shared_attributes.display_window;
        assert_eq!((display.position.0, display.size.0, display.size.1), (0, 100, 50));
        let corner = header.own_attributes.layer_position;
        assert_eq!((corner.0, corner.1), (7, 5));
        assert_eq!((header.layer_size.0, header.layer_size.1), (20, 24));
        let back = ChannelImage::read(&path, &Limits::default()).unwrap();
        let samples = |image: &ChannelImage| bits(&image.channel("Z").unwrap().samples);
        assert_eq!(samples(&back), samples(&image));
    }
}

#[test]
fn pictures_that_no_file_can_hold_are_refused() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.exr");
    let values = [0.0; 12];
    let write = |names: &[&str], picture: Picture<'_>| {
        let mut picture = Picture { channels: Vec::new(), ..picture };
        for (c, name) in names.iter().enumerate() {
            picture.push_interleaved(&[name], &values[c..], Stored::Float);
        }
        picture.write_exr(&path).map_err(|e| e.to_string())
    };
    let sized = |width, height| Picture { width, height, ..Picture::default() };
    let put = |names: &[&str], size: [u32; 2]| write(names, sized(size[0], size[1]));
    assert!(put(&["R", "G", "B"], [2, 2]).is_ok());
    assert!(put(&["R", "G", "B"], [4, 3]).unwrap_err().contains("one for each pixel"));
    assert!(put(&["R", "R"], [2, 2]).unwrap_err().contains("R twice"));
    assert!(put(&[""], [2, 2]).unwrap_err().contains("255 bytes"));
    assert!(put(&["R"], [0, 2]).unwrap_err().contains("0 x 2"));
    assert!(put(&[], [2, 2]).unwrap_err().contains("at least one"));
    let crop = |corner| Some(Crop { corner, full: [4, 4] });
    let cropped = |corner| write(&["R"], Picture { crop: crop(corner), ..sized(2, 2) });
    assert!(cropped([2, 2]).is_ok());
    assert!(cropped([3, 2]).unwrap_err().contains("larger picture"));
    assert!(cropped([u32::MAX, 0]).unwrap_err().contains("larger picture"));
    let tiled = |side| write(&["R"], Picture { blocks: Blocks::Tiles(side), ..sized(2, 2) });
    assert!(tiled(64).is_ok() && tiled(0).is_err() && tiled(65_537).is_err());
    assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 1);
}

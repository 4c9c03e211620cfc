//! `rilievo render --tev`.

use std::io::Read;
use std::net::TcpListener;

use rilievo_io::Limits;
use rilievo_io::image::ChannelImage;

use crate::support::Folder;

/// What a viewer holds after the bytes of a connection: its name for the image, and the pixels.
fn shown(bytes: &[u8]) -> (String, Vec<f32>) {
    let integer = |at: &[u8]| u32::from_le_bytes(at[..4].try_into().unwrap()) as usize;
    let (mut rest, mut name) = (bytes, String::new());
    let (mut width, mut pixels) = (0, Vec::new());
    while !rest.is_empty() {
        let (packet, after) = rest.split_at(integer(rest));
        let (operation, body) = (packet[4], &packet[6..]);
        let end = body.iter().position(|&b| b == 0).unwrap();
        let numbers = &body[end + 1..];
        if operation == 4 {
            name = String::from_utf8(body[..end].to_vec()).unwrap();
            width = integer(numbers);
            pixels = vec![0.0; 3 * width * integer(&numbers[4..])];
        } else {
            assert_eq!(operation, 6);
            // Three channels and their names, a rectangle, offsets and strides of 8 bytes each.
            let [x, y, w, h] = [10, 14, 18, 22].map(|at| integer(&numbers[at..]));
            let values = numbers[26 + 48..].chunks_exact(4);
            assert_eq!(values.len(), 3 * w * h);
            for (k, value) in values.enumerate() {
                let (pixel, channel) = (k / 3, k % 3);
                let at = (y + pixel / w) * width + x + pixel % w;
                pixels[3 * at + channel] = f32::from_le_bytes(value.try_into().unwrap());
            }
        }
        rest = after;
    }
    (name, pixels)
}

#[test]
fn a_viewer_ends_with_the_picture_that_is_written() {
    let folder = Folder::new().with_scene();
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    let viewer = std::thread::spawn(move || {
        let mut bytes = Vec::new();
        listener.accept().unwrap().0.read_to_end(&mut bytes).unwrap();
        bytes
    });
    folder.run(&format!("render scene.toml -o a.exr --tev={address}")).expect(0);
    let (name, pixels) = shown(&viewer.join().unwrap());
    assert_eq!(name, "a.exr");
    let picture = ChannelImage::read(&folder.path("a.exr"), &Limits::default()).unwrap();
    for (c, channel) in ["R", "G", "B"].iter().enumerate() {
        let samples = &picture.channel(channel).unwrap().samples;
        assert!(samples.iter().zip(pixels[c..].iter().step_by(3)).all(|(a, b)| a == b));
    }
    folder.run("render scene.toml -o b.exr").expect(0);
    assert_eq!(folder.bytes("a.exr"), folder.bytes("b.exr"));
}

#[test]
fn without_a_viewer_rendering_goes_on() {
    let folder = Folder::new().with_scene();
    let free = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let run = folder.run(&format!("render scene.toml -o a.exr --tev={free}")).expect(0);
    assert!(run.stderr.contains(&format!("no viewer at {free}")), "{}", run.stderr);
    assert!(folder.path("a.exr").exists());
}

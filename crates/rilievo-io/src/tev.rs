//! [`TevImage`]: a picture shown by the viewer tev while it is rendered.
//!
//! tev listens on TCP port 14158. A packet is its own length in bytes (u32), an operation (u8) and
//! what that needs; numbers are little-endian, text ends in a zero byte. Two operations are used:
//!
//! | operation | what follows |
//! |---|---|
//! | 4, create an image | take focus (u8), name, width, height, channels (i32 each), their names |
//! | 6, update a part | take focus (u8), name, channels (i32), their names, x, y, width, height (i32 each), for each channel its first value and for each the distance of values (i64 each), values (f32) |
//!
//! An update holds one square of 64 pixels a side, and only squares that have changed are sent.

use std::io::{self, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::time::Duration;

/// Where tev listens by default.
pub const TEV_ADDRESS: &str = "127.0.0.1:14158";

/// Pixels along a side of what one packet updates.
const SQUARE: u32 = 64;

/// Longest wait for a connection, and for a viewer that does not read.
const PATIENCE: Duration = Duration::from_secs(2);

const CREATE: u8 = 4;
const UPDATE: u8 = 6;

/// An image open in a viewer.
#[derive(Debug)]
pub struct TevImage {
    stream: TcpStream,
    name: String,
    size: [u32; 2],
    /// What the viewer has been told.
    shown: Vec<[f32; 3]>,
}

impl TevImage {
    /// Opens an image of linear RGB, black so far, in the viewer at `address` (host and port).
    ///
    /// # Errors
    /// [`io::Error`] if nobody listens there.
    pub fn open(address: &str, name: &str, size: [u32; 2]) -> io::Result<Self> {
        let mut last = io::Error::new(io::ErrorKind::NotFound, "no such host");
        for address in address.to_socket_addrs()? {
            match TcpStream::connect_timeout(&address, PATIENCE) {
                Ok(stream) => return Self::create(stream, name, size),
                Err(error) => last = error,
            }
        }
        Err(last)
    }

    fn create(stream: TcpStream, name: &str, size: [u32; 2]) -> io::Result<Self> {
        stream.set_write_timeout(Some(PATIENCE))?;
        let name = name.replace('\0', " ");
        let shown = vec![[0.0; 3]; size[0] as usize * size[1] as usize];
        let mut image = Self { stream, name, size, shown };
        let mut packet = Packet::new(CREATE);
        packet.byte(1);
        packet.text(&image.name);
        packet.integers(&[size[0], size[1], 3]);
        ["R", "G", "B"].iter().for_each(|channel| packet.text(channel));
        packet.send(&mut image.stream)?;
        Ok(image)
    }

    /// Shows the squares of `pixels`, row by row from the top left, that differ from what is shown.
    ///
    /// # Errors
    /// [`io::Error`] if the viewer has gone; [`io::ErrorKind::InvalidInput`] if the number of pixels is
    /// not that of the image.
    pub fn update(&mut self, pixels: &[[f32; 3]]) -> io::Result<()> {
        if pixels.len() != self.shown.len() {
            return Err(io::ErrorKind::InvalidInput.into());
        }
        for y in (0..self.size[1]).step_by(SQUARE as usize) {
            for x in (0..self.size[0]).step_by(SQUARE as usize) {
                self.update_square(pixels, [x, y])?;
            }
        }
        Ok(())
    }

    fn update_square(&mut self, pixels: &[[f32; 3]], corner: [u32; 2]) -> io::Result<()> {
        let [width, height] = [0, 1].map(|axis| SQUARE.min(self.size[axis] - corner[axis]));
        let rows = (corner[1]..corner[1] + height).map(|y| {
            let first = y as usize * self.size[0] as usize + corner[0] as usize;
            first..first + width as usize
        });
        let bits = |rgb: &[f32; 3]| rgb.map(f32::to_bits);
        let same = |row: std::ops::Range<usize>| {
            let pairs = pixels[row.clone()].iter().zip(&self.shown[row]);
            pairs.into_iter().all(|(new, old)| bits(new) == bits(old))
        };
        if rows.clone().all(same) {
            return Ok(());
        }
        let mut packet = Packet::new(UPDATE);
        packet.byte(0);
        packet.text(&self.name);
        packet.integers(&[3]);
        ["R", "G", "B"].iter().for_each(|channel| packet.text(channel));
        packet.integers(&[corner[0], corner[1], width, height]);
        packet.longs(&[0, 1, 2]);
        packet.longs(&[3, 3, 3]);
        for row in rows {
            packet.floats(pixels[row.clone()].as_flattened());
            self.shown[row.clone()].copy_from_slice(&pixels[row]);
        }
        packet.send(&mut self.stream)
    }
}

/// A packet being written.
struct Packet(Vec<u8>);

impl Packet {
    fn new(operation: u8) -> Self {
        Self(vec![0, 0, 0, 0, operation])
    }

    fn byte(&mut self, value: u8) {
        self.0.push(value);
    }

    fn text(&mut self, text: &str) {
        self.0.extend_from_slice(text.as_bytes());
        self.0.push(0);
    }

    fn integers(&mut self, values: &[u32]) {
        values.iter().for_each(|value| self.0.extend_from_slice(&value.to_le_bytes()));
    }

    fn longs(&mut self, values: &[u64]) {
        values.iter().for_each(|value| self.0.extend_from_slice(&value.to_le_bytes()));
    }

    fn floats(&mut self, values: &[f32]) {
        values.iter().for_each(|value| self.0.extend_from_slice(&value.to_le_bytes()));
    }

    fn send(mut self, stream: &mut TcpStream) -> io::Result<()> {
        let length = u32::try_from(self.0.len()).map_err(|_| io::ErrorKind::InvalidInput)?;
        self.0[..4].copy_from_slice(&length.to_le_bytes());
        stream.write_all(&self.0)
    }
}

#[cfg(test)]
mod tests {
    use std::io::Read;
    use std::net::TcpListener;

    use super::*;

    /// What a viewer of one image would hold, from the bytes of a connection.
    #[derive(Default)]
    struct Viewer {
        name: String,
        size: [u32; 2],
        pixels: Vec<f32>,
        updates: Vec<[u32; 4]>,
    }

    /// Reads the front of a packet.
    struct Reader<'a>(&'a [u8]);

    impl Reader<'_> {
        fn bytes<const N: usize>(&mut self) -> [u8; N] {
            let (head, rest) = self.0.split_first_chunk().unwrap();
            self.0 = rest;
            *head
        }

        fn integer(&mut self) -> u32 {
            u32::from_le_bytes(self.bytes())
        }

        fn long(&mut self) -> usize {
            u64::from_le_bytes(self.bytes()) as usize
        }

        fn text(&mut self) -> String {
            let end = self.0.iter().position(|&b| b == 0).unwrap();
            let text = String::from_utf8(self.0[..end].to_vec()).unwrap();
            self.0 = &self.0[end + 1..];
            text
        }
    }

    impl Viewer {
        fn packet(&mut self, bytes: &[u8]) {
            let mut reader = Reader(bytes);
            let [operation, _focus] = reader.bytes();
            let name = reader.text();
            if operation == CREATE {
                (self.name, self.size) = (name, [reader.integer(), reader.integer()]);
                let channels: Vec<_> = (0..reader.integer()).map(|_| reader.text()).collect();
                assert_eq!(channels, ["R", "G", "B"]);
                self.pixels = vec![0.0; 3 * self.size[0] as usize * self.size[1] as usize];
                return;
            }
            assert_eq!((operation, &name), (UPDATE, &self.name));
            let channels: Vec<_> = (0..reader.integer()).map(|_| reader.text()).collect();
            let [x, y, width, height] = [(); 4].map(|()| reader.integer());
            assert!(x + width <= self.size[0] && y + height <= self.size[1]);
            let offsets: Vec<_> = channels.iter().map(|_| reader.long()).collect();
            let strides: Vec<_> = channels.iter().map(|_| reader.long()).collect();
            let mut values = Vec::new();
            while !reader.0.is_empty() {
                values.push(f32::from_le_bytes(reader.bytes()));
            }
            assert_eq!(values.len(), 3 * width as usize * height as usize);
            for k in 0..(width * height) as usize {
                let (dx, dy) = (k % width as usize, k / width as usize);
                let at = (y as usize + dy) * self.size[0] as usize + x as usize + dx;
                for c in 0..3 {
                    self.pixels[3 * at + c] = values[offsets[c] + k * strides[c]];
                }
            }
            self.updates.push([x, y, width, height]);
        }

        /// Reads packets until the connection ends.
        fn listen(listener: &TcpListener) -> Self {
            let (mut stream, _) = listener.accept().unwrap();
            let (mut viewer, mut bytes) = (Self::default(), Vec::new());
            stream.read_to_end(&mut bytes).unwrap();
            let mut rest = &bytes[..];
            while let Some((head, _)) = rest.split_first_chunk::<4>() {
                let (packet, after) = rest.split_at(u32::from_le_bytes(*head) as usize);
                viewer.packet(&packet[4..]);
                rest = after;
            }
            viewer
        }
    }

    #[test]
    fn a_viewer_ends_with_the_picture_and_is_sent_what_changed() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap().to_string();
        let viewer = std::thread::spawn(move || Viewer::listen(&listener));
        let size = [100, 70];
        let mut pixels = vec![[0.0; 3]; 7000];
        let mut image = TevImage::open(&address, "a picture", size).unwrap();
        image.update(&pixels).unwrap();
        pixels[65 * 100 + 3] = [1.0, 2.0, f32::INFINITY];
        image.update(&pixels).unwrap();
        pixels[5 * 100 + 99] = [0.25, -1.0, 3.0];
        image.update(&pixels).unwrap();
        image.update(&pixels).unwrap();
        assert!(image.update(&pixels[1..]).is_err());
        drop(image);
        let viewer = viewer.join().unwrap();
        assert_eq!((viewer.name.as_str(), viewer.size), ("a picture", size));
        assert_eq!(viewer.pixels, pixels.as_flattened());
        assert_eq!(viewer.updates, [[0, 64, 64, 6], [64, 0, 36, 64]]);
    }

    #[test]
    fn nobody_there_is_an_error() {
        let free = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
        assert!(TevImage::open(&free.to_string(), "a", [1, 1]).is_err());
        assert!(TevImage::open("nowhere", "a", [1, 1]).is_err());
    }
}

//! The window as a person meets it: opened, a slider dragged with the mouse, looked at.
//!
//! It needs the X server `Xvfb` and `xdotool`, and a graphics adapter, in software if there is no other. Where
//! one is missing that is told on stderr, and the test is skipped.

#![cfg(target_os = "linux")]

use std::collections::HashMap;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

/// A hill on a plate, seen from the side: bright in front of black.
const SCENE: &str = "[camera]\nposition = [0.5, -1.6, 0.3]\nlook_at = [0.5, 0.5, 0.2]\nfov = 40\nresolution = [64, 48]\n\
     [render]\nsamples = 4\nambient = [1, 1, 1]\n\
     [maps.hill]\nprocedural = \"gaussian\"\nsize = [64, 64]\n\
     [materials.chalk]\ndiffuse = [0.9, 0.9, 0.9]\n\
     [[shapes]]\ntype = \"quad\"\ncorners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]\n\
     material = \"chalk\"\ndisplacement = { map = \"hill\", scale = 0.1 }\n";

/// How long anything may take on a busy machine.
const PATIENCE: Duration = Duration::from_secs(180);
/// How long nothing is told before all is done.
const SILENCE: Duration = Duration::from_secs(3);

/// A program that ends with the test.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        // One that has ended already is no news.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn skip(why: &str) {
    let _ = writeln!(std::io::stderr(), "skipped: {why}");
}

fn is_there(program: &str) -> bool {
    let folders = std::env::var_os("PATH").unwrap_or_default();
    std::env::split_paths(&folders).any(|folder| folder.join(program).is_file())
}

/// An X server on a free display, whose screen lies in a file of `folder`.
fn x_server(folder: &Path) -> Option<(Running, String)> {
    let child = Command::new("Xvfb")
        .args(["-displayfd", "1", "-screen", "0", "1024x768x24", "-nolisten", "tcp", "-fbdir"])
        .arg(folder)
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .ok()?;
    let mut server = Running(child);
    let mut number = String::new();
    BufReader::new(server.0.stdout.take()?).read_line(&mut number).ok()?;
    let number = number.trim();
    (!number.is_empty()).then(|| (server, format!(":{number}")))
}

/// What the journal of the viewer tells, line by line.
struct Journal {
    lines: Receiver<String>,
    /// Where widgets are: left, top, width, height.
    widgets: HashMap<String, [i32; 4]>,
}

/// The number after `"key":`.
fn number(line: &str, key: &str) -> Option<f64> {
    let rest = line.split_once(&format!("\"{key}\":"))?.1;
    let end = rest.find([',', '}']).unwrap_or(rest.len());
    rest[..end].parse().ok()
}

impl Journal {
    /// Remembers where a widget is.
    fn note(&mut self, line: &str) {
        if !line.contains("\"event\":\"widget\"") {
            return;
        }
        let name = line.split("\"name\":\"").nth(1).and_then(|s| s.split('"').next());
        let place = ["x", "y", "width", "height"].map(|key| number(line, key));
        if let (Some(name), [Some(x), Some(y), Some(w), Some(h)]) = (name, place) {
            self.widgets.insert(name.to_owned(), [x, y, w, h].map(|n| n as i32));
        }
    }

    /// Reads until `wanted` finds what it looks for; none if the program ended before.
    fn until<T>(&mut self, mut wanted: impl FnMut(&str) -> Option<T>) -> Option<T> {
        let begin = Instant::now();
        loop {
            let left = PATIENCE.checked_sub(begin.elapsed()).expect("it takes too long");
            let line = match self.lines.recv_timeout(left) {
                Ok(line) => line,
                Err(RecvTimeoutError::Disconnected) => return None,
                Err(e) => panic!("{e}"),
            };
            self.note(&line);
            if let Some(found) = wanted(&line) {
                return Some(found);
            }
        }
    }

    /// Waits until the last picture is done and on the screen: nothing is told any more. `false` if the
    /// program ended.
    fn settled(&mut self) -> bool {
        let mut done = false;
        let begin = Instant::now();
        while begin.elapsed() < PATIENCE {
            match self.lines.recv_timeout(SILENCE) {
                Ok(line) => {
                    if line.contains("\"event\":\"pass\"") {
                        done = false;
                    }
                    done |= line.contains("\"event\":\"done\"");
                    self.note(&line);
                }
                Err(RecvTimeoutError::Timeout) if done => return true,
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return false,
            }
        }
        panic!("it takes too long");
    }
}

/// The pixels of a screen, as Xvfb keeps them in a file of the format XWD.
struct Screen {
    width: usize,
    pixels: Vec<[u8; 3]>,
}

impl Screen {
    fn read(folder: &Path) -> Self {
        let bytes = std::fs::read(folder.join("Xvfb_screen0")).unwrap();
        let word = |k: usize| u32::from_be_bytes(bytes[4 * k..4 * k + 4].try_into().unwrap());
        let [header, width, height] = [0, 4, 5].map(|k| word(k) as usize);
        let (line, colours) = (word(12) as usize, word(19) as usize);
        assert_eq!((word(7), word(11)), (0, 32), "little endian, 32 bits a pixel");
        let start = header + 12 * colours;
        let pixels = (0..height).flat_map(|y| {
            let row = &bytes[start + y * line..][..4 * width];
            row.chunks_exact(4).map(|p| [p[2], p[1], p[0]])
        });
        Self { width, pixels: pixels.collect() }
    }

    /// The pixels of a rectangle: left, top, width, height.
    fn part(&self, [x, y, width, height]: [i32; 4]) -> Vec<[u8; 3]> {
        let rows = y as usize..(y + height) as usize;
        rows.flat_map(|y| {
            self.pixels[y * self.width + x as usize..][..width as usize].iter().copied()
        })
        .collect()
    }
}

fn bright(pixels: &[[u8; 3]]) -> usize {
    pixels.iter().filter(|rgb| rgb.iter().all(|&c| c > 150)).count()
}

struct Hand {
    display: String,
    /// The top left corner of the window on the screen.
    corner: [i32; 2],
}

impl Hand {
    fn does(&self, arguments: &[String]) -> String {
        let mut command = Command::new("xdotool");
        let output = command.args(arguments).env("DISPLAY", &self.display).output().unwrap();
        assert!(output.status.success(), "{arguments:?}: {output:?}");
        String::from_utf8(output.stdout).unwrap()
    }

    fn moves(&self, [x, y]: [i32; 2]) {
        let place = [x + self.corner[0], y + self.corner[1]].map(|n| n.to_string());
        self.does(&["mousemove".to_owned(), place[0].clone(), place[1].clone()]);
        std::thread::sleep(Duration::from_millis(150));
    }

    /// Drags with the left button from one place of the window to another, in steps, and lets go after
    /// `arrived`.
    fn drags<T>(&self, from: [i32; 2], to: [i32; 2], arrived: impl FnOnce() -> T) -> T {
        self.moves(from);
        self.does(&["mousedown".to_owned(), "1".to_owned()]);
        std::thread::sleep(Duration::from_millis(150));
        for step in 1..=8 {
            self.moves([0, 1].map(|axis| from[axis] + (to[axis] - from[axis]) * step / 8));
        }
        let result = arrived();
        self.does(&["mouseup".to_owned(), "1".to_owned()]);
        result
    }
}

#[test]
fn a_dragged_slider_changes_the_picture() {
    if let Some(missing) = ["Xvfb", "xdotool"].into_iter().find(|program| !is_there(program)) {
        return skip(&format!("{missing} is not installed"));
    }
    let folder = tempfile::tempdir().unwrap();
    let path: PathBuf = folder.path().join("scene.toml");
    std::fs::write(&path, SCENE).unwrap();
    let Some((_server, display)) = x_server(folder.path()) else {
        return skip("Xvfb does not start");
    };
    let child = Command::new(env!("CARGO_BIN_EXE_rilievo-viewer"))
        .arg(&path)
        .args(["--journal", "--window", "640x480", "--threads", "1"])
        .env("DISPLAY", &display)
        .env("XDG_RUNTIME_DIR", folder.path())
        .env_remove("WAYLAND_DISPLAY")
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut viewer = Running(child);
    let (tell, lines) = channel();
    let output = BufReader::new(viewer.0.stdout.take().unwrap());
    std::thread::spawn(move || {
        output.lines().map_while(Result::ok).try_for_each(|line| tell.send(line))
    });
    let mut journal = Journal { lines, widgets: HashMap::new() };
    if !journal.settled() {
        let mut why = String::new();
        viewer.0.stderr.take().unwrap().read_to_string(&mut why).unwrap();
        assert!(why.contains("no window can be opened"), "{why}");
        return skip(&why);
    }

    let mut hand = Hand { display, corner: [0, 0] };
    let search = ["search", "--onlyvisible", "--name", "rilievo", "getwindowgeometry", "--shell"];
    let geometry = hand.does(&search.map(str::to_owned));
    let coordinate = |name: &str| {
        let line = geometry.lines().find_map(|line| line.strip_prefix(name));
        line.and_then(|n| n.parse::<i32>().ok()).unwrap()
    };
    hand.corner = [coordinate("X="), coordinate("Y=")];
    let on_screen = |[x, y, w, h]: [i32; 4]| [x + hand.corner[0], y + hand.corner[1], w, h];
    let picture = on_screen(journal.widgets["picture"]);
    let before = Screen::read(folder.path()).part(picture);
    let seen = bright(&before);
    let share = seen as f64 / before.len() as f64;
    assert!((0.02..0.6).contains(&share), "a plate and a hill in front of black: {share}");

    // From where the handle stands at 0.1 of -0.25 to 0.25 towards the right end: the hill grows.
    let [x, y, _, height] = journal.widgets["depth"];
    let (left, width) = (x + 8, 130 - 16);
    let at = |share: f64| [left + (share * f64::from(width)) as i32, y + height / 2];
    let told = || {
        journal.until(|line| {
            let is_depth = line.contains("\"what\":\"depth\"");
            number(line, "value").filter(|&depth| is_depth && depth > 0.18)
        })
    };
    let depth = hand.drags(at(0.7), at(0.95), told).expect("the depth was told");
    assert!(depth <= 0.25, "{depth}");
    assert!(journal.settled(), "it runs");
    let after = Screen::read(folder.path()).part(picture);
    let grown = bright(&after) as f64 / seen as f64;
    assert!(grown > 1.1, "the hill takes {grown} times the pixels it took");
    assert!(before != after);
}

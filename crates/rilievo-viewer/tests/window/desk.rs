//! [`Desk`]: a screen, the viewer on it, and a hand on mouse and keys.

use std::collections::HashMap;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::channel;
use std::time::Duration;

use crate::journal::Journal;
use crate::screen::Screen;

/// A program that ends with the test.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        // One that has ended already is no news.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Says that a test was not done.
pub fn skip(why: &str) {
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

/// A screen with the viewer on it.
pub struct Desk {
    pub journal: Journal,
    viewer: Running,
    _server: Running,
    folder: tempfile::TempDir,
    display: String,
    /// The top left corner of the window on the screen.
    corner: [i32; 2],
}

impl Desk {
    /// Opens the viewer in a folder of its own, in which `prepare` puts files and says what to show; waits for the whole
    /// picture. None, and stderr says why, if there is no screen to open it on.
    pub fn open(prepare: impl FnOnce(&Path) -> Vec<String>) -> Option<Self> {
        if let Some(missing) = ["Xvfb", "xdotool"].into_iter().find(|program| !is_there(program)) {
            skip(&format!("{missing} is not installed"));
            return None;
        }
        let folder = tempfile::tempdir().unwrap();
        let arguments = prepare(folder.path());
        let Some((server, display)) = x_server(folder.path()) else {
            skip("Xvfb does not start");
            return None;
        };
        let child = Command::new(env!("CARGO_BIN_EXE_rilievo-viewer"))
            .args(arguments)
            .args(["--journal", "--window", "640x740", "--threads", "1"])
            .current_dir(folder.path())
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
        let mut journal = Journal { lines, widgets: HashMap::new(), renders: String::new() };
        if !journal.settled() {
            let mut why = String::new();
            viewer.0.stderr.take().unwrap().read_to_string(&mut why).unwrap();
            assert!(why.contains("no window can be opened"), "{why}");
            skip(&why);
            return None;
        }
        let mut desk = Self { journal, viewer, _server: server, folder, display, corner: [0, 0] };
        let search =
            ["search", "--onlyvisible", "--name", "rilievo", "getwindowgeometry", "--shell"];
        let geometry = desk.does(&search);
        let coordinate = |name: &str| {
            let line = geometry.lines().find_map(|line| line.strip_prefix(name));
            line.and_then(|n| n.parse::<i32>().ok()).unwrap()
        };
        desk.corner = [coordinate("X="), coordinate("Y=")];
        Some(desk)
    }

    /// The folder with all files.
    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// The pixels of the picture as they are on the screen, once nothing changes any more.
    pub fn picture(&mut self) -> Vec<[u8; 3]> {
        assert!(self.journal.settled(), "it runs");
        self.seen("picture")
    }

    /// The pixels of a widget as they are on the screen now.
    pub fn seen(&self, widget: &str) -> Vec<[u8; 3]> {
        let [x, y, w, h] = self.journal.widgets[widget];
        let on_screen = [x + self.corner[0], y + self.corner[1], w, h];
        Screen::read(self.folder.path()).part(on_screen)
    }

    pub fn does(&self, arguments: &[&str]) -> String {
        let mut command = Command::new("xdotool");
        let output = command.args(arguments).env("DISPLAY", &self.display).output().unwrap();
        assert!(output.status.success(), "{arguments:?}: {output:?}");
        String::from_utf8(output.stdout).unwrap()
    }

    pub fn moves(&self, [x, y]: [i32; 2]) {
        let [x, y] = [x + self.corner[0], y + self.corner[1]].map(|n| n.to_string());
        self.does(&["mousemove", &x, &y]);
        std::thread::sleep(Duration::from_millis(150));
    }

    /// Drags with the left button from one place of the window to another, in steps, and lets go after
    /// `arrived`.
    pub fn drags<T>(
        &mut self,
        from: [i32; 2],
        to: [i32; 2],
        arrived: impl FnOnce(&mut Journal) -> T,
    ) -> T {
        self.moves(from);
        self.does(&["mousedown", "1"]);
        std::thread::sleep(Duration::from_millis(150));
        for step in 1..=8 {
            self.moves([0, 1].map(|axis| from[axis] + (to[axis] - from[axis]) * step / 8));
        }
        let result = arrived(&mut self.journal);
        self.does(&["mouseup", "1"]);
        result
    }

    /// The middle of a widget.
    pub fn middle(&self, widget: &str) -> [i32; 2] {
        let [x, y, w, h] = self.journal.widgets[widget];
        [x + w / 2, y + h / 2]
    }

    /// Clicks on the middle of a widget.
    pub fn clicks(&mut self, widget: &str) {
        self.journal.catch_up();
        self.moves(self.middle(widget));
        self.does(&["mousedown", "1"]);
        std::thread::sleep(Duration::from_millis(150));
        self.does(&["mouseup", "1"]);
        std::thread::sleep(Duration::from_millis(300));
    }

    /// Writes into a field in place of what is there.
    pub fn writes(&mut self, widget: &str, text: &str) {
        self.clicks(widget);
        self.does(&["key", "ctrl+a"]);
        self.does(&["type", "--delay", "40", text]);
        std::thread::sleep(Duration::from_millis(500));
    }

    /// Drags the slider of the depth from 0.1 of -0.25 to 0.25 towards the right end.
    pub fn deepens(&mut self) -> f64 {
        let [x, y, _, height] = self.journal.widgets["depth"];
        let (left, width) = (x + 8, 130 - 16);
        let at = |share: f64| [left + (share * f64::from(width)) as i32, y + height / 2];
        self.drags(at(0.7), at(0.95), |journal| journal.depth_above(0.18))
    }

    /// Asks the window to close.
    pub fn closes(&self) {
        // There is no window manager that would do it.
        self.does(&["search", "--onlyvisible", "--name", "rilievo", "windowfocus"]);
        std::thread::sleep(Duration::from_millis(300));
        self.does(&["key", "ctrl+q"]);
    }

    /// The exit code once the program has ended; none if it goes on.
    pub fn ended(&mut self) -> Option<i32> {
        for _ in 0..100 {
            if let Some(status) = self.viewer.0.try_wait().unwrap() {
                return status.code();
            }
            std::thread::sleep(Duration::from_millis(100));
        }
        None
    }
}

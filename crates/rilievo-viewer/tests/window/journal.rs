//! What the viewer tells its scripts.

use std::collections::HashMap;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

/// How long anything may take on a busy machine.
pub const PATIENCE: Duration = Duration::from_secs(300);
/// How long nothing is told before all is done.
const SILENCE: Duration = Duration::from_secs(2);

/// What the journal of the viewer tells, line by line.
pub struct Journal {
    pub lines: Receiver<String>,
    /// Where widgets are: left, top, width, height.
    pub widgets: HashMap<String, [i32; 4]>,
    /// What renders.
    pub renders: String,
}

/// The number after `"key":`.
pub fn number(line: &str, key: &str) -> Option<f64> {
    let rest = line.split_once(&format!("\"{key}\":"))?.1;
    let end = rest.find([',', '}']).unwrap_or(rest.len());
    rest[..end].parse().ok()
}

impl Journal {
    /// Remembers where a widget is, and what renders.
    fn note(&mut self, line: &str) {
        if line.contains("\"event\":\"backend\"") {
            let name = line.split("\"name\":\"").nth(1).and_then(|s| s.split('"').next());
            self.renders = name.unwrap_or_default().to_owned();
        }
        if !line.contains("\"event\":\"widget\"") {
            return;
        }
        let name = line.split("\"name\":\"").nth(1).and_then(|s| s.split('"').next());
        let place = ["x", "y", "width", "height"].map(|key| number(line, key));
        if let (Some(name), [Some(x), Some(y), Some(w), Some(h)]) = (name, place) {
            self.widgets.insert(name.to_owned(), [x, y, w, h].map(|n| n as i32));
        }
    }

    /// Reads what was told by now.
    pub fn catch_up(&mut self) {
        while let Ok(line) = self.lines.try_recv() {
            self.note(&line);
        }
    }

    /// Reads until `wanted` finds what it looks for; none if the program ended before.
    pub fn until<T>(&mut self, mut wanted: impl FnMut(&str) -> Option<T>) -> Option<T> {
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
    pub fn settled(&mut self) -> bool {
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

    /// Waits until the depth was told to be above this.
    pub fn depth_above(&mut self, least: f64) -> f64 {
        let told = |line: &str| {
            let is_depth = line.contains("\"what\":\"depth\"");
            number(line, "value").filter(|&depth| is_depth && depth > least)
        };
        self.until(told).expect("the depth was told")
    }

    /// Waits until a GPU renders; why none does otherwise.
    pub fn wait_for_gpu(&mut self) -> Result<(), String> {
        let word = |line: &str, key: &str| {
            let rest = line.split_once(&format!("\"{key}\":\""))?.1;
            Some(rest.split('"').next()?.to_owned())
        };
        if !self.renders.is_empty() && self.renders != "cpu" {
            return Ok(());
        }
        let told = |line: &str| {
            let line = Some(line).filter(|line| line.contains("\"event\":\"backend\""))?;
            match (word(line, "name")?.as_str(), word(line, "why")?) {
                ("cpu", why) if why.is_empty() => None,
                ("cpu", why) => Some(Err(why)),
                _ => Some(Ok(())),
            }
        };
        self.until(told).expect("it runs")
    }
}

//! What machine a run was taken on: nothing that names it.

use serde::Serialize;

use crate::report::object;

#[derive(Debug, PartialEq, Serialize)]
struct Machine {
    cpu: String,
    /// Family, model and stepping: model names of rented machines say little.
    cpu_id: [u32; 3],
    /// Processors that this program may use.
    processors: usize,
    /// Vector extensions, of those that matter here.
    vectors: Vec<String>,
    cache_kib: Option<u64>,
    memory_mib: Option<u64>,
}

/// Prints the machine as one JSON object, for `machine.json` of a run.
///
/// # Errors
/// When the system does not tell, or standard output cannot be written.
pub fn machine() -> Result<(), String> {
    let read = |path: &str| std::fs::read_to_string(path).map_err(|e| format!("{path}: {e}"));
    let processors = std::thread::available_parallelism().map_or(1, usize::from);
    object(&of(&read("/proc/cpuinfo")?, &read("/proc/meminfo")?, processors))
}

fn of(cpuinfo: &str, meminfo: &str, processors: usize) -> Machine {
    let value = |text: &str, key: &str| {
        text.lines().find_map(|line| {
            let (name, value) = line.split_once(':')?;
            (name.trim() == key).then(|| value.trim().to_owned())
        })
    };
    let number = |text: &str, key: &str| {
        value(text, key).and_then(|v| v.split_whitespace().next()?.parse::<u64>().ok())
    };
    let flags = value(cpuinfo, "flags").unwrap_or_default();
    let known = ["sse4_2", "avx", "avx2", "fma", "avx512f", "avx512bw", "avx512vl", "avx512vbmi"];
    let id = |key| number(cpuinfo, key).unwrap_or(0) as u32;
    Machine {
        cpu: value(cpuinfo, "model name").unwrap_or_else(|| "unknown".to_owned()),
        cpu_id: [id("cpu family"), id("model"), id("stepping")],
        processors,
        vectors: flags
            .split_whitespace()
            .filter(|flag| known.contains(flag))
            .map(str::to_owned)
            .collect(),
        cache_kib: number(cpuinfo, "cache size"),
        memory_mib: number(meminfo, "MemTotal").map(|kib| kib / 1024),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_processor_is_told_by_model_and_extensions() {
        let cpuinfo = "processor\t: 0\nmodel name\t: AMD EPYC\ncpu family\t: 26\nmodel\t\t: 2\n\
                       stepping\t: 1\ncache size\t: 1024 KB\nflags\t\t: fpu avx2 avx512f\n\n\
                       processor\t: 1\nmodel name\t: other\n";
        let machine = of(cpuinfo, "MemTotal:       2097152 kB\n", 2);
        assert_eq!((machine.cpu.as_str(), machine.cpu_id), ("AMD EPYC", [26, 2, 1]));
        assert_eq!(machine.vectors, ["avx2", "avx512f"]);
        assert_eq!((machine.cache_kib, machine.memory_mib), (Some(1024), Some(2048)));
        assert_eq!(of("", "", 1).cpu, "unknown");
    }
}

//! Help, versions, and words that make no sense.

use crate::support::Folder;

#[test]
fn every_help_is_complete_and_ends_with_examples() {
    let folder = Folder::new();
    let commands = [
        "",
        "render",
        "bake",
        "bake normal",
        "bake distance",
        "bake bounds",
        "info",
        "check",
        "diff",
        "merge",
    ];
    for command in commands {
        let help = folder.run(&format!("{command} --help")).expect(0).stdout;
        let (_, examples) = help.split_once("Examples:\n").unwrap_or_else(|| panic!("{command}"));
        let prefix = format!("  rilievo {command}");
        assert!(examples.lines().count() > 1);
        assert!(examples.lines().all(|line| line.starts_with(&prefix)), "{examples}");
    }
    let help = folder.run("--help").stdout;
    assert!(help.contains("Exit codes:") && help.contains("130"));
    let render = folder.run("render --help").stdout;
    let flags = [
        "--output",
        "--samples",
        "--resolution",
        "--integrator",
        "--method",
        "--backend",
        "--threads",
        "--seed",
        "--aov",
        "--pixel-centers",
        "--exr",
        "--tiles",
        "--denoise",
        "--tev",
        "--view",
        "--filter",
        "--filter-radius",
        "--exposure",
        "--max-memory",
        "--time-limit",
        "--checkpoint",
        "--resume",
        "--clamp",
        "--lod",
        "--sample-range",
        "--crop",
        "--max-error",
        "--json",
        "--quiet",
    ];
    for flag in flags {
        assert!(render.contains(flag), "{flag}");
    }
    assert!(folder.run("--version").expect(0).stdout.starts_with("rilievo "));
}

/// The flags that a help describes.
fn flags_of(help: &str) -> Vec<String> {
    let named = |line: &str| {
        let (_, rest) = line.split_once("--")?;
        let end = rest.find(|c: char| !c.is_ascii_lowercase() && c != '-').unwrap_or(rest.len());
        let first = line.trim_start();
        first.starts_with('-').then(|| rest[..end].to_owned())
    };
    let (_, flags) = help.split_once("Options:\n").unwrap();
    let own = |flag: &String| !["help", "version"].contains(&flag.as_str());
    flags.lines().filter_map(named).filter(own).collect()
}

/// Whether an example shows a flag.
fn shows(example: &str, flag: &str) -> bool {
    let after = example.split_once(&format!(" --{flag}")).map(|(_, rest)| rest);
    let ends = |rest: &str| !rest.starts_with(|c: char| c.is_ascii_lowercase() || c == '-');
    after.is_some_and(ends) || flag == "output" && example.contains(" -o ")
}

#[test]
fn every_flag_of_render_stands_in_a_group_and_in_an_example() {
    let help = Folder::new().run("render --help").expect(0).stdout;
    let (flags, examples) = help.split_once("Examples:\n").unwrap();
    let flags = flags_of(flags);
    assert!(flags.len() > 25, "{flags:?}");
    for flag in flags {
        assert!(examples.lines().any(|line| shows(line, &flag)), "--{flag} has no example");
    }
    for group in ["Picture:", "Samples:", "Walk:", "Limits:", "While it runs:"] {
        assert!(help.contains(&format!("\n{group}\n")), "{group}");
    }
}

#[test]
fn every_flag_has_an_example() {
    let folder = Folder::new();
    let help = |command: &str| folder.run(&format!("{command} --help")).expect(0).stdout;
    // What several commands have alike is shown by one of them.
    let commands =
        ["bake normal", "bake distance", "bake bounds", "info", "check", "diff", "merge"];
    let helps = commands.map(help);
    let examples: Vec<_> =
        helps.iter().filter_map(|help| help.split_once("Examples:\n")).map(|(_, e)| e).collect();
    for (command, help) in commands.iter().zip(&helps) {
        let (flags, own) = help.split_once("Examples:\n").unwrap();
        for flag in flags_of(flags) {
            let alike = ["grid", "wrap", "invert", "json", "quiet"].contains(&flag.as_str());
            let found = if alike { &examples[..] } else { &[own][..] };
            let mut lines = found.iter().flat_map(|examples| examples.lines());
            assert!(lines.any(|line| shows(line, &flag)), "{command}: --{flag} has no example");
        }
    }
}

#[test]
fn nonsense_is_a_usage_error_before_any_work() {
    let folder = Folder::new().with_scene();
    let before = folder.names();
    let lines = [
        "",
        "paint scene.toml",
        "render scene.toml",
        "render scene.toml -o out.jpg",
        "render scene.toml -o out",
        "render scene.toml -o out.png --samples 0",
        "render scene.toml -o out.png --samples many",
        "render scene.toml -o out.png --resolution 64",
        "render scene.toml -o out.png --resolution 0x5",
        "render scene.toml -o out.png --integrator radiosity",
        "render scene.toml -o out.png --method guess",
        "render scene.toml -o out.png --threads 1000000",
        "render scene.toml -o out.png --aov Colour",
        "render scene.toml -o out.png --aov P",
        "render scene.toml -o out.png --time-limit -1",
        "render scene.toml -o out.png --max-memory lots",
        "render scene.toml -o out.png --view clamp",
        "render scene.toml -o out.png --exposure 101",
        "render scene.toml -o out.png --filter sinc",
        "render scene.toml -o out.png --denoise=magic",
        "render scene.toml -o out.exr --denoise --integrator aov",
        "render scene.toml -o out.exr --exr double",
        "render scene.toml -o out.exr --tiles 8",
        "render scene.toml -o out.png --filter-radius 0",
        "render scene.toml -o out.png --resume",
        "render scene.toml -o out.png --sample-range 0..2",
        "render scene.toml -o out.exr --sample-range 2..2",
        "render scene.toml -o out.exr --sample-range 2",
        "render scene.toml -o out.exr --crop 0,0,4",
        "render scene.toml -o out.exr --crop 4,0,4,4",
        "render scene.toml -o out.exr --max-error 0",
        "render scene.toml -o out.exr --checkpoint soon",
        "merge -o out.exr",
        "merge a.exr b.exr -o out.png",
        "bake map.png -o out.map",
        "bake distance map.png -o out.map --size 4,4",
        "bake distance map.png -o out.map --size 1,4,4 --kind corrected",
        "bake normal map.png -o out.map --convention directx",
        "bake normal map.png -o out.png --depth 0",
        "check scene.toml --map map.png",
        "diff map.png",
        "diff map.png map.png --max -1",
        "diff map.png map.png -o heat.exr",
    ];
    for line in lines {
        let run = folder.run(line);
        assert_eq!(run.code, Some(2), "{line}: {}", run.stderr);
        assert!(run.stdout.is_empty(), "{line}");
        assert_eq!(folder.names(), before, "{line}");
    }
}

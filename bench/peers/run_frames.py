"""Runs the frame by everyone and records the lines in bench/runs/<date>-<machine>/frames.jsonl.

    run_frames.py [--sizes 1024,2048,4096] [--rounds 1] [--only rilievo,mitsuba] [--run FOLDER] [--append]

Contenders take turns within a round, one at a time, so that whatever else the machine does meets all
of them. Each line is appended as soon as it is there; `machine.json` beside them says where and on
what. A contender that fails is named on standard error and leaves no line.
"""

import argparse
import datetime
import json
import platform
import re
import subprocess
import sys
from pathlib import Path

import environment
import kernel_tables
import measure

#: (peer, variant, bounces) of the whole frame.
FRAMES = [
    ("rilievo", "default", 1),
    ("rilievo", "tiny", 1),
    ("rilievo", "default", 0),
    ("mitsuba", "llvm_ad_rgb", 1),
    ("mitsuba", "llvm_ad_rgb", 0),
    ("mitsuba", "scalar_rgb", 1),
    ("cycles", "adaptive", 1),
    ("cycles", "full", 1),
    ("povray", "soft", 0),
    ("povray", "hard", 0),
]

#: Who is asked for the first 8 x 8 pixels, one ray each, of the largest map.
FIRST_PIXELS = [
    ("rilievo", "default", 0),
    ("povray", "hard", 0),
    ("mitsuba", "scalar_rgb", 0),
    ("cycles", "adaptive", 0),
]


def machine():
    """What the figures depend on besides the programs: the facts of `rilievo-bench machine`, and the
    system and commit."""
    facts = json.loads(kernel_tables.bench("machine"))
    release = Path("/etc/os-release")
    named = re.search(r'PRETTY_NAME="?([^"\n]+)', release.read_text()) if release.exists() else None
    system = named.group(1) if named else platform.system()
    return {**facts, "system": f"{system}, {platform.machine()}",
            "python": platform.python_version(), "rilievo": commit()}


def commit():
    """Which rilievo: the commit at hand, and whether the tree differs from it."""
    git = ["git", "-C", str(environment.repository())]
    done = subprocess.run([*git, "rev-parse", "--short=12", "HEAD"], stdout=subprocess.PIPE, text=True)
    changed = subprocess.run([*git, "status", "--porcelain", "--", "crates"],
                             stdout=subprocess.PIPE, text=True)
    return done.stdout.strip() + (" with changes" if changed.stdout.strip() else "")


def folder_of(options, cpu):
    """Where this run is recorded."""
    if options.run:
        return options.run.resolve()
    name = re.sub(r"\(.*?\)|@.*|processor|\bcpu\b", "", cpu, flags=re.IGNORECASE)
    name = "-".join(re.findall(r"[a-z0-9]+", name.lower()))
    today = datetime.datetime.now(datetime.timezone.utc).date().isoformat()
    runs = environment.repository() / "bench" / "runs"
    return runs / f"{today}-{name}-{measure.threads()}core"


def record(folder, options, contender, more):
    """One line more, or a word on standard error."""
    peer, variant, bounces = contender
    command = [sys.executable, str(environment.HERE / f"{peer}_frame.py"), "--variant", variant,
               "--bounces", str(bounces), "--cache", str(options.cache), *map(str, more)]
    print(" ".join([peer, variant, f"bounces {bounces}", *map(str, more)]), file=sys.stderr)
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True)
    if done.returncode != 0:
        print(f"{peer} {variant} failed", file=sys.stderr)
        return False
    line = json.loads(done.stdout.strip().splitlines()[-1])
    line["at"] = datetime.datetime.now(datetime.timezone.utc).isoformat(timespec="seconds")
    with open(folder / "frames.jsonl", "a") as file:
        file.write(json.dumps(line) + "\n")
    return True


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sizes", default="1024,2048,4096", help="samples a side, parted by commas")
    parser.add_argument("--resolution", type=int, default=1024, help="pixels along each side")
    parser.add_argument("--rounds", type=int, default=1, help="how often everybody's turn comes")
    parser.add_argument("--only", help="peers, parted by commas")
    parser.add_argument("--append", action="store_true", help="add to lines that are there")
    parser.add_argument("--run", type=Path, help="folder to record in")
    parser.add_argument("--cache", type=Path, default=environment.default_cache(),
                        help="folder for environments, maps and pictures")
    options = parser.parse_args()
    sizes = [int(size) for size in options.sizes.split(",")]
    wanted = options.only.split(",") if options.only else None
    chosen = [c for c in FRAMES if wanted is None or c[0] in wanted]
    first = [c for c in FIRST_PIXELS if wanted is None or c[0] in wanted]
    here = machine()
    folder = folder_of(options, here["cpu"])
    if (folder / "frames.jsonl").exists() and not options.append:
        raise SystemExit(f"{folder} holds frames already; --append adds to them")
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "machine.json").write_text(json.dumps(here, indent=2) + "\n")
    done = []
    for _ in range(options.rounds):
        for size in sizes:
            whole = ["--size", size, "--resolution", options.resolution]
            done += [record(folder, options, c, whole) for c in chosen]
        tiny = ["--size", max(sizes), "--resolution", 8, "--samples", 1]
        done += [record(folder, options, c, tiny) for c in first]
    print(folder)
    return 0 if all(done) else 1


if __name__ == "__main__":
    sys.exit(main())

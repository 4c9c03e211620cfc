"""Fills the measured parts of docs/performance.md, and draws its plots, from a recorded run.

    performance_page.py [--run bench/runs/<date>-<machine>]

Reads frames.jsonl and machine.json of the run, the newest by name unless told; what concerns rays,
memory, builds and distance maps is tabulated and drawn by `rilievo-bench`, which is built for it.
What stands between `<!-- run:NAME -->` and `<!-- /run:NAME -->` is replaced, the rest is written by
hand. Where a contender has several lines (rounds), the one with the median total counts.
"""

import argparse
import json
import sys
from pathlib import Path

import environment
import kernel_tables
from bar_chart import Bar, chart

PAGE = environment.repository() / "docs" / "performance.md"
FIGURES = environment.repository() / "docs" / "figures" / "performance"
UNMEASURED = "Not measured in this run."
MIB = 2.0 ** 20

NAMES = {
    ("rilievo", "default"): "rilievo",
    ("rilievo", "tiny"): "rilievo, tiny",
    ("mitsuba", "llvm_ad_rgb"): "Mitsuba, llvm",
    ("mitsuba", "scalar_rgb"): "Mitsuba, scalar",
    ("cycles", "adaptive"): "Cycles, adaptive",
    ("cycles", "full"): "Cycles, full",
    ("cycles", "mesh"): "Cycles, mesh",
    ("povray", "soft"): "POV-Ray",
    ("povray", "hard"): "POV-Ray, point light",
}


def lines_of(path):
    """The objects of a file of JSON lines; none if it is not there."""
    if not path.exists():
        return []
    return [json.loads(line) for line in path.read_text().splitlines() if line.strip()]


def median_line(lines, key):
    """The line in the middle by `key`."""
    return sorted(lines, key=lambda line: line[key])[(len(lines) - 1) // 2]


class Frames:
    """The lines of whole frames, one for each contender, size and job."""

    def __init__(self, lines):
        grouped = {}
        for line in lines:
            if line["bench"] != "frames":
                continue
            key = (line["resolution"], line["size"], line["peer"], line["variant"], line["bounces"])
            grouped.setdefault(key, []).append(line)
        self.lines = {k: median_line(v, "total_cpu_seconds") for k, v in grouped.items()}
        self.rounds = max((len(v) for v in grouped.values()), default=0)
        self.large = max((k[0] for k in self.lines), default=0)

    def sizes(self):
        return sorted({k[1] for k in self.lines if k[0] == self.large})

    def of(self, size, resolution=None):
        """The contenders of a size in the order of NAMES, with the bounce before without."""
        resolution = resolution or self.large
        order = list(NAMES)
        found = [k for k in self.lines if k[0] == resolution and k[1] == size]
        found.sort(key=lambda k: (-k[4], order.index((k[2], k[3]))))
        return [(k[4], self.lines[k]) for k in found]


def name(line):
    return NAMES[line["peer"], line["variant"]]


def table(heads, rows):
    """A table of Markdown."""
    text = ["| " + " | ".join(heads) + " |", "|" + "---|" * len(heads)]
    return "\n".join(text + ["| " + " | ".join(row) + " |" for row in rows])


def seconds(value):
    return f"{value:.2f}" if value < 10 else f"{value:.1f}"


def ratio(line, ours, key):
    """How many times our figure theirs is; bold where a peer leads."""
    times = line[key] / ours[key]
    told = f"{times:.2f}" if times < 10 else f"{times:.0f}"
    return f"**{told}**" if times < 1 and line["peer"] != "rilievo" else told


def frames_table(frames):
    parts = []
    for bounces, heading in ((1, "One bounce"), (0, "No bounce")):
        rows = []
        for size in frames.sizes():
            here = [line for b, line in frames.of(size) if b == bounces]
            ours = next((line for line in here if line["variant"] == "default"), None)
            if ours is None:
                continue
            for line in here:
                rows.append([
                    f"{size}^2", name(line), seconds(line["prepare_cpu_seconds"]),
                    seconds(line["render_cpu_seconds"]), seconds(line["total_cpu_seconds"]),
                    ratio(line, ours, "total_cpu_seconds"),
                    seconds(line["wall_seconds"]), f"{line['peak_rss_bytes'] / MIB:.0f}",
                    ratio(line, ours, "peak_rss_bytes"),
                    f"{line['mean_radiance']:.4f}",
                ])
        heads = ["map", "program", "prepare, CPU s", "render, CPU s", "total, CPU s", "x rilievo",
                 "wall s", "peak MiB", "x rilievo", "mean radiance"]
        if rows:
            parts.append(f"{heading}:\n\n" + table(heads, rows))
    return "\n\n".join(parts)


def first_table(frames):
    small = [k for k in frames.lines if k[0] < frames.large]
    if not small:
        return UNMEASURED
    key = max(small, key=lambda k: k[1])
    here = [line for _, line in frames.of(key[1], key[0])]
    ours = next(line for line in here if line["peer"] == "rilievo")
    heads = ["program", "CPU s", "x rilievo", "wall s", "peak MiB"]
    rows = [[name(line), seconds(line["total_cpu_seconds"]),
             ratio(line, ours, "total_cpu_seconds"),
             seconds(line["wall_seconds"]), f"{line['peak_rss_bytes'] / MIB:.0f}"] for line in here]
    return table(heads, rows)


def transforms(made):
    """The table of distance transforms and its plot."""
    if "transforms" not in made:
        return UNMEASURED
    return f"![Nanoseconds a voxel](figures/{FIGURES.name}/transforms.svg)\n\n" + made["transforms"]


def losses(frames, rates):
    """Every place where somebody beats rilievo: rays a second, CPU time, wall time or memory."""
    found = kernel_tables.losses(rates) if rates else []
    for size in frames.sizes():
        for bounces, line in frames.of(size):
            ours = frames.lines.get((frames.large, size, "rilievo", "default", bounces))
            if ours is None or line["peer"] == "rilievo":
                continue
            for key, told, unit in (("total_cpu_seconds", "total CPU", 1.0),
                                    ("wall_seconds", "wall time", 1.0),
                                    ("peak_rss_bytes", "peak memory", MIB)):
                if line[key] < ours[key]:
                    bounce = "with" if bounces else "without"
                    found.append(f"- {size}^2, {bounce} the bounce, {told}: {name(line)} "
                                 f"{line[key] / unit:.1f}, rilievo {ours[key] / unit:.1f} "
                                 f"({'MiB' if unit > 1 else 's'}).")
    return "\n".join(found) if found else "None in this run."


def plots(frames):
    """Draws CPU time and memory: the lines with the bounce, and POV-Ray's without. Gives Markdown."""
    def bars(size, parts, told):
        shown = [line for b, line in frames.of(size) if b == 1 or line["peer"] == "povray"]
        return [Bar(name(line) + ("" if line["bounces"] else ", no bounce"), parts(line), told(line),
                    line["peer"] == "rilievo") for line in shown]

    groups = [(f"{size} x {size}", bars(
        size,
        lambda line: [line["total_cpu_seconds"] - line["render_cpu_seconds"], line["render_cpu_seconds"]],
        lambda line: f"{seconds(line['total_cpu_seconds'])} s")) for size in frames.sizes()]
    title = "Whole frame, CPU seconds: start and preparation (dark), rendering (light)"
    (FIGURES / "frames-cpu.svg").write_text(chart(title, groups))
    groups = [(f"{size} x {size}", bars(
        size, lambda line: [line["peak_rss_bytes"] / MIB],
        lambda line: f"{line['peak_rss_bytes'] / MIB:.0f} MiB")) for size in frames.sizes()]
    (FIGURES / "frames-memory.svg").write_text(
        chart("Whole frame, peak of memory, MiB", groups))
    return (f"![CPU seconds of whole frames](figures/{FIGURES.name}/frames-cpu.svg)\n\n"
            f"![Peak memory of whole frames](figures/{FIGURES.name}/frames-memory.svg)")


def run_text(folder, machine, frames):
    vectors = ", ".join(machine["vectors"]) or "none of note"
    family, model, _ = machine["cpu_id"]
    return (f"Run `bench/runs/{folder.name}`: {machine['cpu']} (family {family}, model {model}), "
            f"{machine['processors']} processors, vector extensions {vectors}, "
            f"{machine['memory_mib'] / 1024:.0f} GiB, {machine.get('system', 'system unknown')}; rilievo at "
            f"`{machine.get('rilievo', 'an unknown commit')}`; {versions(frames)}. Frames of {frames.large} x {frames.large} pixels, "
            f"the median of {frames.rounds}.")


def versions(frames):
    found = {}
    for line in frames.lines.values():
        found[line["peer"]] = line["version"]
    titles = {"mitsuba": "Mitsuba", "cycles": "Blender", "povray": "POV-Ray"}
    return ", ".join(f"{titles[p]} {v}" for p, v in sorted(found.items()) if p in titles)


def replaced(text, part, body):
    """`text` with what stands between the marks of `part` replaced."""
    opening, closing = f"<!-- run:{part} -->", f"<!-- /run:{part} -->"
    begin, end = text.find(opening), text.find(closing)
    if begin < 0 or end < begin:
        raise SystemExit(f"{PAGE}: lacks the marks {opening} and {closing}")
    return text[:begin + len(opening)] + "\n" + body.rstrip() + "\n" + text[end:]


def newest(runs):
    """The last folder by name that holds frames."""
    found = sorted(folder for folder in runs.glob("*") if (folder / "frames.jsonl").exists())
    if not found:
        raise SystemExit(f"{runs}: no recorded run; run_frames.py makes one")
    return found[-1]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--run", type=Path, help="folder of the run; else the newest")
    options = parser.parse_args()
    folder = options.run.resolve() if options.run else newest(environment.repository() / "bench" / "runs")
    frames = Frames(lines_of(folder / "frames.jsonl"))
    machine = json.loads((folder / "machine.json").read_text())
    text = PAGE.read_text()
    FIGURES.mkdir(parents=True, exist_ok=True)
    made = kernel_tables.tables(folder)
    rays, costs = kernel_tables.images(folder, FIGURES) if made else ("", "")
    for part, body in (
        ("machine", run_text(folder, machine, frames)),
        ("rays", "\n\n".join([made.get("means", UNMEASURED), rays])),
        ("rates", made.get("rates", UNMEASURED)),
        ("memory", "\n\n".join([costs, made.get("memory", UNMEASURED)])),
        ("builds", made.get("builds", UNMEASURED)),
        ("transforms", transforms(made)),
        ("frames", plots(frames) + "\n\n" + frames_table(frames)),
        ("first", first_table(frames)),
        ("losses", losses(frames, made.get("rates"))),
    ):
        text = replaced(text, part, body)
    PAGE.write_text(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())

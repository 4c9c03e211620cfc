"""What `rilievo-bench` makes of a run: its tables, one by one, and its plots."""

import re
import subprocess
import sys

import environment

#: How the first line of each table of `rilievo-bench summary` begins.
HEADS = {
    "means": "| size | geometric mean",
    "rates": "| map, size |",
    "memory": "| size | contender |",
    "builds": "| size | layout |",
    "transforms": "| grid |",
}

ROW_NAMES = ["primary", "shadow", "diffuse", "grazing", "primary16-packets", "shadow-packets"]


def bench(*words):
    """Calls the released rilievo-bench, built from the sources at hand; gives what it prints."""
    command = ["cargo", "run", "--release", "--locked", "--quiet", "-p", "rilievo-bench", "--",
               *map(str, words)]
    done = subprocess.run(command, cwd=environment.repository(), check=True,
                          stdout=subprocess.PIPE, stderr=sys.stderr, text=True)
    return done.stdout


def tables(folder):
    """The tables of a run by the names of HEADS; those the run has no lines for are missing.

    Rays come level by level; rates are those of the level with most rows, means those of all
    levels, that one first.
    """
    level, found, means = "", {}, {}
    for block in re.split(r"\n\s*\n", bench("summary", folder)):
        heading = re.match(r"## rilievo \((.*)\)", block)
        if heading:
            level = heading[1]
        for name, head in HEADS.items():
            # A head and its rule alone say that nothing was measured.
            if not block.startswith(head) or len(block.splitlines()) <= 2:
                continue
            if name == "means":
                means[level] = block.strip()
            elif len(block) > len(found.get(name, "")):
                found[name] = block.strip()
    if means:
        order = sorted(means, key=lambda level: -len(means[level]))
        found["means"] = "\n\n".join(f"With `--simd {level}`:\n\n{means[level]}" for level in order)
    return found


def losses(rates):
    """Lines of a list: the rows in which an Embree contender leads, from the table of rates."""
    found = []
    for row in rates.splitlines()[2:]:
        where, rays, ours, _, best, name, ratio = [c.strip() for c in row.strip("|").split("|")]
        if "**" in ratio:
            found.append(f"- {where}, {rays}: {name} {best} million rays a second, rilievo {ours}.")
    return found


def images(folder, figures):
    """Draws the plots into `figures`; gives Markdown for rays and for memory and build."""
    for old in figures.glob("kernels-*.svg"):
        old.unlink()
    for old in figures.glob("ratios-*.svg"):
        old.unlink()
    bench("plots", folder, "-o", figures)

    def image(path, words):
        return f"![{words}](figures/{figures.name}/{path.name})"

    ratios = sorted(figures.glob("ratios-*.svg"), key=lambda p: int(re.search(r"\d+", p.stem)[0]))
    rays = [image(p, f"rilievo over the best Embree, maps of {p.stem[7:]} samples a side") for p in ratios]
    rows = [figures / f"kernels-{name}.svg" for name in ROW_NAMES]
    rays += [image(p, f"Rays a second by size of the map: {p.stem[8:]}") for p in rows if p.exists()]
    costs = [image(figures / f"{name}.svg", words) for name, words in (
        ("memory", "Bytes a sample beyond the heights"), ("build", "Time of the build"))
        if (figures / f"{name}.svg").exists()]
    return "\n\n".join(rays), "\n\n".join(costs)

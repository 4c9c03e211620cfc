"""How the error of a picture falls with the samples a pixel, by sampler: a plot and its numbers.

    convergence.py docs/figures/convergence.svg

Renders smooth scenes with other seeds and takes the variance of a pixel over them, in the mean over all pixels.
Independent samples let it fall as 1 / N; the slopes that are printed are fitted to the last four counts.
"""

import argparse
import json
import math
from pathlib import Path

import environment
import measure
import rilievo_frame

SAMPLERS = {"sobol": "#d9480f", "jittered": "#1c7ed6", "independent": "#868e96"}
COUNTS = [1, 4, 16, 64, 256, 1024]
SIDE = 16
#: What is seen, by name: a floor under a lamp, the same with a ceiling that sends light back, a floor under a sky.
CAMERA = "[camera]\nposition = [0, -2, 1.5]\nlook_at = [0, 0, 0]\nfov = 30\n"
RENDER = '[render]\nintegrator = "path"\n'
FLOOR = """[[shapes]]
type = "quad"
corners = [[-9, -9, 0], [9, -9, 0], [9, 9, 0], [-9, 9, 0]]
"""
LAMP = """[materials.lamp]
diffuse = [0, 0, 0]
emitted = [4, 4, 4]
[[shapes]]
type = "quad"
corners = [[-1, -1, 2], [-1, 1, 2], [1, 1, 2], [1, -1, 2]]
material = "lamp"
one_sided = true
"""
SCENES = {
    "direct light of a lamp": CAMERA + RENDER + "max_depth = 0\n" + FLOOR + LAMP,
    "bounces under a ceiling": CAMERA + RENDER + "max_depth = 2\n" + FLOOR + LAMP + """[[shapes]]
type = "quad"
corners = [[-9, -9, 3], [-9, 9, 3], [9, 9, 3], [9, -9, 3]]
""",
    "a floor under a sky": CAMERA + RENDER + "max_depth = 0\n[environment]\nfile = \"sky.pfm\"\n" + FLOOR,
}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("output", type=Path)
    parser.add_argument("--seeds", type=int, default=16)
    parser.add_argument("--program", help="rilievo; else it is built")
    parser.add_argument("--cache", type=Path, default=environment.default_cache())
    options = parser.parse_args()
    import lit_scenes

    folder = options.cache.resolve() / "convergence"
    lit_scenes.prepare(folder)
    program = options.program or rilievo_frame.program()
    panels = {}
    for number, (title, text) in enumerate(SCENES.items()):
        path = folder / f"{number}.toml"
        path.write_text(text)
        panels[title] = {}
        for sampler in SAMPLERS:
            variances = []
            for count in COUNTS:
                files = []
                for seed in range(options.seeds):
                    files.append(folder / f"{number}-{sampler}-{count}-{seed}.exr")
                    measure.run([program, "render", path, "-o", files[-1], "--quiet", "--samples", count,
                                 "--seed", seed, "--sampler", sampler, "--resolution", f"{SIDE}x{SIDE}"])
                said = environment.call("pictures", options.cache.resolve(), "picture.py", "variance", *files)
                variances.append(said["variance"])
            panels[title][sampler] = variances
            print(json.dumps({"bench": "convergence", "scene": title, "sampler": sampler,
                              "samples": COUNTS, "variances": variances,
                              "slope": slope(variances)}), flush=True)
    options.output.write_text(svg(panels))


def slope(variances):
    """The exponent of the last four counts, by least squares."""
    points = [(math.log(n), math.log(v)) for n, v in list(zip(COUNTS, variances))[-4:]]
    x, y = (sum(column) / len(points) for column in zip(*points))
    return sum((a - x) * (b - y) for a, b in points) / sum((a - x) ** 2 for a, _ in points)


def svg(panels):
    """A panel a scene, both axes logarithmic."""
    width, height, left, top = 250, 220, 52, 62
    total = [len(panels) * (width + 20) + left, height + top + 44]
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {total[0]} {total[1]}" '
        'font-family="sans-serif" font-size="12" fill="#868e96">',
        '<title>Variance of a pixel by samples a pixel</title>',
    ]
    x = left
    for sampler, colour in SAMPLERS.items():
        parts.append(f'<text x="{x}" y="18" fill="{colour}">{sampler}</text>')
        x += 90
    parts.append(f'<text x="{x}" y="18">dotted: 1 / N</text>')
    for k, (title, curves) in enumerate(panels.items()):
        start = left + k * (width + 20)
        values = [v for curve in curves.values() for v in curve]
        low, high = math.floor(math.log10(min(values))), math.ceil(math.log10(max(values)))

        def place(count, value):
            across = math.log(count) / math.log(COUNTS[-1]) * (width - 24) + 8
            return start + across, top + (high - math.log10(value)) / (high - low) * height

        parts.append(f'<text x="{start}" y="{top - 14}">{title}</text>')
        parts.append(f'<rect x="{start}" y="{top}" width="{width - 8}" height="{height}" fill="none" '
                     'stroke="#868e96" stroke-opacity="0.4"/>')
        for power in range(low, high + 1, max(1, (high - low) // 5)):
            _, y = place(1, 10.0 ** power)
            parts.append(f'<text x="{start - 4}" y="{y + 4:.1f}" text-anchor="end" font-size="10">'
                         f'1e{power}</text>')
        for count in COUNTS:
            x, _ = place(count, 10.0 ** low)
            parts.append(f'<text x="{x:.1f}" y="{top + height + 16}" text-anchor="middle" font-size="10">'
                         f'{count}</text>')
        first = curves["independent"][0]
        ends = [place(n, max(first / n, 10.0 ** low)) for n in (COUNTS[0], COUNTS[-1])]
        parts.append(line(ends, "#868e96", ' stroke-dasharray="2 4"'))
        for sampler, variances in curves.items():
            parts.append(line([place(*point) for point in zip(COUNTS, variances)], SAMPLERS[sampler], ""))
    parts.append(f'<text x="{left}" y="{total[1] - 10}">samples a pixel</text></svg>')
    return "\n".join(parts) + "\n"


def line(points, colour, more):
    text = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
    return f'<polyline points="{text}" fill="none" stroke="{colour}" stroke-width="2"{more}/>'


if __name__ == "__main__":
    main()

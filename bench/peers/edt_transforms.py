"""Exact Euclidean distance transforms by SciPy and by the package edt, one thread each.

    edt_transforms.py [GRID.npy ...] [--spacing Z,Y,X] [--passes 5] [--cache FOLDER]

A grid is what `rilievo-bench transforms --dump-grid` writes: three axes, 0 where the relief is, else
free; both programs give every free voxel its distance to the nearest 0. Without a grid, one of
256 x 256 x 64 voxels is made from the fbm: 0 below the surface. One line of JSON for each grid and
program, with the keys of `rilievo-bench transforms`; the median pass counts, after one that warms up.
"""

import argparse
import json
import subprocess
import sys
import time
from pathlib import Path

import environment
import measure

#: Voxels of the grid that is made here: z, y, x.
OWN = (64, 256, 256)


def own_grid(path):
    """Solid below the fbm, free above it. Runs with NumPy."""
    import numpy
    from height_map import fbm_codes

    codes = fbm_codes(OWN[2])
    low, high = int(codes.min()), int(codes.max())
    levels = low + (numpy.arange(OWN[0]) + 0.5) * (high - low) / OWN[0]
    free = codes[None, :, :] < levels[:, None, None]
    path.parent.mkdir(parents=True, exist_ok=True)
    numpy.save(path, free.astype(numpy.uint8))


def measured(path, spacing, passes):
    """Times both programs on one grid, in turn. Runs in the environment `transforms`."""
    import edt
    import numpy
    import scipy
    from importlib.metadata import version
    from scipy import ndimage

    grid = numpy.load(path)
    if grid.ndim != 3:
        raise SystemExit(f"{path}: {grid.ndim} axes, not 3")
    grid = numpy.ascontiguousarray(grid != 0).astype(numpy.uint8)
    works = {
        "scipy": lambda: ndimage.distance_transform_edt(grid, sampling=spacing),
        "edt": lambda: edt.edt(grid, anisotropy=spacing, black_border=False, parallel=1),
    }
    answers = {name: work() for name, work in works.items()}
    finite = numpy.isfinite(answers["edt"])
    difference = float(numpy.abs(answers["scipy"] - answers["edt"])[finite].max(initial=0.0))
    times = {name: [] for name in works}
    for _ in range(passes):
        for name, work in works.items():
            wall, cpu = time.perf_counter(), time.process_time()
            work()
            times[name].append((time.process_time() - cpu, time.perf_counter() - wall))
    versions = {"scipy": scipy.__version__, "edt": version("edt")}
    bits = {name: answer.dtype.name for name, answer in answers.items()}
    for name, pairs in times.items():
        cpu = sorted(pair[0] for pair in pairs)
        median = cpu[len(cpu) // 2]
        print(json.dumps({
            "bench": "transforms",
            "map": Path(path).stem.rsplit("-", 1)[0],
            "grid": Path(path).stem,
            "shape": list(grid.shape),
            "contender": name,
            "cpu_seconds": round(median, 6),
            "ns_per_voxel": round(median * 1e9 / grid.size, 3),
            "spread": round((cpu[-1] - cpu[0]) / median, 4),
            "passes": passes,
            "threads": 1,
            "bytes": answers[name].nbytes,
            "wall_seconds": round(sorted(pair[1] for pair in pairs)[len(pairs) // 2], 6),
            "against": {
                "computes": f"centre of a free voxel to the nearest centre of the surface's, {bits[name]}",
                "version": versions[name],
                "spacing": ",".join(map(str, spacing)),
                "largest_difference": f"{difference:.3g}",
            },
        }))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("grids", nargs="*", type=Path)
    parser.add_argument("--spacing", default="1,1,1", help="of voxels along z, y and x")
    parser.add_argument("--passes", type=int, default=5)
    parser.add_argument("--cache", type=Path, default=environment.default_cache())
    parser.add_argument("--job", choices=("grid", "measure"), help=argparse.SUPPRESS)
    options = parser.parse_args()
    spacing = [float(s) for s in options.spacing.split(",")]
    if options.job == "grid":
        return own_grid(options.grids[0])
    if options.job == "measure":
        for grid in options.grids:
            measured(grid, spacing, options.passes)
        return 0
    cache = options.cache.resolve()
    grids = [grid.resolve() for grid in options.grids]
    if not grids:
        grids = [cache / "maps" / "fbm-256x64.npy"]
        if not grids[0].exists():
            python = environment.python_of("pictures", cache)
            subprocess.run([python, __file__, "--job", "grid", grids[0]], check=True)
    usage = measure.run([environment.python_of("transforms", cache), __file__, "--job", "measure",
                         "--spacing", options.spacing, "--passes", options.passes, *grids],
                        environment={**environment.without_tuning(), "OMP_NUM_THREADS": "1"})
    print(usage.output, end="")
    return 0


if __name__ == "__main__":
    sys.exit(main())

"""Scenes of light and materials by rilievo and by Mitsuba 3: the same picture, and its price.

Each renders several passes of other seeds. Their means must agree. The error of a pass is its distance
from a long reference, the mean of a long render by each; CPU time goes as its inverse square for
independent samples, so that Mitsuba's time to rilievo's error follows. Preparation counts for both: for rilievo all that a frame of 8 x 8 pixels of one sample
takes, for Mitsuba from the files to the scene with its hierarchy, without the start of Python and
without compiling kernels. Prints one line of JSON a scene and variant.
"""

import argparse
import json
from pathlib import Path

import environment
import lit_scenes
import measure
import mitsuba_frame
import rilievo_frame


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenes", nargs="*", help="which; else all")
    parser.add_argument("--resolution", type=int, default=128)
    parser.add_argument("--samples", type=int, default=64, help="a pass")
    parser.add_argument("--passes", type=int, default=16)
    parser.add_argument("--reference", type=int, default=4096, help="samples of the long render by each; 0: those on disk")
    parser.add_argument("--variants", nargs="*", default=mitsuba_frame.VARIANTS)
    parser.add_argument("--program", help="rilievo; else it is built")
    parser.add_argument("--picture", type=Path, help="where to put the pictures side by side")
    parser.add_argument("--cache", type=Path, default=environment.default_cache())
    options = parser.parse_args()
    cache = options.cache.resolve()
    folder = cache / "lit"
    lit_scenes.prepare(folder)
    all_scenes = lit_scenes.scenes(folder)
    names = options.scenes or list(all_scenes)
    program = options.program or rilievo_frame.program()
    for name in names:
        ours = rilievo(program, name, all_scenes[name], folder, options)
        refer(program, name, folder, cache, options)
        for variant in options.variants:
            theirs = mitsuba(name, variant, folder, cache, options)
            said = environment.call("pictures", cache, "lit_compare.py", folder, name, variant)
            print(json.dumps(line(said, ours, theirs, options)), flush=True)
    if options.picture:
        environment.call("pictures", cache, "lit_compare.py", "side-by-side", folder,
                         options.picture.resolve(), 176, *names)


def rilievo(program, name, scene, folder, options):
    """CPU seconds of preparation and of a pass."""
    path = folder / f"{name}.toml"
    path.write_text(lit_scenes.scene_file(scene, folder, options.resolution))
    for old in folder.glob(f"{name}-rilievo-*.exr"):
        old.unlink()

    def render(out, *more):
        return measure.run([program, "render", path, "-o", out, "--quiet", *more]).cpu_seconds

    start = render(folder / f"{name}-start.exr", "--resolution", "8x8", "--samples", 1)
    seconds = [
        render(folder / f"{name}-rilievo-{seed:03}.exr", "--samples", options.samples, "--seed", seed)
        for seed in range(options.passes)
    ]
    return {"prepare": start, "pass": max(0.0, median(seconds) - start)}


def refer(program, name, folder, cache, options):
    """The long renders."""
    if options.reference == 0:
        return
    out = folder / f"{name}-reference.exr"
    measure.run([program, "render", folder / f"{name}.toml", "-o", out, "--quiet",
                 "--samples", options.reference, "--seed", 1 << 20])
    passes = max(1, options.reference // options.samples)
    called(name, "llvm_ad_rgb", folder, cache, options, passes, "mean")


def mitsuba(name, variant, folder, cache, options):
    """The same of Mitsuba."""
    said = called(name, variant, folder, cache, options, options.passes, "passes")
    # The first pass compiles.
    return {"prepare": said["prepare_cpu_seconds"], "pass": median(said["pass_cpu_seconds"][1:]),
            "version": said["version"]}


def called(name, variant, folder, cache, options, passes, kept):
    """What `lit_mitsuba.py` says."""
    surroundings = environment.without_tuning()
    if variant.startswith("llvm"):
        surroundings["DRJIT_LIBLLVM_PATH"] = mitsuba_frame.llvm()
    python = environment.python_of("mitsuba", cache)
    script = environment.HERE / "lit_mitsuba.py"
    usage = measure.run([python, script, name, variant, options.resolution, options.samples, passes,
                         folder, kept], environment=surroundings)
    return json.loads(usage.output.strip().splitlines()[-1])


def median(values):
    return sorted(values)[len(values) // 2]


def line(said, ours, theirs, options):
    """What was seen, and the times to rilievo's error."""
    more = (said["rmse_mitsuba"] / said["rmse_rilievo"]) ** 2
    own = ours["prepare"] + ours["pass"]
    other = theirs["prepare"] + more * theirs["pass"]
    return {
        "bench": "lit", **said, "version": theirs["version"],
        "resolution": options.resolution, "samples": options.samples, "passes": options.passes,
        "reference": options.reference,
        "prepare_rilievo": ours["prepare"], "pass_rilievo": ours["pass"],
        "prepare_mitsuba": theirs["prepare"], "pass_mitsuba": theirs["pass"],
        "cpu_seconds_rilievo": own, "cpu_seconds_mitsuba": other, "ratio": own / other,
    }


if __name__ == "__main__":
    main()

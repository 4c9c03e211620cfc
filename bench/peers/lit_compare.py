"""Compares the passes of a scene by rilievo and by Mitsuba. Runs in the environment `pictures`.

    lit_compare.py FOLDER SCENE VARIANT
    lit_compare.py side-by-side FOLDER OUT.png SIDE SCENE...

Prints one line of JSON: the means of both pictures and their relative difference, the share of pixels
that a Z-test accepts (Mitsuba's: significance 0.01 over all pixels, corrected as Sidak does), the root
mean square error of one pass of each against the reference, the mean of the long renders, and the same
by the spread of its passes.
"""

import json
import sys
from pathlib import Path
from statistics import NormalDist

import numpy
from PIL import Image

import picture


def rilievo(folder, scene):
    files = sorted(folder.glob(f"{scene}-rilievo-*.exr"))
    return numpy.stack([picture.linear(str(path)) for path in files])


def mitsuba(folder, scene, variant):
    return numpy.load(folder / f"{scene}-{variant}.npy").astype(numpy.float64)


def compare(folder, scene, variant):
    ours, theirs = rilievo(folder, scene), mitsuba(folder, scene, variant)
    means = [passes.mean() for passes in (ours, theirs)]
    spread = [passes.var(axis=0, ddof=1) for passes in (ours, theirs)]
    error = numpy.sqrt(spread[0] / len(ours) + spread[1] / len(theirs))
    difference = numpy.abs(ours.mean(axis=0) - theirs.mean(axis=0))
    # Where nothing is random, as on the lamp, numbers agree to single precision.
    error = numpy.maximum(error, 1e-6 * (1 + ours.mean(axis=0)))
    level = 1 - (1 - 0.01) ** (1 / difference[..., 0].size)
    bound = NormalDist().inv_cdf(1 - level / 2)
    accepted = (difference / error <= bound).mean()
    long = [picture.linear(str(folder / f"{scene}-reference.exr")), numpy.load(folder / f"{scene}-reference.npy")]
    reference = (long[0] + long[1]) / 2
    errors = [float(numpy.sqrt(((passes - reference) ** 2).mean())) for passes in (ours, theirs)]
    plain = (difference / error <= NormalDist().inv_cdf(0.995)).mean()
    return {
        "scene": scene, "variant": variant,
        "mean_rilievo": means[0], "mean_mitsuba": means[1],
        "relative_difference": means[0] / means[1] - 1,
        # Standard error of that difference.
        "difference_error": float(numpy.sqrt((error ** 2).sum()) / error.size / means[1]),
        "accepted": accepted, "within_99_percent": plain,
        "rmse_rilievo": errors[0], "rmse_mitsuba": errors[1],
        "spread_rilievo": float(numpy.sqrt(spread[0].mean())),
        "spread_mitsuba": float(numpy.sqrt(spread[1].mean())),
    }


def side_by_side(folder, out, side, scenes):
    """A row a scene: rilievo, Mitsuba, their difference ten times enlarged around grey."""
    rows = []
    for scene in scenes:
        ours = rilievo(folder, scene).mean(axis=0)
        theirs = mitsuba(folder, scene, "scalar_rgb").mean(axis=0)
        codes = [picture.display(image) for image in (ours, theirs)]
        codes.append(picture.display(0.2140 + 10 * (ours - theirs)))
        resized = [Image.fromarray(c).resize((side, side), Image.Resampling.LANCZOS) for c in codes]
        rows.append(numpy.concatenate([numpy.asarray(image) for image in resized], axis=1))
    Image.fromarray(numpy.concatenate(rows, axis=0)).save(out, optimize=True)


def main():
    if sys.argv[1] == "side-by-side":
        folder, out, side = Path(sys.argv[2]), sys.argv[3], int(sys.argv[4])
        side_by_side(folder, out, side, sys.argv[5:])
        print(json.dumps({"written": out}))
        return
    print(json.dumps(compare(Path(sys.argv[1]), *sys.argv[2:4])))


if __name__ == "__main__":
    main()

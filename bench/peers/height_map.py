"""Writes the fbm of rilievo, 8 octaves, seed 0, vertex lattice, as 16-bit grey PNG.

    height_map.py SIZE OUT.png

The formula is that of `crates/rilievo/src/map/procedural.rs`, operation by operation in f64, so the
codes are those of `procedural = "fbm", octaves = 8, seed = 0` of a scene file. Row 0 of the file is
v = 1. Runs in the environment `pictures`.
"""

import json
import math
import sys
from pathlib import Path

import numpy
from PIL import Image

OCTAVES = 8
BASE_FREQUENCY = 4
_QUARTER = [
    (1.0, 0.0),
    (0.9238795325112867, 0.3826834323650898),
    (math.sqrt(0.5), math.sqrt(0.5)),
    (0.3826834323650898, 0.9238795325112867),
]
#: The 16 directions of `gradient`, by the low four bits of the hash.
_DIRECTIONS = numpy.array(
    [
        [(x, y), (-y, x), (-x, -y), (y, -x)][turn]
        for turn in range(4)
        for x, y in _QUARTER
    ]
)


def mix(z):
    """The finaliser of SplitMix64, on arrays of uint64."""
    z = (z ^ (z >> numpy.uint64(30))) * numpy.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> numpy.uint64(27))) * numpy.uint64(0x94D049BB133111EB)
    return z ^ (z >> numpy.uint64(31))


def _fade(t):
    return t * t * t * (t * (t * 6.0 - 15.0) + 10.0)


def _noise(u, v, frequency, seed):
    """Gradient noise on the rectangle of the parameters `u` (columns) and `v` (rows)."""
    x, y = u * float(frequency), v * float(frequency)
    i, j = numpy.floor(x), numpy.floor(y)
    fx, fy = (x - i)[None, :], (y - j)[:, None]
    size = numpy.uint64(frequency)

    def corner(di, dj):
        ci = ((i.astype(numpy.uint64) + numpy.uint64(di)) % size)[None, :]
        cj = ((j.astype(numpy.uint64) + numpy.uint64(dj)) % size)[:, None]
        hashed = mix(seed ^ mix(ci ^ (cj << numpy.uint64(32))))
        direction = _DIRECTIONS[(hashed & numpy.uint64(15)).astype(numpy.intp)]
        return direction[..., 0] * (fx - di) + direction[..., 1] * (fy - dj)

    def lerp(a, b, t):
        return a + (b - a) * t

    low = lerp(corner(0, 0), corner(1, 0), _fade(fx))
    high = lerp(corner(0, 1), corner(1, 1), _fade(fx))
    return lerp(low, high, _fade(fy))


def fbm_codes(size, seed=0, band=64):
    """The codes of the map, row 0 at v = 0, made `band` rows at a time."""
    # A vertex lattice puts sample i at i / (n - 1).
    parameters = numpy.arange(size, dtype=numpy.float64) / float(size - 1)
    codes = numpy.empty((size, size), numpy.uint16)
    for first in range(0, size, band):
        v = parameters[first:first + band]
        total = numpy.zeros((len(v), size))
        most = 0.0
        for octave in range(OCTAVES):
            amplitude = 1.0 / float(1 << octave)
            # Arithmetic on Python's own integers: no warning where the product passes 2^64.
            start = numpy.uint64(seed ^ (octave * 0x9E3779B97F4A7C15) % (1 << 64))
            octave_seed = mix(numpy.array([start]))[0]
            total += amplitude * _noise(parameters, v, BASE_FREQUENCY << octave, octave_seed)
            most += amplitude
        heights = 0.5 + 0.5 * numpy.clip(total / (most * math.sqrt(0.5)), -1.0, 1.0)
        codes[first:first + band] = numpy.floor(heights * 65535.0 + 0.5).astype(numpy.uint16)
    return codes


def main():
    size, out = int(sys.argv[1]), Path(sys.argv[2])
    out.parent.mkdir(parents=True, exist_ok=True)
    part = out.with_suffix(".part")
    Image.fromarray(fbm_codes(size)[::-1]).save(part, format="PNG")
    part.replace(out)
    print(json.dumps({"map": str(out), "size": size}))


if __name__ == "__main__":
    main()

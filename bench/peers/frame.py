"""The frame that every peer renders: one relief, one camera, one area light.

The numbers stand here once. Axes are rilievo's: right-handed, z up, the relief over the unit square.
"""

import argparse
import json
from dataclasses import dataclass
from pathlib import Path

import environment

POSITION = (0.5, -0.225, 0.72)
LOOK_AT = (0.5, 0.337, 0.05)
#: Vertical, degrees; frames are square.
FOV = 40.0
#: Height of white over black, scene units.
DEPTH = 0.1
DIFFUSE = 0.7
#: The lamp is a horizontal square that looks down and shines from below only. It stands outside of
#: the picture.
LAMP_CENTER = (-0.6, 0.9, 0.8)
LAMP_SIDE = 0.5
#: W/(sr m^2), all three channels; chosen so that no pixel passes 1.
RADIANCE = 20.0
SEED = 0


@dataclass
class Job:
    """One frame as one peer is asked for it."""

    map: str
    size: int
    variant: str
    resolution: int
    samples: int
    bounces: int
    picture: str

    def to_json(self):
        return json.dumps(self.__dict__)

    @staticmethod
    def from_json(text):
        return Job(**json.loads(text))


def arguments(description, variants):
    """Reads the command line that all frame scripts share; gives it with the job it describes."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--map", type=Path, help="16-bit grey PNG, square; else the fbm of --size")
    parser.add_argument("--size", type=int, default=1024, help="samples of the fbm along each side")
    parser.add_argument("--variant", choices=variants, default=variants[0])
    parser.add_argument("--resolution", type=int, default=1024, help="pixels along each side")
    parser.add_argument("--samples", type=int, default=16, help="camera rays a pixel")
    parser.add_argument("--bounces", type=int, choices=(0, 1), default=1, help="diffuse bounces")
    parser.add_argument("--picture", type=Path, help="where to keep the picture")
    parser.add_argument("--cache", type=Path, default=environment.default_cache(),
                        help="folder for environments, maps and pictures")
    parser.add_argument("--job", help=argparse.SUPPRESS)
    return parser.parse_args()


def job_of(options, peer, extension):
    """The job the command line asks for; its map is made if it is not there."""
    cache = options.cache.resolve()
    if options.map:
        path = options.map.resolve()
        size = environment.call("pictures", cache, "picture.py", "size", path)["size"]
    else:
        size = options.size
        path = cache / "maps" / f"fbm-{size}.png"
        if not path.exists():
            environment.call("pictures", cache, "height_map.py", size, path)
    name = f"{peer}-{options.variant}-{path.stem}-{options.resolution}-{options.bounces}.{extension}"
    picture = options.picture.resolve() if options.picture else cache / "pictures" / name
    picture.parent.mkdir(parents=True, exist_ok=True)
    return Job(str(path), size, options.variant, options.resolution, options.samples,
               options.bounces, str(picture))


def report(options, peer, job, usage, details):
    """Prints the one line: what was asked, what it took, how bright the picture came out.

    `details` holds version, threads, prepare_cpu_seconds, render_cpu_seconds and what else the peer
    tells.
    """
    mean = environment.call("pictures", options.cache.resolve(), "picture.py", "mean", job.picture)
    line = {
        "bench": "frames",
        "peer": peer,
        "version": details.pop("version"),
        "variant": job.variant,
        "map": Path(job.map).stem.rsplit("-", 1)[0],
        "size": job.size,
        "resolution": job.resolution,
        "samples": job.samples,
        "bounces": job.bounces,
        "prepare_cpu_seconds": round(details.pop("prepare_cpu_seconds"), 3),
        "render_cpu_seconds": round(details.pop("render_cpu_seconds"), 3),
        "total_cpu_seconds": round(usage.cpu_seconds, 3),
        "wall_seconds": round(usage.wall_seconds, 3),
        "peak_rss_bytes": usage.peak_rss_bytes,
        "threads": details.pop("threads"),
        "mean_radiance": round(mean["mean"], 6),
        **details,
    }
    print(json.dumps(line))

"""The frame by POV-Ray's height_field. Prints one line of JSON.

What POV-Ray does not do here is said in README.md: no bounce; the smallest area light takes four
shadow rays; two triangles a cell. Variant `soft` has that light, variant `hard` a point in its
middle, one shadow ray a hit.
"""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import frame
import measure

VARIANTS = ["soft", "hard"]
#: Small against every distance here, so that POV-Ray's fading 2 / (1 + (d/FADE)^2) is 2 FADE^2 / d^2.
FADE = 0.001


def swapped(point):
    """POV-Ray's frame has y up and is left-handed: exchange y and z."""
    return "<{}, {}, {}>".format(point[0], point[2], point[1])


def scene_text(job):
    """The frame in POV-Ray's language."""
    area = frame.LAMP_SIDE ** 2
    # diffuse * colour * cos * fading is to be diffuse / pi * radiance * area * cos * cos / d^2.
    colour = frame.RADIANCE * area / (3.141592653589793 * 2.0 * FADE ** 2)
    below = (frame.LAMP_CENTER[0], frame.LAMP_CENTER[1], 0.0)
    # Four points jittered over steps of the whole axis each: half the side gives the lamp's extent.
    half = frame.LAMP_SIDE / 2
    lamp = f"""
  area_light <{half}, 0, 0>, <0, 0, {half}>, 2, 2
  jitter
  area_illumination on""" if job.variant == "soft" else ""
    return f"""#version 3.7;
global_settings {{ assumed_gamma 1.0 max_trace_level 2 ambient_light 0 }}
background {{ rgb 0 }}
camera {{
  perspective
  location {swapped(frame.POSITION)}
  right x
  up y
  angle {frame.FOV}
  look_at {swapped(frame.LOOK_AT)}
}}
light_source {{
  {swapped(frame.LAMP_CENTER)}
  rgb {colour}
  spotlight
  point_at {swapped(below)}
  radius 89.9
  falloff 89.9
  tightness 1{lamp}
  fade_distance {FADE}
  fade_power 2
}}
height_field {{
  png "{job.map}"
  scale <1, {frame.DEPTH}, 1>
  pigment {{ rgb 1 }}
  finish {{ ambient 0 diffuse {frame.DIFFUSE} specular 0 }}
}}
"""


def installed():
    """The program, from the system's packages if it is not there."""
    if not shutil.which("povray"):
        print("installing povray", file=sys.stderr)
        install = ["apt-get", "install", "-y", "--no-install-recommends", "povray"]
        subprocess.run(install, check=True, stdout=sys.stderr)
    return shutil.which("povray")


def cpu_of(phase, text):
    """CPU seconds of a phase, as POV-Ray reports them at its end."""
    found = re.search(phase + r" Time:.*?\(([\d.]+) seconds\)\s*using \d+ thread\(s\) with ([\d.]+) CPU",
                      text, re.DOTALL)
    return float(found.group(2)) if found else 0.0


def render(path, job):
    """Renders the job; gives what it used."""
    scene = Path(job.picture).with_suffix(".pov")
    scene.write_text(scene_text(job))
    side = round(job.samples ** 0.5)
    samples = ["+A0.0", "+AM1", f"+R{side}"] if side > 1 else ["-A"]
    return measure.run([
        path, f"+I{scene}", f"+O{job.picture}", f"+W{job.resolution}", f"+H{job.resolution}",
        "-D", "+FP16", "File_Gamma=1.0", "Jitter=On", *samples,
        f"+WT{measure.threads()}",
    ])


def main():
    options = frame.arguments(__doc__.splitlines()[0], VARIANTS)
    if options.bounces:
        print("POV-Ray renders without the bounce", file=sys.stderr)
        options.bounces = 0
    job = frame.job_of(options, "povray", "ppm")
    path = installed()
    usage = render(path, job)
    version = re.search(r"Persistence of Vision\S* Ray Tracer Version (\S+)", usage.errors)
    frame.report(options, "povray", job, usage, {
        "version": version.group(1) if version else "unknown",
        "threads": measure.threads(),
        "prepare_cpu_seconds": cpu_of("Parse", usage.errors),
        "render_cpu_seconds": cpu_of("Trace", usage.errors),
        "camera_rays": count("Rays", usage.errors),
        "shadow_rays": count("Shadow Ray Tests", usage.errors),
    })


def count(what, text):
    """A number of POV-Ray's statistics."""
    found = re.search(rf"^{what}:\s+(\d+)", text, re.MULTILINE)
    return int(found.group(1)) if found else None


if __name__ == "__main__":
    main()

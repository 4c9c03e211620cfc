"""The frame by rilievo, from the map's PNG: nothing is tessellated. Prints one line of JSON.

Preparation is what a frame of 8 x 8 pixels of one sample costs: start, decoding, bounds.
"""

import json
import subprocess
from pathlib import Path

import environment
import frame
import measure

#: Layouts of the bounds.
VARIANTS = ["default", "tiny"]


def scene_text(job):
    """The frame as a scene file of rilievo."""
    x, y, z = frame.LAMP_CENTER
    h = frame.LAMP_SIDE / 2
    # Corners in an order whose normal looks down.
    lamp = [[x - h, y - h, z], [x - h, y + h, z], [x + h, y + h, z], [x + h, y - h, z]]
    return f"""[camera]
position = {list(frame.POSITION)}
look_at = {list(frame.LOOK_AT)}
up = [0, 0, 1]
fov = {frame.FOV}
resolution = [{job.resolution}, {job.resolution}]

[render]
integrator = "distributed"
samples = {job.samples}
shadow_samples = 1
diffuse_samples = 1
max_depth = {job.bounces}
seed = {frame.SEED}

[maps.relief]
file = {json.dumps(job.map)}
grid = "vertex"
wrap = "clamp"
layout = "{job.variant}"

[materials.grey]
diffuse = {[frame.DIFFUSE] * 3}

[materials.lamp]
diffuse = [0, 0, 0]
emitted = {[frame.RADIANCE] * 3}

[[shapes]]
type = "quad"
corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
material = "grey"
displacement = {{ map = "relief", scale = {frame.DEPTH}, normals = "exact" }}

[[shapes]]
type = "quad"
corners = {lamp}
material = "lamp"
one_sided = true
"""


def program():
    """The released program, built from the sources at hand; cargo says where it lies."""
    done = subprocess.run(
        ["cargo", "build", "--release", "--locked", "--bin", "rilievo",
         "--message-format=json-render-diagnostics"],
        cwd=environment.repository(), check=True, stdout=subprocess.PIPE, text=True,
    )
    messages = (json.loads(line) for line in done.stdout.splitlines() if line.startswith("{"))
    found = [m["executable"] for m in messages if m.get("executable")]
    return found[-1]


def render(path, job, more=()):
    """Renders the job; gives what it used and the program's own report."""
    scene = Path(job.picture).with_suffix(".toml")
    scene.write_text(scene_text(job))
    usage = measure.run([path, "render", scene, "-o", job.picture, "--json", "--quiet", *more])
    return usage, json.loads(usage.output.strip().splitlines()[-1])


def main():
    options = frame.arguments(__doc__.splitlines()[0], VARIANTS)
    job = frame.job_of(options, "rilievo", "exr")
    path = program()
    small = frame.Job(**{**job.__dict__, "resolution": 8, "samples": 1,
                         "picture": job.picture.replace(".exr", "-start.exr")})
    start, _ = render(path, small)
    usage, said = render(path, job)
    version = measure.run([path, "--version"]).output.split()[-1]
    frame.report(options, "rilievo", job, usage, {
        "version": version,
        "threads": said.get("threads", measure.threads()),
        "prepare_cpu_seconds": start.cpu_seconds,
        "render_cpu_seconds": usage.cpu_seconds - start.cpu_seconds,
        "rays": said["rays"],
        "own_peak_rss_bytes": said["peak_rss_bytes"],
        "map_bytes": said["map_bytes"],
        "bounds_bytes": said["bounds_bytes"],
    })


if __name__ == "__main__":
    main()

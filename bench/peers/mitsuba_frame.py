"""The frame by Mitsuba 3, tessellated before with two triangles a cell. Prints one line of JSON.

Variants are Mitsuba's own. Preparation counts from the map's file to the scene with its hierarchy;
importing the package is part of the total only.
"""

import glob
import json
import os
import re
import shutil
import subprocess
import sys

import environment
import frame
import measure

VARIANTS = ["llvm_ad_rgb", "scalar_rgb"]


def job_done(job):
    """Renders in this process, with Mitsuba's Python. Gives the times of its parts."""
    import mitsuba
    import numpy

    mitsuba.set_variant(job.variant)
    imported = measure.own_cpu_seconds()
    scene = scene_of(mitsuba, numpy, job)
    prepared = measure.own_cpu_seconds()
    picture = mitsuba.render(scene, spp=job.samples, seed=frame.SEED)
    mitsuba.Bitmap(picture).write(job.picture)
    rendered = measure.own_cpu_seconds()
    return {
        "version": mitsuba.__version__,
        "threads": measure.threads(),
        "prepare_cpu_seconds": prepared - imported,
        "render_cpu_seconds": rendered - prepared,
        "import_cpu_seconds": round(imported, 3),
    }


def scene_of(mitsuba, numpy, job):
    """The scene, hierarchy built."""
    grey = {"type": "diffuse", "reflectance": {"type": "rgb", "value": [frame.DIFFUSE] * 3}}
    x, y, z = frame.LAMP_CENTER
    to_world = mitsuba.ScalarTransform4f()
    # Mitsuba's rectangle spans -1 to 1 and looks along +z: half the side, turned over.
    lamp = to_world.translate([x, y, z]).rotate([1, 0, 0], 180).scale(frame.LAMP_SIDE / 2)
    camera = to_world.look_at(list(frame.POSITION), list(frame.LOOK_AT), [0, 0, 1])
    return mitsuba.load_dict({
        "type": "scene",
        # Depth counts edges of a path: emission, direct light, one bounce.
        "integrator": {"type": "path", "max_depth": 2 + job.bounces, "rr_depth": 100},
        "sensor": {
            "type": "perspective",
            "fov": frame.FOV,
            "fov_axis": "y",
            "to_world": camera,
            "film": {
                "type": "hdrfilm",
                "width": job.resolution,
                "height": job.resolution,
                "pixel_format": "rgb",
                "component_format": "float32",
                "rfilter": {"type": "box"},
            },
            "sampler": {"type": "independent", "sample_count": job.samples},
        },
        "lamp": {
            "type": "rectangle",
            "to_world": lamp,
            "emitter": {"type": "area",
                        "radiance": {"type": "rgb", "value": [frame.RADIANCE] * 3}},
        },
        "relief": mesh_of(mitsuba, numpy, job, mitsuba.load_dict(grey)),
    })


def mesh_of(mitsuba, numpy, job, material):
    """The relief as triangles: no uv, no normals, the least Mitsuba can hold."""
    codes = numpy.array(mitsuba.Bitmap(job.map), copy=False)
    height, width = codes.shape[:2]
    positions = numpy.empty((height, width, 3), numpy.float32)
    positions[..., 0] = numpy.linspace(0.0, 1.0, width, dtype=numpy.float32)[None, :]
    # Row 0 of a file is v = 1.
    positions[..., 1] = numpy.linspace(1.0, 0.0, height, dtype=numpy.float32)[:, None]
    positions[..., 2] = codes.reshape(height, width) * numpy.float32(frame.DEPTH / 65535.0)
    first = (numpy.arange(height - 1, dtype=numpy.uint32)[:, None] * numpy.uint32(width)
             + numpy.arange(width - 1, dtype=numpy.uint32)[None, :])
    faces = numpy.empty((height - 1, width - 1, 2, 3), numpy.uint32)
    below = first + numpy.uint32(width)
    faces[..., 0, 0] = below
    faces[..., 0, 1] = below + numpy.uint32(1)
    faces[..., 0, 2] = first + numpy.uint32(1)
    faces[..., 1, 0] = below
    faces[..., 1, 1] = first + numpy.uint32(1)
    faces[..., 1, 2] = first
    properties = mitsuba.Properties()
    properties["bsdf"] = material
    properties["face_normals"] = True
    mesh = mitsuba.Mesh("relief", vertex_count=width * height,
                        face_count=2 * (width - 1) * (height - 1), props=properties,
                        has_vertex_normals=False, has_vertex_texcoords=False)
    parameters = mitsuba.traverse(mesh)
    parameters["vertex_positions"] = positions.ravel()
    parameters["faces"] = faces.ravel()
    parameters.update()
    return mesh


def llvm():
    """The newest LLVM of this system, from its packages if there is none that serves.

    LLVM 15 of Debian 12 dies on Mitsuba's kernels with AVX-512 ("Cannot select: fminimum").
    """
    if os.environ.get("DRJIT_LIBLLVM_PATH"):
        return os.environ["DRJIT_LIBLLVM_PATH"]
    found = installed_llvm()
    if not found and shutil.which("apt-get"):
        print("installing libllvm19", file=sys.stderr)
        install = ["apt-get", "install", "-y", "--no-install-recommends", "libllvm19"]
        subprocess.run(install, check=True, stdout=sys.stderr)
        found = installed_llvm()
    if not found:
        raise SystemExit("no libLLVM 17 or newer: install one or set DRJIT_LIBLLVM_PATH")
    return found


def installed_llvm():
    """Path of the newest libLLVM, 17 or newer, or nothing."""
    places = ["/usr/lib/*/libLLVM*.so*", "/usr/lib/llvm-*/lib/libLLVM*.so*", "/usr/lib64/libLLVM*.so*"]
    versions = []
    for path in (path for place in places for path in glob.glob(place)):
        number = re.search(r"libLLVM(?:-|\.so\.)(\d+)", path)
        if number and int(number.group(1)) >= 17:
            versions.append((int(number.group(1)), path))
    return max(versions)[1] if versions else None


def command(python, job):
    """What runs `job` as a process of its own."""
    return [python, __file__, "--variant", job.variant, "--job", job.to_json()]


def main():
    options = frame.arguments(__doc__.splitlines()[0], VARIANTS)
    if options.job:
        print(json.dumps(job_done(frame.Job.from_json(options.job))))
        return
    job = frame.job_of(options, "mitsuba", "exr")
    python = environment.python_of("mitsuba", options.cache.resolve())
    surroundings = environment.without_tuning()
    if job.variant.startswith("llvm"):
        surroundings["DRJIT_LIBLLVM_PATH"] = llvm()
        # Compiled kernels are kept on disk: a first, small frame fills that store.
        small = frame.Job(**{**job.__dict__, "resolution": 8, "picture": job.picture + ".small.exr"})
        measure.run(command(python, small), environment=surroundings)
    usage = measure.run(command(python, job), environment=surroundings)
    details = json.loads(usage.output.strip().splitlines()[-1])
    frame.report(options, "mitsuba", job, usage, details)


if __name__ == "__main__":
    sys.exit(main())

"""A scene of `lit_scenes.py` by Mitsuba 3, displaced shapes tessellated before, in several passes.

    lit_mitsuba.py SCENE VARIANT RESOLUTION SAMPLES PASSES FOLDER passes|mean

Writes the passes, or their mean alone, to FOLDER as one NumPy array and prints one line of JSON.
"""

import json
import math
import sys
from pathlib import Path

import lit_scenes
import measure


def main():
    name, variant, resolution, samples, passes, folder, kept = sys.argv[1:]
    resolution, samples, passes, folder = int(resolution), int(samples), int(passes), Path(folder)
    import mitsuba
    import numpy

    mitsuba.set_variant(variant)
    imported = measure.own_cpu_seconds()
    scene = load(mitsuba, numpy, lit_scenes.scenes(folder)[name], resolution)
    prepared = measure.own_cpu_seconds()
    # Seeds of the mean are none of the passes'.
    first = 0 if kept == "passes" else 1 << 20
    pictures, seconds, total = [], [], 0.0
    for seed in range(first, first + passes):
        begun = measure.own_cpu_seconds()
        picture = numpy.array(mitsuba.render(scene, spp=samples, seed=seed))
        seconds.append(measure.own_cpu_seconds() - begun)
        if kept == "passes":
            pictures.append(picture)
        else:
            total = total + picture.astype(numpy.float64)
    if kept == "passes":
        numpy.save(folder / f"{name}-{variant}.npy", numpy.stack(pictures))
    else:
        numpy.save(folder / f"{name}-reference.npy", total / passes)
    print(json.dumps({
        "version": mitsuba.__version__,
        "prepare_cpu_seconds": prepared - imported,
        "pass_cpu_seconds": seconds,
    }))


def load(mitsuba, numpy, scene, resolution):
    """The scene with its hierarchy built."""
    transform = mitsuba.ScalarTransform4f
    whole = {
        "type": "scene",
        # Depth counts edges of a path.
        "integrator": {"type": "path", "max_depth": scene.max_depth + 2},
        "sensor": {
            "type": "perspective", "fov": scene.fov, "fov_axis": "y",
            "to_world": transform().look_at(list(scene.position), list(scene.look_at), [0, 0, 1]),
            "film": {
                "type": "hdrfilm", "width": resolution, "height": resolution, "pixel_format": "rgb",
                "component_format": "float32", "rfilter": {"type": "box"},
            },
            "sampler": {"type": "independent"},
        },
    }
    for k, shape in enumerate(scene.shapes):
        whole[f"shape{k}"] = shape_of(mitsuba, numpy, shape, scene.materials)
    if scene.sky:
        # Its middle lies towards local +z, its top towards +y.
        turn = transform([[0, 0, 1, 0], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1]])
        whole["sky"] = {"type": "envmap", "bitmap": sky(mitsuba, numpy), "to_world": turn}
    return mitsuba.load_dict(whole)


def sky(mitsuba, numpy):
    """The sky at Mitsuba's own places: rows from pole to pole, columns at their centres."""
    width, height = lit_scenes.SKY, lit_scenes.SKY // 2 + 1
    pixels = numpy.empty((height, width, 3), numpy.float32)
    for j in range(height):
        polar = math.pi * j / (height - 1)
        for i in range(width):
            turn = -2 * math.pi * ((i + 0.5) / width - 0.5)
            level = math.sin(polar)
            pixels[j, i] = lit_scenes.sky(level * math.cos(turn), level * math.sin(turn), math.cos(polar))
    return mitsuba.Bitmap(pixels)


def rgb(value):
    return {"type": "rgb", "value": list(value)}


def material_of(mitsuba, numpy, name, materials):
    """The BSDF; both sides answer alike, as in rilievo."""
    material = materials[name]
    if "mix" in material:
        first, second = (material_of(mitsuba, numpy, part, materials) for part in material["mix"])
        return {"type": "blendbsdf", "weight": material["share"], "first": first, "second": second}
    if "conductor" in material:
        eta, k = material["conductor"]
        roughness = material["roughness"]
        alpha = squares(mitsuba, numpy, roughness) if isinstance(roughness, Path) else roughness ** 2
        inner = {"type": "roughconductor", "distribution": "ggx", "alpha": alpha, "eta": rgb(eta), "k": rgb(k)}
    elif "mirror" in material:
        # No Fresnel curve: the same share at every angle.
        inner = {"type": "conductor", "material": "none",
                 "specular_reflectance": rgb(material["mirror"])}
    elif "texture" in material:
        inner = {"type": "diffuse",
                 "reflectance": {"type": "bitmap", "filename": str(material["texture"])}}
    else:
        inner = {"type": "diffuse", "reflectance": rgb(material["diffuse"])}
    return {"type": "twosided", "bsdf": inner}


def squares(mitsuba, numpy, path):
    """An image of roughness as one of `alpha`, its square."""
    texels = numpy.array(mitsuba.Bitmap(str(path)), copy=False)
    most = 65535.0 if texels.dtype == numpy.uint16 else 255.0
    alpha = (texels.reshape(*texels.shape[:2], -1)[..., :1] / most) ** 2
    return {"type": "bitmap", "bitmap": mitsuba.Bitmap(alpha.astype(numpy.float32)), "raw": True}


def shape_of(mitsuba, numpy, shape, materials):
    material = materials[shape.material]
    bsdf = material_of(mitsuba, numpy, shape.material, materials)
    if shape.relief:
        u, v, heights = samples_of(mitsuba, numpy, shape.relief)
        grid = rectangle_points if shape.rectangle else sphere_points
        return mesh(mitsuba, numpy, grid(numpy, shape, u, v, heights), u, v, mitsuba.load_dict(bsdf))
    corner, a, b = (numpy.array(x, float) for x in shape.rectangle)
    normal = numpy.cross(a, b)
    matrix = numpy.eye(4)
    matrix[:3, 0], matrix[:3, 1] = a / 2, b / 2
    matrix[:3, 2], matrix[:3, 3] = normal / numpy.linalg.norm(normal), corner + (a + b) / 2
    made = {"type": "rectangle", "to_world": mitsuba.ScalarTransform4f(matrix), "bsdf": bsdf}
    if "emitted" in material:
        made["emitter"] = {"type": "area", "radiance": rgb(material["emitted"])}
    return made


def samples_of(mitsuba, numpy, relief):
    """Parameters of the samples along u and v, and offsets; row 0 is v = 0."""
    path, scale, zero, lattice = relief
    codes = numpy.array(mitsuba.Bitmap(str(path)), copy=False)
    codes = codes.reshape(codes.shape[:2])[::-1].astype(numpy.float64)
    most = 65535.0 if codes.max() > 255 else 255.0
    heights = scale * (codes / most - zero)
    rows, columns = heights.shape
    if lattice == "vertex":
        return numpy.linspace(0, 1, columns), numpy.linspace(0, 1, rows), heights
    # Samples at the centres of texels; the border lies in the middle between last and first.
    for axis in (0, 1):
        first, last = heights.take([0], axis), heights.take([-1], axis)
        heights = numpy.concatenate([(first + last) / 2, heights, (first + last) / 2], axis)
    places = [numpy.concatenate([[0], (numpy.arange(n) + 0.5) / n, [1]]) for n in (columns, rows)]
    return places[0], places[1], heights


def rectangle_points(numpy, shape, u, v, heights):
    corner, a, b = (numpy.array(x, float) for x in shape.rectangle)
    normal = numpy.cross(a, b)
    normal /= numpy.linalg.norm(normal)
    return corner + u[None, :, None] * a + v[:, None, None] * b + heights[..., None] * normal


def sphere_points(numpy, shape, u, v, heights):
    center, radius = shape.sphere
    turn, polar = 2 * numpy.pi * u[None, :], numpy.pi * (1 - v[:, None])
    level, ones = numpy.sin(polar), numpy.ones_like(turn)
    outwards = numpy.stack([level * numpy.cos(turn), level * numpy.sin(turn), numpy.cos(polar) * ones], -1)
    return numpy.array(center) + (radius + heights)[..., None] * outwards


def mesh(mitsuba, numpy, points, u, v, bsdf):
    """Two flat triangles a cell."""
    rows, columns = points.shape[:2]
    uvs = numpy.empty((rows, columns, 2), numpy.float32)
    # The top row of an image is v = 0 there.
    uvs[..., 0], uvs[..., 1] = u[None, :], 1 - v[:, None]
    first = numpy.arange(rows - 1)[:, None] * columns + numpy.arange(columns - 1)[None, :]
    faces = numpy.stack([
        numpy.stack([first, first + 1, first + columns + 1], -1),
        numpy.stack([first, first + columns + 1, first + columns], -1),
    ], 2).astype(numpy.uint32)
    properties = mitsuba.Properties()
    properties["bsdf"] = bsdf
    properties["face_normals"] = True
    made = mitsuba.Mesh("relief", vertex_count=rows * columns, face_count=faces.size // 3,
                        props=properties, has_vertex_normals=False, has_vertex_texcoords=True)
    parameters = mitsuba.traverse(made)
    parameters["vertex_positions"] = points.astype(numpy.float32).ravel()
    parameters["vertex_texcoords"] = uvs.ravel()
    parameters["faces"] = faces.ravel()
    parameters.update()
    return made


if __name__ == "__main__":
    main()

"""The frame by Blender's Cycles through its Python module. Prints one line of JSON.

Variant `adaptive` displaces a plane diced to one pixel at render time, `full` the same diced to one
quad a cell; `mesh` hands over a mesh of one quad a cell made with NumPy. Cycles dices and builds its
hierarchy inside of the render call, so preparation counts what comes before it.
"""

import json
import sys

import environment
import frame
import measure

VARIANTS = ["adaptive", "full", "mesh"]


def job_done(job):
    """Renders in this process, with Blender's Python. Gives the times of its parts."""
    import bpy

    imported = measure.own_cpu_seconds()
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    settings(scene, job)
    image = bpy.data.images.load(job.map)
    image.colorspace_settings.name = "Non-Color"
    if job.variant == "mesh":
        full_mesh(bpy, scene, image)
    else:
        modifier = diced_plane(bpy, scene, image)
        if job.variant == "full":
            modifier.adaptive_space = "OBJECT"
            # Half a cell to spare, or rounding makes one segment too many.
            modifier.adaptive_object_edge_length = 1.0 / (job.size - 1.5)
        else:
            modifier.adaptive_space = "PIXEL"
            modifier.adaptive_pixel_size = 1.0
    lamp(bpy, scene)
    camera(bpy, scene)
    prepared = measure.own_cpu_seconds()
    bpy.ops.render.render(write_still=True)
    rendered = measure.own_cpu_seconds()
    return {
        "version": bpy.app.version_string,
        "threads": measure.threads(),
        "prepare_cpu_seconds": prepared - imported,
        "render_cpu_seconds": rendered - prepared,
        "import_cpu_seconds": round(imported, 3),
    }


def settings(scene, job):
    """The path tracer's, with all that would do more or less work than asked for switched off."""
    scene.render.engine = "CYCLES"
    cycles = scene.cycles
    cycles.device = "CPU"
    cycles.samples = job.samples
    cycles.use_adaptive_sampling = False
    cycles.use_denoising = False
    cycles.seed = frame.SEED
    cycles.max_bounces = job.bounces
    cycles.diffuse_bounces = job.bounces
    cycles.caustics_reflective = False
    cycles.caustics_refractive = False
    cycles.sample_clamp_direct = 0.0
    cycles.sample_clamp_indirect = 0.0
    cycles.use_light_tree = False
    cycles.pixel_filter_type = "BOX"
    cycles.dicing_rate = 1.0
    cycles.max_subdivisions = 16
    scene.render.resolution_x = scene.render.resolution_y = job.resolution
    scene.render.resolution_percentage = 100
    scene.render.use_persistent_data = False
    scene.render.threads_mode = "AUTO"
    scene.render.use_compositing = False
    scene.render.use_sequencer = False
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_mode = "RGB"
    scene.render.image_settings.color_depth = "32"
    scene.render.filepath = job.picture


def grey(bpy):
    """The diffuse material; gives it with its nodes."""
    material = bpy.data.materials.new("grey")
    material.use_nodes = True
    nodes = material.node_tree.nodes
    nodes.clear()
    output = nodes.new("ShaderNodeOutputMaterial")
    diffuse = nodes.new("ShaderNodeBsdfDiffuse")
    diffuse.inputs["Color"].default_value = (*[frame.DIFFUSE] * 3, 1.0)
    diffuse.inputs["Roughness"].default_value = 0.0
    material.node_tree.links.new(diffuse.outputs["BSDF"], output.inputs["Surface"])
    return material, output


def diced_plane(bpy, scene, image):
    """One quad with a displacement shader, to be subdivided by Cycles; gives the modifier."""
    mesh = bpy.data.meshes.new("relief")
    mesh.from_pydata([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [], [(0, 1, 2, 3)])
    # Blender's samples sit in the middle of texels: the map's outermost lie on the border.
    low = [0.5 / n for n in image.size]
    corners = [(low[0], low[1]), (1 - low[0], low[1]), (1 - low[0], 1 - low[1]), (low[0], 1 - low[1])]
    layer = mesh.uv_layers.new(name="uv")
    for entry, uv in zip(layer.data, corners):
        entry.uv = uv
    material, output = grey(bpy)
    tree = material.node_tree
    texture = tree.nodes.new("ShaderNodeTexImage")
    texture.image = image
    texture.interpolation = "Linear"
    texture.extension = "EXTEND"
    displacement = tree.nodes.new("ShaderNodeDisplacement")
    displacement.inputs["Midlevel"].default_value = 0.0
    displacement.inputs["Scale"].default_value = frame.DEPTH
    tree.links.new(texture.outputs["Color"], displacement.inputs["Height"])
    tree.links.new(displacement.outputs["Displacement"], output.inputs["Displacement"])
    material.displacement_method = "DISPLACEMENT"
    mesh.materials.append(material)
    relief = bpy.data.objects.new("relief", mesh)
    scene.collection.objects.link(relief)
    modifier = relief.modifiers.new("dice", "SUBSURF")
    modifier.subdivision_type = "SIMPLE"
    modifier.use_adaptive_subdivision = True
    return modifier


def full_mesh(bpy, scene, image):
    """One quad a cell, flat shaded."""
    import numpy

    width, height = image.size
    pixels = numpy.empty(width * height * image.channels, numpy.float32)
    image.pixels.foreach_get(pixels)
    heights = pixels[::image.channels].copy()
    del pixels
    positions = numpy.empty((height, width, 3), numpy.float32)
    positions[..., 0] = numpy.linspace(0.0, 1.0, width, dtype=numpy.float32)[None, :]
    # Blender's images begin with their lowest row.
    positions[..., 1] = numpy.linspace(0.0, 1.0, height, dtype=numpy.float32)[:, None]
    positions[..., 2] = heights.reshape(height, width) * numpy.float32(frame.DEPTH)
    bpy.data.images.remove(image)
    cells = (width - 1) * (height - 1)
    first = (numpy.arange(height - 1, dtype=numpy.int32)[:, None] * numpy.int32(width)
             + numpy.arange(width - 1, dtype=numpy.int32)[None, :]).ravel()
    corners = numpy.empty((cells, 4), numpy.int32)
    for column, step in enumerate((0, 1, width + 1, width)):
        corners[:, column] = first + numpy.int32(step)
    mesh = bpy.data.meshes.new("relief")
    mesh.vertices.add(width * height)
    mesh.vertices.foreach_set("co", positions.ravel())
    mesh.loops.add(cells * 4)
    mesh.loops.foreach_set("vertex_index", corners.ravel())
    mesh.polygons.add(cells)
    mesh.polygons.foreach_set("loop_start", numpy.arange(0, cells * 4, 4, dtype=numpy.int32))
    mesh.update(calc_edges=True)
    mesh.shade_flat()
    material, _ = grey(bpy)
    mesh.materials.append(material)
    scene.collection.objects.link(bpy.data.objects.new("relief", mesh))


def lamp(bpy, scene):
    """The square lamp; Blender's looks down its -z already."""
    light = bpy.data.lights.new("lamp", "AREA")
    light.shape = "SQUARE"
    light.size = frame.LAMP_SIDE
    # Blender's lamps are given by power: radiance * area * pi.
    light.energy = frame.RADIANCE * frame.LAMP_SIDE ** 2 * 3.141592653589793
    # Next-event estimation alone: no ray finds the lamp by chance.
    light.cycles.use_multiple_importance_sampling = False
    shape = bpy.data.objects.new("lamp", light)
    shape.location = frame.LAMP_CENTER
    scene.collection.objects.link(shape)


def camera(bpy, scene):
    """The camera, square pixels."""
    from mathutils import Vector

    data = bpy.data.cameras.new("camera")
    data.sensor_fit = "VERTICAL"
    data.angle_y = frame.FOV * 3.141592653589793 / 180.0
    data.clip_start = 0.001
    shape = bpy.data.objects.new("camera", data)
    shape.location = frame.POSITION
    view = Vector(frame.LOOK_AT) - Vector(frame.POSITION)
    shape.rotation_euler = view.to_track_quat("-Z", "Y").to_euler()
    scene.collection.objects.link(shape)
    scene.camera = shape


def main():
    options = frame.arguments(__doc__.splitlines()[0], VARIANTS)
    if options.job:
        print("\n" + json.dumps(job_done(frame.Job.from_json(options.job))), flush=True)
        return
    job = frame.job_of(options, "cycles", "exr")
    python = environment.python_of("cycles", options.cache.resolve())
    usage = measure.run([python, __file__, "--variant", job.variant, "--job", job.to_json()],
                        environment=environment.without_tuning())
    lines = [line for line in usage.output.splitlines() if line.startswith("{")]
    frame.report(options, "cycles", job, usage, json.loads(lines[-1]))


if __name__ == "__main__":
    sys.exit(main())

"""Scenes of light and materials, described once for rilievo and for Mitsuba.

Axes are rilievo's: right-handed, z up. A scene is a `Scene`; `scenes()` names them all. What a relief is
made of lies in files that `prepare` writes, so that both read the same numbers.
"""

import json
import math
import struct
import zlib
from dataclasses import dataclass, field
from pathlib import Path

import environment

#: Texels of the sky along the horizon; half as many from pole to pole.
SKY = 256
#: Samples of the maps that are made here, along each side.
STUDS, HILLS = 1024, (512, 256)


@dataclass
class Shape:
    """A rectangle (corner and two edges, their order gives the front) or a sphere, perhaps displaced."""

    material: str
    rectangle: tuple = None
    sphere: tuple = None
    #: PNG of the heights, scale, zero, grid.
    relief: tuple = None


@dataclass
class Scene:
    """A scene as both render it."""

    position: tuple
    look_at: tuple
    fov: float
    max_depth: int
    #: By name: `diffuse` or `texture`, `mirror`, `conductor` (eta and k) with `roughness` (a number or an
    #: image), `emitted`; or `mix`, two other names, with `share`, that of the second.
    materials: dict
    shapes: list = field(default_factory=list)
    #: Whether the sky shines.
    sky: bool = False


def box(center, half, height, turn, material):
    """A box on the floor, without its bottom: five rectangles whose fronts look out."""
    (cx, cy), angle = center, math.radians(turn)
    cos, sin = math.cos(angle), math.sin(angle)

    def at(x, y, z):
        return (cx + cos * x - sin * y, cy + sin * x + cos * y, z)

    def side(a, b, c):
        return Shape(material, rectangle=(a, minus(b, a), minus(c, a)))

    low, high = -1.0, -1.0 + height
    h = half
    ring = [(-h, -h), (h, -h), (h, h), (-h, h)]
    sides = []
    for (x0, y0), (x1, y1) in zip(ring, ring[1:] + ring[:1]):
        sides.append(side(at(x0, y0, low), at(x1, y1, low), at(x0, y0, high)))
    sides.append(side(at(-h, -h, high), at(h, -h, high), at(-h, h, high)))
    return sides


def minus(a, b):
    return tuple(p - q for p, q in zip(a, b))


def walls(floor="white"):
    """The floor, the ceiling, the back and the sides of the cube [-1, 1]^3, open towards -y."""
    return [
        Shape(floor, rectangle=((-1, -1, -1), (2, 0, 0), (0, 2, 0))),
        Shape("white", rectangle=((-1, -1, 1), (0, 2, 0), (2, 0, 0))),
        Shape("white", rectangle=((-1, 1, -1), (2, 0, 0), (0, 0, 2))),
        Shape("red", rectangle=((-1, -1, -1), (0, 2, 0), (0, 0, 2))),
        Shape("green", rectangle=((1, -1, -1), (0, 0, 2), (0, 2, 0))),
        Shape("lamp", rectangle=((-0.3, -0.3, 0.99), (0, 0.6, 0), (0.6, 0, 0))),
    ]


PAINTS = {
    "white": {"diffuse": (0.73, 0.73, 0.73)},
    "red": {"diffuse": (0.63, 0.065, 0.05)},
    "green": {"diffuse": (0.14, 0.45, 0.09)},
    "lamp": {"diffuse": (0.0, 0.0, 0.0), "emitted": (12.0, 10.0, 7.0)},
}


#: Index of refraction for red, green and blue light, and extinction.
COPPER = ((0.2004, 0.9240, 1.1022), (3.9129, 2.4528, 2.1421))


def scenes(folder):
    """All scenes by name; their files lie in `folder`."""
    maps = environment.repository() / "scenes" / "maps"
    tiles = maps / "roofing-tiles"
    cornell = Scene(
        (0, -3.9, 0), (0, 0, 0), 39.0, 6, PAINTS,
        walls() + box((-0.33, 0.3), 0.3, 1.2, 17, "white") + box((0.35, -0.3), 0.3, 0.6, -18, "white"),
    )
    floor = Shape("metal", rectangle=((-1, -1, -1), (2, 0, 0), (0, 2, 0)),
                  relief=(folder / "studs.png", 0.08, 0.0, "vertex"))
    studs = Scene(
        (0, -3.9, 0), (0, 0, -0.1), 39.0, 6,
        {**PAINTS, "metal": {"conductor": COPPER, "roughness": 0.3}},
        [floor] + walls()[1:],
    )
    mirrors = Scene(
        studs.position, studs.look_at, studs.fov, studs.max_depth,
        {**PAINTS, "metal": {"mirror": (0.9, 0.8, 0.6)}}, studs.shapes,
    )
    ball = Scene(
        (0, -4, 1.2), (0, 0, 0), 32.0, 4, {"clay": {"diffuse": (0.7, 0.6, 0.5)}},
        [Shape("clay", sphere=((0, 0, 0), 0.9), relief=(folder / "hills.png", 0.2, 0.5, "vertex"))],
        sky=True,
    )
    set_ = Scene(
        (0.5, -0.55, 0.75), (0.5, 0.42, 0.0), 38.0, 4,
        {
            "clay": {"texture": tiles / "RoofingTiles009_1K_Color.png"},
            "glaze": {"conductor": COPPER, "roughness": tiles / "RoofingTiles009_1K_Roughness.png"},
            "tiles": {"mix": ("clay", "glaze"), "share": 0.3},
            "sun": {"diffuse": (0, 0, 0), "emitted": (60.0, 55.0, 45.0)},
        },
        [
            Shape("tiles", rectangle=((0, 0, 0), (1, 0, 0), (0, 1, 0)),
                  relief=(tiles / "RoofingTiles009_1K_Displacement.png", 0.04, 0.5, "texel")),
            Shape("sun", rectangle=((-1.9, 0.2, 1.1), (0, 0.7, 0), (0.4, 0, 0.6))),
        ],
        sky=True,
    )
    return {"cornell": cornell, "studs": studs, "mirrors": mirrors, "ball": ball, "tiles": set_}


def sky(x, y, z):
    """Radiance from a unit direction: blue above, brown below, and a soft sun."""
    up = 0.5 + 0.5 * z
    near = max(0.0, (0.6 * x - 0.5 * y + 0.6245 * z))
    sun = 60.0 * near ** 400
    return (0.15 + 0.35 * up + sun, 0.15 + 0.45 * up + 0.9 * sun, 0.12 + 0.78 * up + 0.7 * sun)


def stud(u, v):
    """Height of round studs, eight a side."""
    x, y = (8 * u) % 1.0 - 0.5, (8 * v) % 1.0 - 0.5
    t = min(1.0, max(0.0, (0.4 - math.hypot(x, y)) / 0.12))
    return t * t * (3 - 2 * t)


def hill(u, v):
    """Heights over a sphere: waves that close along the equator and rest at the poles."""
    calm = math.sin(math.pi * v) ** 2
    long, across = 2 * math.pi * u, 2 * math.pi * v
    wave = math.sin(6 * long) * math.sin(5 * across) + 0.5 * math.sin(14 * long + 3 * across)
    return 0.5 + 0.3 * calm * wave


def prepare(folder):
    """Writes the maps and rilievo's sky."""
    folder.mkdir(parents=True, exist_ok=True)
    grid = [[stud(i / (STUDS - 1), 1 - j / (STUDS - 1)) for i in range(STUDS)] for j in range(STUDS)]
    png(folder / "studs.png", grid)
    width, height = HILLS
    grid = [[hill(i / (width - 1), 1 - j / (height - 1)) for i in range(width)] for j in range(height)]
    png(folder / "hills.png", grid)
    values = []
    for j in range(SKY // 2):
        polar = math.pi * (1 - (j + 0.5) / (SKY // 2))
        for i in range(SKY):
            turn = -2 * math.pi * ((i + 0.5) / SKY - 0.5)
            level = math.sin(polar)
            values += sky(level * math.cos(turn), level * math.sin(turn), math.cos(polar))
    # The lowest row first.
    text = f"PF\n{SKY} {SKY // 2}\n-1.0\n".encode()
    (folder / "sky.pfm").write_bytes(text + struct.pack(f"<{len(values)}f", *values))


def png(path, rows):
    """A grey PNG of 16 bits."""
    def chunk(kind, data):
        return (struct.pack(">I", len(data)) + kind + data
                + struct.pack(">I", zlib.crc32(kind + data)))

    data = b"".join(
        b"\0" + struct.pack(f">{len(row)}H", *(round(65535 * h) for h in row)) for row in rows
    )
    head = struct.pack(">IIBBBBB", len(rows[0]), len(rows), 16, 0, 0, 0, 0)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head)
                     + chunk(b"IDAT", zlib.compress(data)) + chunk(b"IEND", b""))


def scene_file(scene, folder, resolution):
    """The scene as a scene file of rilievo."""
    lines = [
        "[camera]", f"position = {list(scene.position)}", f"look_at = {list(scene.look_at)}",
        f"fov = {scene.fov}", f"resolution = [{resolution}, {resolution}]",
        "[render]", 'integrator = "path"', f"max_depth = {scene.max_depth}",
    ]
    if scene.sky:
        lines += ["[environment]", f"file = {json.dumps(str(folder / 'sky.pfm'))}"]
    for name, material in scene.materials.items():
        lines.append(f"[materials.{name}]")
        for key, value in material.items():
            if key == "texture":
                lines.append(f"texture = {json.dumps(str(value))}")
            elif key == "mirror":
                lines += ["diffuse = [0, 0, 0]", f"reflective = {list(value)}"]
            elif key == "conductor":
                eta, k = value
                # Mitsuba puts back nothing of what several facets reflect.
                lines += ['model = "conductor"', f"eta = {list(eta)}", f"k = {list(k)}",
                          "compensate = false"]
            elif key == "mix":
                lines += ['model = "mix"', f"materials = {json.dumps(value)}"]
            elif isinstance(value, Path):
                lines.append(f"{key} = {json.dumps(str(value))}")
            elif isinstance(value, tuple):
                lines.append(f"{key} = {list(value)}")
            else:
                lines.append(f"{key} = {value}")
    maps = {}
    for shape in scene.shapes:
        body = [f'material = "{shape.material}"']
        if shape.rectangle:
            corner, u, v = shape.rectangle
            ends = [[corner[k] + a * u[k] + b * v[k] for k in range(3)]
                    for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))]
            body += ['type = "quad"', f"corners = {ends}"]
        else:
            center, radius = shape.sphere
            body += ['type = "sphere"', f"center = {list(center)}", f"radius = {radius}"]
        if shape.relief:
            path, scale, zero, grid = shape.relief
            name = maps.setdefault((path, grid), f"map{len(maps)}")
            body.append(f'displacement = {{ map = "{name}", scale = {scale}, zero = {zero}, '
                        'normals = "exact" }')
        lines += ["[[shapes]]"] + body
    for (path, grid), name in maps.items():
        wrap = "clamp" if grid == "vertex" else "repeat"
        lines += [f"[maps.{name}]", f"file = {json.dumps(str(path))}", f'grid = "{grid}"',
                  f'wrap = "{wrap}"']
    return "\n".join(lines) + "\n"

"""Looks at maps and pictures. Runs in the environment `pictures`.

    picture.py size MAP.png                       samples along a side of a square map
    picture.py mean PICTURE                       mean radiance over pixels and channels
    picture.py compare A B                        mean of each, mean and largest difference of 16 x 16 blocks
    picture.py variance PICTURE...                of a pixel over pictures of other seeds, on average
    picture.py side-by-side OUT.png SIDE PICTURE...
"""

import json
import sys

import numpy
import OpenEXR
from PIL import Image

Image.MAX_IMAGE_PIXELS = None


def linear(path):
    """Linear RGB, f64, top row first. A PPM holds linear codes (POV-Ray with File_Gamma 1)."""
    if path.endswith(".exr"):
        channels = OpenEXR.File(path).channels()
        for joined in ("RGB", "RGBA"):
            if joined in channels:
                return channels[joined].pixels[..., :3].astype(numpy.float64)
        for layer in ("", "Composite.Combined.", "ViewLayer.Combined."):
            if layer + "R" in channels:
                planes = [channels[layer + c].pixels for c in "RGB"]
                return numpy.stack(planes, axis=-1).astype(numpy.float64)
        raise SystemExit(f"{path}: no colour among {sorted(channels)}")
    if path.endswith(".ppm"):
        return ppm(path)
    raise SystemExit(f"{path}: neither .exr nor .ppm")


def ppm(path):
    """A binary PPM of 16-bit linear codes."""
    with open(path, "rb") as file:
        fields = []
        while len(fields) < 4:
            fields += file.readline().split(b"#")[0].split()
        kind, width, height, most = fields[0], *map(int, fields[1:])
        if kind != b"P6" or most != 65535:
            raise SystemExit(f"{path}: not a PPM of 16 bits a channel")
        codes = numpy.frombuffer(file.read(), ">u2")
    return codes.reshape(height, width, 3) / 65535.0


def blocks(image, side=16):
    """Means over blocks of `side` x `side` pixels: what is left when the noise is gone."""
    height, width = (n // side * side for n in image.shape[:2])
    grid = image[:height, :width].reshape(height // side, side, width // side, side, -1)
    return grid.mean(axis=(1, 3, 4))


def display(image):
    """8-bit sRGB codes."""
    x = numpy.clip(image, 0.0, 1.0)
    curve = numpy.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)
    return (curve * 255.0 + 0.5).astype(numpy.uint8)


def main():
    verb, *words = sys.argv[1:]
    if verb == "size":
        with Image.open(words[0]) as image:
            if image.width != image.height or not image.mode.startswith("I;16"):
                raise SystemExit(f"{words[0]}: not a square 16-bit grey PNG")
            print(json.dumps({"size": image.width}))
    elif verb == "mean":
        print(json.dumps({"mean": float(linear(words[0]).mean())}))
    elif verb == "variance":
        pictures = numpy.stack([linear(path) for path in words])
        print(json.dumps({"variance": float(pictures.var(axis=0, ddof=1).mean())}))
    elif verb == "compare":
        a, b = map(linear, words)
        difference = numpy.abs(blocks(a) - blocks(b))
        print(json.dumps({
            "means": [float(a.mean()), float(b.mean())],
            "blocks_mean_difference": float(difference.mean()),
            "blocks_largest_difference": float(difference.max()),
        }))
    elif verb == "side-by-side":
        out, side, *pictures = words
        shown = [Image.fromarray(display(linear(p))).resize((int(side),) * 2, Image.BOX)
                 for p in pictures]
        sheet = Image.new("RGB", ((int(side) + 4) * len(shown) - 4, int(side)), "white")
        for index, picture in enumerate(shown):
            sheet.paste(picture, (index * (int(side) + 4), 0))
        planes = sheet.split()
        grey = all(plane.tobytes() == planes[0].tobytes() for plane in planes)
        (planes[0] if grey else sheet).save(out, optimize=True)
        print(json.dumps({"written": out}))
    else:
        raise SystemExit(__doc__)


if __name__ == "__main__":
    main()

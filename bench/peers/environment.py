"""Virtual environments: each peer gets its own, made on first use.

Packages are named as their index names them; which index serves them is pip's own configuration.
"""

import json
import os
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent

#: What is installed for whom. One environment each, so that no peer's pins bind another.
PACKAGES = {
    "mitsuba": ["mitsuba", "numpy"],
    "cycles": ["bpy"],
    "transforms": ["numpy", "scipy", "edt"],
    "pictures": ["numpy", "OpenEXR", "pillow"],
}


def default_cache():
    """Where environments, maps and pictures go if the user names no other folder."""
    return HERE / ".venv"


def python_of(name, cache):
    """The interpreter of environment `name` under `cache`, made and filled if it is not there.

    Pip talks to standard error; standard output stays free for the one line of JSON.
    """
    folder = Path(cache) / name
    python = folder / "bin" / "python"
    complete = folder / "complete"
    packages = PACKAGES[name]
    if complete.exists() and json.loads(complete.read_text()) == packages:
        return python
    print(f"installing {', '.join(packages)} into {folder}", file=sys.stderr)
    subprocess.run([sys.executable, "-m", "venv", str(folder)], check=True, stdout=sys.stderr)
    install = [str(python), "-m", "pip", "install", "--quiet", *packages]
    subprocess.run(install, check=True, stdout=sys.stderr)
    complete.write_text(json.dumps(packages))
    return python


def call(name, cache, script, *words):
    """Runs a script of this folder in environment `name`; gives its last line of output, parsed."""
    command = [str(python_of(name, cache)), str(HERE / script), *map(str, words)]
    done = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True)
    return json.loads(done.stdout.strip().splitlines()[-1])


def repository():
    """The root of the repository that holds this folder."""
    return HERE.parent.parent


def without_tuning():
    """The environment of this process without what would change how a peer uses threads."""
    dropped = ("OMP_", "RAYON_", "MKL_", "OPENBLAS_", "PYTHONPATH")
    return {k: v for k, v in os.environ.items() if not k.startswith(dropped)}

"""Runs one program as a child and reads what the kernel counted for it.

CPU time is user and system of the child with all threads and all children it waited for, from its
start to its end; the peak of memory is the largest resident set of any one of them. Both come from
wait4, so the measured program needs no help and no instrument slows it.
"""

import os
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass


@dataclass
class Usage:
    """What a finished child used and said."""

    cpu_seconds: float
    wall_seconds: float
    peak_rss_bytes: int
    output: str
    errors: str


class Failed(Exception):
    """The child did not end with 0."""


def run(command, cwd=None, environment=None):
    """Runs `command` to its end.

    Raises Failed with the end of what it said. The child's resident set is at least that of this
    process when it forks, about 15 MiB: keep large objects out of the caller.
    """
    with tempfile.TemporaryFile("w+") as output, tempfile.TemporaryFile("w+") as errors:
        begun = time.perf_counter()
        child = subprocess.Popen(
            [str(word) for word in command], stdout=output, stderr=errors, stdin=subprocess.DEVNULL,
            cwd=cwd, env=environment,
        )
        try:
            _, status, usage = os.wait4(child.pid, 0)
        except BaseException:
            child.kill()
            child.wait()
            raise
        wall = time.perf_counter() - begun
        child.returncode = os.waitstatus_to_exitcode(status)
        output.seek(0)
        errors.seek(0)
        said, complained = output.read(), errors.read()
    if child.returncode != 0:
        tail = (said + complained)[-4000:]
        raise Failed(f"{' '.join(map(str, command))}: exit code {child.returncode}\n{tail}")
    # Linux counts kibibytes, macOS bytes.
    unit = 1 if sys.platform == "darwin" else 1024
    return Usage(usage.ru_utime + usage.ru_stime, wall, usage.ru_maxrss * unit, said, complained)


def own_cpu_seconds():
    """User and system time of this process so far, all threads."""
    times = os.times()
    return times.user + times.system


def threads():
    """How many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()

"""What the comparisons share: this program is run and timed, peers are looked for, tables are printed."""

import argparse
import importlib
import json
import math
import os
import resource
import subprocess
import time
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent


def parser(about):
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    out = argparse.ArgumentParser(description=about)
    out.add_argument("--program", default=str(target / "release/gonio-embree"), help="gonio-embree")
    out.add_argument("--quick", action="store_true", help="less work, larger errors: a minute or two")
    return out


def module(name):
    """A peer, or nothing and a message."""
    try:
        return importlib.import_module(name)
    except ImportError as missing:
        print(f"{name}: left out: {missing}\n", flush=True)


class Timed:
    """`with Timed() as t:` gives `t.wall` and `t.cpu` in seconds, processes that were waited for included."""

    def __enter__(self):
        self.start = time.perf_counter(), self.used()
        return self

    def __exit__(self, *_):
        self.wall, self.cpu = time.perf_counter() - self.start[0], self.used() - self.start[1]

    @staticmethod
    def used():
        usage = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
        return sum(u.ru_utime + u.ru_stime for u in usage)


@dataclass
class Measured:
    summary: dict
    wall: float
    cpu: float

    def __getattr__(self, name):
        return self.summary[name]


def measure(program, sample, options, result):
    """A measurement of a sample file; `options` as on the command line. What is lost is judged here, not there."""
    command = [program, "--sample", sample, "--json", "--quiet", "--max-lost", 1, "-o", result, *options]
    with Timed() as t:
        done = subprocess.run([str(c) for c in command], stdout=subprocess.PIPE)
    if done.returncode:
        raise SystemExit(f"{' '.join(str(c) for c in command)}: exit code {done.returncode}")
    return Measured(json.loads(done.stdout), t.wall, t.cpu)


def apart(a, b):
    """How many standard errors two (value, error) differ by."""
    return (a[0] - b[0]) / math.hypot(a[1], b[1])


def table(head, rows):
    print("| " + " | ".join(head) + " |")
    print("|---" + "|--:" * (len(head) - 1) + "|")
    for row in rows:
        print("| " + " | ".join(x if isinstance(x, str) else f"{x:.3g}" for x in row) + " |")
    print(flush=True)

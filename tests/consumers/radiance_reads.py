"""Radiance loads and evaluates exported BSDFs: radiance_reads.py PROGRAM FOLDER

FOLDER holds what `cargo test exports::` leaves in target/tmp/exports. Radiance may be long with a file it does not
like, so each is read in a process of its own."""

import json
import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pyradiance

PROGRAM, FOLDER = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve()
HOME = Path(pyradiance.__file__).parent
ENVIRONMENT = os.environ | {"PATH": f"{HOME / 'bin'}:{os.environ['PATH']}", "RAYPATH": f".:{HOME / 'lib'}"}
# Radiance perturbs values by 0.03 %.
CLOSE = 2e-3
failures = 0


def check(what, error, allowed=CLOSE):
    global failures
    failures += not error < allowed
    print(f"{'ok' if error < allowed else 'FAILED':<7}{what}: {error:.2e} (allowed {allowed:.1e})", flush=True)


def export(result, form, *more):
    path = FOLDER / f"{Path(result).stem}-{form}.xml"
    command = [PROGRAM, "export", FOLDER / result, "--to", form, "-o", path, "--quiet", *more]
    subprocess.run([str(c) for c in command], check=True)
    return path


def run(*command):
    """What a program of Radiance prints."""
    start = time.time()
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True, env=ENVIRONMENT, timeout=120)
    assert done.returncode == 0, f"{command}: {done.stderr}"
    if time.time() - start > 10:
        print(f"       {Path(command[0]).name} took {time.time() - start:.0f} s", flush=True)
    return done.stdout


QUERY = """
import json, sys
from pyradiance import bsdf
sd = bsdf.load_file(sys.argv[1])
print(json.dumps([[float(x) for x in bsdf.query(sd, *q)] for q in json.loads(sys.argv[2])]))
"""


def query(path, directions):
    """X, Y, Z for (theta_in, phi_in, theta_out, phi_out) in degrees, both away from the surface."""
    return np.array(json.loads(run(sys.executable, "-c", QUERY, path, json.dumps(directions))))


def lambert():
    for form in ("klems-full", "klems-half", "klems-quarter", "tensor-tree-3", "tensor-tree-4"):
        path = export("lambert.nc", form, "--wavelength", "560")
        truth = (0.2 + 0.1 * 160 / 300) / np.pi
        values = query(path, [[0, 0, 30, 50], [40, 20, 10, 200], [60, 300, 60, 10]])
        check(f"Lambert, {form}", np.abs(values[:, 1] / truth - 1).max())
        report = run("checkBSDF", path)
        kind = {"k": "Klems", "t": "Tensor"}[form[0]]
        assert "Pure_Lambertian" in report or kind in report, report

def tilted():
    """Facets that tilt towards +x, and transmission towards +y: front, back, and azimuths are told apart."""
    for form in ("klems-full", "tensor-tree-4"):
        path = export("tilted.nc", form, "--wavelength", "560")
        bright, dark, through, none = query(path, [[0, 0, 30, 0], [0, 0, 30, 180], [0, 0, 150, 90], [0, 0, 150, 270]])
        check(f"tilted facets, {form}: towards +x", abs(bright[1] / 3 - 1))
        check(f"tilted facets, {form}: towards -x", dark[1])
        check(f"transmission, {form}: towards +y", abs(through[1] / 0.5 - 1))
        check(f"transmission, {form}: towards -y", none[1])
    # The same light from below: the sample that was turned about x sends it to the mirror image.
    path = export("lambert.nc", "klems-full", "--wavelength", "560", "--back", str(FOLDER / "tilted.nc"))
    right, left, through = query(path, [[180, 0, 150, 0], [180, 0, 150, 180], [180, 0, 30, 270]])
    check("from below, towards +x", abs(right[1] / 3 - 1))
    check("from below, towards -x", left[1])
    check("from below, transmitted towards -y", abs(through[1] / 0.5 - 1))


def coloured():
    """Every element of the matrix, and the hemispherical sums, as Radiance sees them."""
    path = export("coloured.nc", "klems-full")
    table = {name: numbers for name, numbers in blocks(path)}
    y = table["Visible"].reshape(145, 145)
    grid = [(20.0, 0.0, 10.0, 135.0), (40.0, 45.0, 20.0, 90.0), (60.0, 90.0, 50.0, 15.0), (30.0, 0.0, 30.0, 180.0)]
    values = query(path, [list(g) for g in grid])
    ours = np.array([y[patch(to, po), patch(ti, pi + 180)] for ti, pi, to, po in grid])
    check("coloured, elements of the matrix", np.abs(values[:, 1] / ours - 1).max())
    report = run("checkBSDF", path)
    print("      ", " | ".join(line.strip() for line in report.splitlines()[:6]))
    assert "Klems_Full" in report, report
    tree = export("coloured.nc", "tensor-tree-3")
    klems = run("bsdf2klems", tree)
    assert "LBNL/Klems" in klems
    report = run("checkBSDF", tree)
    assert "Tree" in report, report
    # Colours come back of anisotropic trees; away from the specular part the sample has one colour everywhere.
    values = query(export("coloured.nc", "tensor-tree-4"), [[0, 0, 45, 0], [40, 0, 60, 90]])
    x, z = (table[name].reshape(145, 145)[patch(45, 0), 0] / y[patch(45, 0), 0] for name in ("CIE-X", "CIE-Z"))
    check("colours of a tree", max(np.abs(values[:, 0] / values[:, 1] / x - 1).max(), np.abs(values[:, 2] / values[:, 1] / z - 1).max()))


def blocks(path):
    """Names and numbers of the blocks of reflection."""
    for block in path.read_text().split("<WavelengthData>")[1:]:
        if "Reflection Back" in block:
            name = block.split('"Integral">')[1].split("<")[0]
            yield name, np.array(block.split("<ScatteringData>")[1].split("</")[0].replace(",", " ").split(), float)


RINGS = [(0, 1), (5, 8), (15, 16), (25, 20), (35, 24), (45, 24), (55, 24), (65, 16), (75, 12)]


def patch(theta, phi):
    """Number of the patch of Klems' full basis."""
    ring = max(i for i, (lower, _) in enumerate(RINGS) if theta >= lower)
    count = RINGS[ring][1]
    return sum(n for _, n in RINGS[:ring]) + round((phi % 360) / 360 * count) % count


lambert()
tilted()
coloured()
sys.exit(failures > 0)

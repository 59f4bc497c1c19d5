#!/usr/bin/env python3
"""Time per wavelength and polarization of film solvers on the same stacks, and how far they agree: see README.md."""

import argparse
import csv
import importlib
import json
import math
import os
import subprocess
import tempfile
import time
import warnings
from pathlib import Path

for threads in ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ[threads] = "1"

import numpy as np

ROOT = Path(__file__).resolve().parent.parent.parent
# As in benches/film.rs: high and low layers by turns in air, light from 30 degrees.
LAYERS = (1, 14, 100, 1000)
ABSORPTION = {"lossless": 0.0, "absorbing": 0.01}
WAVELENGTHS = np.linspace(400.0, 704.0, 20)
ANGLE = math.radians(30)


def stack(layers, k):
    """Indices with the media around, and thicknesses in nm."""
    high_low = [(2.0 + 1j * k, 74.0), (1.5 + 0j, 98.0)]
    inner = [high_low[i % 2] for i in range(layers)]
    return [1.0 + 0j, *(n for n, _ in inner), 1.0 + 0j], [d for _, d in inner]


# A peer solves a stack at all wavelengths and both polarizations: R and T, each [polarization, wavelength], and
# how many such stacks it solved at once. It is given a stack and returns the function to be timed.

def tmm(n, d):
    coh_tmm = importlib.import_module("tmm").coh_tmm
    thick = [math.inf, *d, math.inf]

    def run():
        out = [[coh_tmm(pol, n, thick, ANGLE, nm) for nm in WAVELENGTHS] for pol in "sp"]
        return [np.array([[o[x] for o in row] for row in out]) for x in "RT"]

    return run, 1


def tmm_fast_stacks(n, d, stacks):
    importlib.import_module("torch").set_num_threads(1)
    coh_tmm = importlib.import_module("tmm_fast").coh_tmm
    indices = np.broadcast_to(np.array(n)[None, :, None], (stacks, len(n), len(WAVELENGTHS))).copy()
    thick = np.broadcast_to(1e-9 * np.array([math.inf, *d, math.inf]), (stacks, len(n))).copy()

    def run():
        out = [coh_tmm(pol, indices, thick, np.array([ANGLE]), 1e-9 * WAVELENGTHS, device="cpu") for pol in "sp"]
        return [np.array([np.asarray(o[x])[0, 0] for o in out]) for x in "RT"]

    return run, stacks


def tmm_fast(n, d):
    return tmm_fast_stacks(n, d, 1)


def tmm_fast_batch(n, d):
    return tmm_fast_stacks(n, d, max(1, min(256, 25_600 // len(d))))


def moosh_structure(n, d):
    media = sorted(set(n), key=lambda x: (x.real, x.imag))
    moosh = importlib.import_module("PyMoosh")
    return moosh.Structure([x**2 for x in media], [media.index(x) for x in n], [0, *d, 0], verbose=False)


def moosh_spectrum(name):
    def peer(n, d):
        spectrum, structure = getattr(importlib.import_module("PyMoosh.vectorized"), name), moosh_structure(n, d)

        def run():
            both = [spectrum(structure, ANGLE, p, WAVELENGTHS[0], WAVELENGTHS[-1], len(WAVELENGTHS)) for p in (0, 1)]
            return [np.array([np.ravel(out[i]) for out in both]) for i in (3, 4)]

        return run, 1

    return peer


def moosh(n, d):
    coefficient, structure = importlib.import_module("PyMoosh").coefficient_S, moosh_structure(n, d)

    def run():
        out = np.array([[coefficient(structure, nm, ANGLE, p)[2:4] for nm in WAVELENGTHS] for p in (0, 1)]).real
        return [out[..., 0], out[..., 1]]

    return run, 1


PEERS = {"tmm, `coh_tmm`": tmm, "PyMoosh, `coefficient_S`": moosh,
         "PyMoosh, `spectrum_S`": moosh_spectrum("spectrum_S"), "PyMoosh, `spectrum_A`": moosh_spectrum("spectrum_A"),
         "tmm_fast, one stack": tmm_fast, "tmm_fast, up to 256 stacks at once": tmm_fast_batch}


def microseconds(run, stacks):
    """Per wavelength and polarization: the best of the runs that fit into half a second, five if two seconds allow."""
    times = []
    while sum(times) < 0.5 or len(times) < 5 and sum(times) < 2:
        start = time.perf_counter()
        run()
        times.append(time.perf_counter() - start)
    return 1e6 * min(times) / (2 * len(WAVELENGTHS) * stacks)


def our_times():
    """Microseconds by (name, layers)."""
    out = subprocess.run(["cargo", "bench", "-q", "--bench", "film", "--", "--csv"], cwd=ROOT, check=True,
                         stdout=subprocess.PIPE, text=True).stdout
    rows = csv.DictReader(out.splitlines())
    return {(r["name"], int(r["layers"])): float(r["ns_per_lambda_and_polarization"]) / 1e3 for r in rows}


def our_answers(program, n, d):
    """R and T as the peers give them."""
    pair = lambda x: [x.real, x.imag]
    cases = [{"id": f"{pol} {nm}", "pol": pol, "wavelength_nm": nm, "angle": {"kind": "angle_deg", "value": 30.0},
              "n_first": pair(n[0]), "n_last": pair(n[-1]), "layers": [[*pair(x), y] for x, y in zip(n[1:-1], d)],
              "repeat": 1} for pol in "sp" for nm in WAVELENGTHS.tolist()]
    with tempfile.NamedTemporaryFile("w", suffix=".json") as file:
        json.dump({"cases": cases}, file)
        file.flush()
        text = subprocess.run([program, "film", file.name, "--json"], check=True, stdout=subprocess.PIPE).stdout
    answers = json.loads(text)["cases"]
    return [np.array([a[x] for a in answers]).reshape(2, -1) for x in "RT"]


def installed():
    """The peers that are there."""
    there = {}
    for name, peer in PEERS.items():
        try:
            peer(*stack(1, 0.0))
            there[name] = peer
        except ImportError as missing:
            print(f"{name}: left out: {missing}\n")
    return there


def row(name, layers, solver, us, ours, differences):
    print(f"| {name} | {layers} | {solver} | {us:.3g} | {us / ours:.3g} | {' | '.join(differences)} |")


def difference(theirs, ours):
    largest = np.abs(theirs - ours).max()
    return f"{largest:.1e}" if largest < 1e-6 else f"disagrees: {largest:.0e}"


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    parser.add_argument("--program", default=str(target / "release/gonio-embree"))
    args = parser.parse_args()
    warnings.simplefilter("ignore")  # tmm says that it clamps opaque layers
    peers, times = installed(), our_times()
    print("| stack | layers | solver | µs per λ and polarization | ratio | largest ΔR | largest ΔT |")
    print("|---|--:|---|--:|--:|--:|--:|")
    for name, k in ABSORPTION.items():
        for layers in LAYERS:
            n, d = stack(layers, k)
            ours, exact = times[name, layers], our_answers(args.program, n, d)
            row(name, layers, "this program", ours, ours, ["", ""])
            for solver, peer in peers.items():
                run, stacks = peer(n, d)
                differences = [difference(x, y) for x, y in zip(run(), exact)]
                row(name, layers, solver, microseconds(run, stacks), ours, differences)


if __name__ == "__main__":
    main()

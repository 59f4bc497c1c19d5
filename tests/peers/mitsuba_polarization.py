#!/usr/bin/env python3
"""Polarized transport, by the program and by Mitsuba 3, on samples nobody has seen.

    python3 -m venv /tmp/venv && /tmp/venv/bin/pip install -r tests/peers/requirements-mitsuba.txt
    /tmp/venv/bin/python tests/peers/mitsuba_polarization.py target/release/gonio-embree --seed 1

Mitsuba needs LLVM 17 or newer at run time (`apt-get install libllvm19`). First its own part is held against Maxwell's
equations; then the whole Mueller matrix of the BSDF is compared, facet by facet and element by element, on spheres,
plates, clusters of spheres, a pebble and a rhomb of glass. Without a program only the first part is done. Exit code 1:
something is wrong.

All tests together raise a false alarm with a probability of about 1e-3: half of it for the largest difference of all
numbers compared (Bonferroni), half for sums of squares over the facets, per element and sample.
"""

import argparse
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from scipy import stats

import mitsuba_truth
from geodesic import Dome
from mitsuba_goniometer import build
from polarization_cases import all_cases
from polarization_tests import FEWEST_TREES, Own, compare, plain_score, tally

FALSE_ALARM = 1e-3
LEVEL = 3
BATCHES = 32
# From so many trees on the mean of the squares of Student's t is what it should be; the tail is with fewer.
MANY_TREES = 200
# Largest share of the light that Mitsuba may lose.
LOST = 1e-5


def check_mitsuba(seed):
    """Mitsuba's part against truth; says whether it is right."""
    rng = np.random.default_rng(seed)
    fine = True
    print("Mitsuba and Maxwell's equations:")
    for kind, error in mitsuba_truth.interfaces(rng).items():
        print(f"    {kind:<26} largest error {error:.1e}")
        fine &= error < mitsuba_truth.SINGLE
    for name, make in (("crossed plates", mitsuba_truth.crossed_plates), ("rhomb", mitsuba_truth.retarder)):
        error, score = mitsuba_truth.straight_beam(make, rng)
        print(f"    {name:<26} largest error {error:.1e}, {score:.1f} SE")
        fine &= score < stats.norm.isf(FALSE_ALARM / 64)
    return fine


def run_program(options, case, folder):
    """The result file of the program."""
    result = folder / f"{case.name}.nc"
    theta, phi = case.incidence
    command = [options.program, "--sample", case.write(folder), "-o", result, "--quiet", "--polarization", "mueller"]
    command += ["--incident", theta, "--azimuth", phi, "--wavelengths", 550, "--effects", "all"]
    command += ["--dome-level", LEVEL, "--trees", options.trees, "--seed", options.seed]
    subprocess.run([str(c) for c in command], check=True, stdout=subprocess.DEVNULL)
    return result


def measure(case, options, dome):
    """By both."""
    print(f"{case.name}: θ {case.incidence[0]:.1f}°, φ {case.incidence[1]:.1f}°, index {case.index:.3f}")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        start = time.time()
        body = build(case.shapes(folder), case.index)
        mitsuba = tally(body, case, dome, options.rays // BATCHES, BATCHES, options.seed)
        middle = time.time()
        own = Own.read(run_program(options, case, folder), dome)
    print(f"    Mitsuba {middle - start:.0f} s, caught {mitsuba.caught:.1e}, broken {mitsuba.broken:.1e};", end=" ")
    print(f"program {time.time() - middle:.0f} s, lost {own.lost:.1e}")
    return own, mitsuba


def describe(own, mitsuba, scores, dome):
    """A line per kind of number, and what transport without polarization would give."""
    for name, score in scores.items():
        print(f"    {name:<26} {score.t.size:6} numbers, largest difference {np.abs(score.t).max():5.2f} SE")
        if name in own.sides:
            values = *own.sides[name], *mitsuba.side(name, dome)
            print("        {:.6f} ±{:.6f}, Mitsuba {:.6f} ±{:.6f}".format(*values))
    change, error, largest = plain_score(own, mitsuba, dome)
    print(f"    without polarization       reflectance {change:+.2%} ±{error:.2%}, largest difference {largest:.1f} SE")


def squares(own, scores):
    """Chances of the sums of squares over the facets, per element."""
    many = own.trees[own.trees >= FEWEST_TREES] >= MANY_TREES
    if many.sum() < 4:
        return np.ones(0)
    all_squares = scores["facets"].squares()[many]
    print(f"    mean squares of {many.sum()} facets, by element:")
    for row in all_squares.mean(0):
        print("        " + "  ".join(f"{x:5.2f}" for x in row))
    return stats.chi2.sf(all_squares.sum(0), many.sum()).ravel()


def verdict(name, chances):
    """Whether the rarest of these is chance."""
    chances = np.concatenate(chances)
    allowed = FALSE_ALARM / 2 / len(chances)
    print(f"rarest {name} of {len(chances)}: chance {chances.min():.1e}, alarm below {allowed:.1e}")
    return chances.min() > allowed


def compare_all(options):
    """The program and Mitsuba on all samples; says whether they agree."""
    dome, fine = Dome(LEVEL), True
    numbers, sums = [], []
    for case in all_cases(options.seed):
        if options.only and options.only not in case.name:
            continue
        own, mitsuba = measure(case, options, dome)
        scores = compare(own, mitsuba, dome)
        describe(own, mitsuba, scores, dome)
        numbers += [score.chances().ravel() for score in scores.values()]
        sums.append(squares(own, scores))
        fine &= max(mitsuba.caught, mitsuba.broken) < LOST
    return verdict("difference", numbers) & verdict("sum of squares", sums) & fine


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", nargs="?", type=Path, help="gonio-embree")
    parser.add_argument("--seed", type=int, default=1, help="of the samples and of all random numbers")
    parser.add_argument("--rays", type=int, default=9_600_000, help="of Mitsuba, per sample")
    parser.add_argument("--trees", type=int, default=2_000_000, help="of the program, per sample")
    parser.add_argument("--only", help="samples with this in their name")
    options = parser.parse_args()
    fine = check_mitsuba(options.seed)
    if options.program:
        fine &= compare_all(options)
    print("all is well" if fine else "SOMETHING IS WRONG")
    return 0 if fine else 1


if __name__ == "__main__":
    sys.exit(main())

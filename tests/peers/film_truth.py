#!/usr/bin/env python3
"""Film stacks nobody has seen, with their true amplitudes, and a judge of the program.

    python3 -m venv /tmp/venv && /tmp/venv/bin/pip install -r tests/peers/requirements.txt
    /tmp/venv/bin/python tests/peers/film_truth.py --seed 1 --count 500 -o unseen.json
    /tmp/venv/bin/python tests/peers/film_truth.py unseen.json --check target/release/gonio-embree

Truth comes from the two formulations of `formulations.py`, which must agree to 45 digits. Before anything else, all
cases of tests/reference/films.json are computed anew from their inputs and must agree with the truth in that file.
"""

import argparse
import json
import random
import subprocess
import sys
import tempfile
from multiprocessing import Pool
from pathlib import Path

from mpmath import mp, mpc, mpf, nstr

import film_cases
from formulations import AMPLITUDES, Stack, abeles, scattering

REFERENCE = Path(__file__).resolve().parent.parent / "reference/films.json"
ULP = mpf(2) ** -53


def truth(case):
    """Amplitudes at 45 digits or better, and to how many digits two formulations agree."""
    stack = Stack.read(case)
    for digits in (70, 200, 600, 2000):
        with mp.workdps(digits + 20):
            one, two = abeles(stack, digits), scattering(stack, digits + 17)
            agreed = min(digits_of_agreement(one[name], two[name], digits) for name in AMPLITUDES)
            if agreed >= 45:
                return one, agreed
    raise ArithmeticError(f"{case['id']}: the formulations agree to {agreed:.1f} digits only")


def digits_of_agreement(a, b, digits):
    """Of two complex numbers; what is less than a rounding error of 1 in both is 0, which rounding alone does not
    tell from the tiny until there are 200 digits."""
    size = max(abs(a), abs(b))
    if a == b or digits >= 200 and size < mpf(10) ** (20 - digits):
        return float(digits)
    return float(-mp.log10(abs(a - b) / size))


def noise(case, draws=None, seed=0):
    """The largest change of each amplitude when all numbers of the input move by a relative 2^-53 up or down:
    each layer on its own up to 300 layers; above, all repetitions together."""
    rng = random.Random(f"{case['id']} {seed}")
    stack = Stack.read(case)
    many = len(case["layers"]) * case["repeat"] > 300
    if not many:
        stack = stack.unrolled()
    worst = dict.fromkeys(AMPLITUDES, mpf(0))
    with mp.workdps(70):
        exact = abeles(stack, 50)
        for _ in range(draws or (3 if many else 8)):
            moved = abeles(stack.moved(lambda x: x * (1 + rng.choice((-1, 1)) * ULP)), 50)
            for name in AMPLITUDES:
                worst[name] = max(worst[name], abs(moved[name] - exact[name]))
    return worst


def solve(case):
    """A copy of the case with its truth."""
    amplitudes, agreed = truth(case)
    with mp.workdps(60):
        shares = Stack.read(case).shares(amplitudes)
        text = lambda x: nstr(x, 40, min_fixed=0, max_fixed=0)
        known = {name: [text(amplitudes[name].real), text(amplitudes[name].imag)] for name in AMPLITUDES}
        known |= {name: None if x is None else text(x) for name, x in shares.items()}
        moves = {name: float(nstr(x, 3)) for name, x in noise(case).items()}
    return case | known | {"noise_1ulp": moves, "agree_digits": round(agreed, 1)}


def complex_of(pair):
    return mpc(mpf(str(pair[0])), mpf(str(pair[1])))


def prove_one(case):
    """Digits that agree with a stored truth of 40 digits, and how the noise compares."""
    with mp.workdps(60):
        amplitudes, _ = truth(case)
        digits = min(digits_of_agreement(amplitudes[a], complex_of(case[a]), 40) if case[a] != ["0", "0"]
                     else -float(mp.log10(max(abs(amplitudes[a]), mpf(10) ** -40))) for a in AMPLITUDES)
        mine, stored = noise(case), case["noise_1ulp"]
        return digits, [float(mine[a] / mpf(stored[a])) for a in AMPLITUDES if stored[a] > 1e-18]


def prove(pool):
    """All cases of the reference from their inputs alone."""
    cases = json.loads(REFERENCE.read_text())["cases"]
    results = pool.map(prove_one, cases, chunksize=1)
    worst, which = min((r[0], c["name"]) for r, c in zip(results, cases))
    ratios = sorted(x for r in results for x in r[1])
    print(f"reference: {len(cases)} cases agree to at least {worst:.1f} digits ({which}); noise over that of the "
          f"file: median {ratios[len(ratios) // 2]:.2f}, {ratios[0]:.2f} to {ratios[-1]:.2f}")
    if worst < 30:
        sys.exit("the reference is not reproduced to 30 digits")


def answers(program, cases):
    """What the program says; None where it refuses."""
    with tempfile.NamedTemporaryFile("w", suffix=".json") as file:
        json.dump({"schema": "gonio-films-1", "cases": cases}, file)
        file.flush()
        run = subprocess.run([program, "film", file.name, "--json"], capture_output=True, text=True, check=False)
    if run.returncode == 0:
        return json.loads(run.stdout)["cases"]
    if len(cases) == 1:
        print(f"exit code {run.returncode}: {run.stderr.strip()}")
        return [None]
    # One refused case refuses the file: look for it.
    half = len(cases) // 2
    return answers(program, cases[:half]) + answers(program, cases[half:])


def allowance(size, noise):
    """What a solver in double precision may be wrong by."""
    return 4 * mpf(noise) + mpf("2e-15") * max(1, size)


def judge(case, answer):
    """Per amplitude the error as a fraction of the allowance; a NaN, or no answer, is infinitely wrong."""
    fractions = {}
    for name in AMPLITUDES:
        exact, got = complex_of(case[name]), answer[name] if answer else [None]
        finite = all(isinstance(x, (int, float)) and abs(x) < float("inf") for x in got)
        error = abs(mpc(*got) - exact) if finite else mpf("inf")
        fractions[name] = float(error / allowance(abs(exact), case["noise_1ulp"][name]))
    return fractions


def share_error(case, answer):
    """The largest error of R and T of either side; infinite where only one says that there is none."""
    def error(name):
        if answer is None:
            return float("inf")
        if case[name] is None or answer[name] is None:
            return 0.0 if case[name] == answer[name] else float("inf")
        return float(abs(mpf(case[name]) - mpf(answer[name])))
    return max(error(name) for name in ("R", "T", "R_back", "T_back", "A"))


def again(case, fractions):
    """The fractions that are left when the noise is that of 64 draws: 8 may all have missed the worst."""
    many = noise(case, draws=64, seed=1)
    scale = lambda a: (allowance(abs(complex_of(case[a])), case["noise_1ulp"][a])
                       / allowance(abs(complex_of(case[a])), max(many[a], mpf(case["noise_1ulp"][a]))))
    return {a: float(x * scale(a)) for a, x in fractions.items()}


def check(program, cases, failures_to):
    """Prints the worst fraction of the allowance per class; writes what fails."""
    classes, failures = {}, []
    for case, answer in zip(cases, answers(program, cases), strict=True):
        fractions = judge(case, answer)
        new = {"cases": 0, "worst": 0.0, "id": "", "failed": 0, "sure": 0, "share": 0.0}
        row = classes.setdefault(case["cls"], new)
        row["cases"] += 1
        row["share"] = max(row["share"], share_error(case, answer))
        worst = max(fractions.values())
        if worst >= row["worst"]:
            row |= {"worst": worst, "id": case["id"]}
        if worst > 1:
            still = again(case, fractions)
            row["failed"] += 1
            row["sure"] += max(still.values()) > 1
            failures.append(case | {"got": answer, "fraction": fractions, "fraction_of_64_draws": still})
    report(classes)
    if failures_to:
        Path(failures_to).write_text(json.dumps({"schema": "gonio-films-1", "cases": failures}, indent=1))
    return len(failures)


def report(classes):
    print(f"{'class':26} {'cases':>6} {'worst/allowed':>14} {'failed':>7} {'64 draws':>9} {'R,T error':>10}  worst")
    for name, row in sorted(classes.items()):
        print(f"{name:26} {row['cases']:6} {row['worst']:14.3g} {row['failed']:7} {row['sure']:9} {row['share']:10.2g}"
              f"  {row['id']}")
    total = lambda key: sum(row[key] for row in classes.values())
    print(f"{'all':26} {total('cases'):6} {max(r['worst'] for r in classes.values()):14.3g} {total('failed'):7}"
          f" {total('sure'):9}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", nargs="?", help="cases with their truth; made anew if not given")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=500)
    parser.add_argument("-o", "--output", help="where to write the cases with their truth")
    parser.add_argument("--check", metavar="PROGRAM", help="the program to judge")
    parser.add_argument("--failures", metavar="FILE", help="where to write the cases that fail")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--no-proof", action="store_true", help="leave out the reference")
    args = parser.parse_args()
    with Pool(args.jobs) as pool:
        if not args.no_proof:
            prove(pool)
        if args.file:
            cases = json.loads(Path(args.file).read_text())["cases"]
        else:
            cases = pool.map(solve, film_cases.make(args.seed, args.count), chunksize=1)
    if args.output:
        text = {"schema": "gonio-films-1", "set": f"seed {args.seed}", "cases": cases}
        Path(args.output).write_text(json.dumps(text, indent=1))
    if args.check and check(args.check, cases, args.failures):
        sys.exit(1)


if __name__ == "__main__":
    main()

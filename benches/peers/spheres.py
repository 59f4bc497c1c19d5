#!/usr/bin/env python3
"""Paths and segments per second of Mitsuba 3 and this program in the same 14,000 glass spheres: see README.md."""

import os

for threads in ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ[threads] = "1"

import math
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

import numpy as np

from beside import ROOT, Timed, apart, measure, module, parser, table

INDEX, MATRICES = 1.5, (1.33, 1.52)
RADIUS, COUNT, SIZE = 1.0077, 14_000, (100, 100, 20)
# Light falls on the middle of the slab: this wide to time, and this wide, too, to compare.
FOOTPRINT, NARROW = 64, 10
DEPTH = 64
VARIANTS = ("scalar_spectral", "scalar_spectral_polarized", "llvm_ad_spectral", "llvm_ad_spectral_polarized")


def packing(program, folder):
    """Centres of spheres that do not overlap, and the same ones as objects of a sample file."""
    path = folder / "packing.toml"
    size = ",".join(map(str, SIZE))
    command = [program, "generate", "packing", "--radius", RADIUS, "--count", COUNT, "--size", size, "--medium",
               f"glass={INDEX}", "--explode", "-o", path]
    subprocess.run([str(c) for c in command], check=True, stderr=subprocess.DEVNULL)
    text = path.read_text()
    centres = np.array([o["center"] for o in tomllib.loads(text)["object"]])
    return centres, text[text.index("[[object]]"):]


def sample(folder, objects, matrix, sides, footprint=FOOTPRINT):
    patch = [footprint, footprint] if sides == "open" else list(SIZE[:2])
    path = folder / f"{sides}-{footprint}-{matrix}.toml"
    path.write_text(f'[sample]\nabove = "matrix"\nbelow = "matrix"\npatch = {{ size = {patch}, sides = "{sides}" }}\n'
                    f"[media]\nmatrix = {matrix}\nglass = {INDEX}\n{objects}")
    return path


def ours(program, path, trees, wavelengths, polarized):
    """Trees, segments, seconds, and the reflected light with its error."""
    options = ["--wavelengths", "550" if wavelengths == 1 else f"{550 - 5 * (wavelengths - 1)}:550:5", "--depth", DEPTH,
               "--threads", 1, "--trees", trees, "--effects", f"auto,{'+' if polarized else '-'}polarization"]
    m = measure(program, path, options, path.with_suffix(".nc"))
    at = m.incidences[0]
    return at["trees"], at["segments"], m, (at["reflected"][-1], at["reflected_se"][-1]), at["lost"][-1]


def start(mi, variant):
    """Chooses a variant, or says that it cannot be had."""
    import drjit

    mi.set_variant(variant)
    drjit.set_thread_count(1)
    if variant.startswith("llvm") and drjit.detail.llvm_version() < (17, 0):
        raise ImportError("LLVM 17 or newer is needed: DRJIT_LIBLLVM_PATH")


class Mitsuba:
    """The spheres under an orthographic camera that looks down. What it sees by light from above is, by reciprocity, the
    reflectance; by light from everywhere, 1. The middle of the slab is at the origin, or beside it."""

    def __init__(self, mi, centres, matrix, beside=0):
        self.mi, self.beside = mi, float(beside)
        to = mi.ScalarTransform4f
        glass = mi.load_dict({"type": "dielectric", "int_ior": INDEX, "ext_ior": matrix})
        ball = {"type": "sphere", "radius": RADIUS, "bsdf": glass}
        centres = centres + [self.beside, 0, -SIZE[2] / 2]
        balls = {f"ball_{i}": ball | {"center": c.tolist()} for i, c in enumerate(centres)}
        # For R, not for times: with an emitter of this kind paths take longer. What misses it goes along the slab to a part
        # in 1000. It is black, so that paths end there.
        sky = to().translate([0, 0, 15]) @ to().rotate([1, 0, 0], 180) @ to().scale([1e5, 1e5, 1])
        above = {"type": "rectangle", "to_world": sky, "emitter": {"type": "area", "radiance": white(1)},
                 "bsdf": {"type": "diffuse", "reflectance": white(0)}}
        around = {"type": "constant", "radiance": white(1)}
        self.scenes = {name: mi.load_dict({"type": "scene", "light": light} | balls)
                       for name, light in (("above", above), ("around", around))}

    def render(self, light, pixels, samples, depth=DEPTH, seed=0, footprint=FOOTPRINT):
        """Mean radiance with its error, and the time. Neighbouring pixels see nearly the same part of the slab, so their
        differences are noise."""
        mi, x, to = self.mi, self.beside, self.mi.ScalarTransform4f
        eye = to().look_at([x, 0, 14], [x, 0, 0], [0, 1, 0]) @ to().scale([footprint / 2, footprint / 2, 1])
        film = {"type": "hdrfilm", "width": pixels, "height": pixels, "pixel_format": "luminance",
                "rfilter": {"type": "box"}}
        sensor = mi.load_dict({"type": "orthographic", "to_world": eye, "film": film,
                               "sampler": {"type": "independent", "sample_count": samples}})
        integrator = mi.load_dict({"type": "path", "max_depth": depth, "rr_depth": 10_000})
        with Timed() as t:
            image = np.array(mi.render(self.scenes[light], sensor=sensor, integrator=integrator, seed=seed))
        image = image[..., 0].astype(float)
        noise = math.sqrt(np.mean(np.diff(image, axis=0) ** 2) / 2 / image.size)
        return (image.mean(), noise), t

    def segments(self, paths):
        """Segments per path: how many paths are longer than 0, 1, 2, ..."""
        side = math.isqrt(paths)
        ended = [self.render("around", side, 1, depth, seed=depth)[0][0] for depth in range(1, DEPTH)]
        return 1 + sum(1 - e for e in ended)


def white(x):
    """The same at all wavelengths."""
    return {"type": "uniform", "value": x} if x else {"type": "rgb", "value": 0.0}


def main():
    args = parser(__doc__).parse_args()
    mi = module("mitsuba")
    rates = []
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        centres, objects = packing(args.program, folder)
        for matrix in MATRICES[:1] if args.quick else MATRICES:
            rates += timed(args, folder, centres, objects, matrix, mi)
        checks = compared(args, folder, centres, objects, MATRICES[0], mi)
    print("Rates per second of one core. R differs from this program's with as much polarization and open sides.\n")
    table(["program", "matrix", "sides", "λ per path", "paths/s", "segments per path", "segments/s", "ratio of paths/s",
           "ratio of segments/s", "R", "differs by", "lost", "s to 1 % of R"], rates)
    if checks:
        print(f"R in a matrix of {MATRICES[0]}, open sides: single precision costs Mitsuba more the farther the spheres are "
              "from the origin.\n")
        table(["polarization", "footprint", "beside the origin by", "rays start beside a surface by", "this program", "Mitsuba",
               "differs by"], checks)


def timed(args, folder, centres, objects, matrix, mi):
    rows, reference = [], {}

    def row(name, sides, wavelengths, polarized, paths, segments, seconds, reflected, lost=None, part=1):
        first = reference.setdefault(polarized, (paths / seconds, segments / seconds, reflected))
        cost = part * seconds * (100 * reflected[1] / reflected[0]) ** 2
        same = sides == "periodic" or first[2] == reflected
        differs = "" if same else f"{apart(reflected, first[2]):+.1f} σ"
        rows.append([name, f"{matrix}", sides, f"{wavelengths}", paths / seconds, segments / paths, segments / seconds,
                     first[0] * seconds / paths, first[1] * seconds / segments,
                     f"{reflected[0]:.5f} ± {reflected[1]:.5f}", differs,
                     "" if lost is None else f"{lost:.1e}", cost])

    for polarized in (False, True):
        kind = "polarized" if polarized else "not polarized"
        for sides, wavelengths in (("open", 1), ("open", 20), ("periodic", 1)):
            path = sample(folder, objects, matrix, sides)
            n, segments, m, reflected, lost = ours(args.program, path, 200_000 if args.quick else 1_000_000, wavelengths,
                                                   polarized)
            print(f"this program, {kind}, {matrix}, {sides}, {wavelengths} λ: {n} trees, {m.wall:.2f} s, {m.cpu:.2f} s of "
                  f"the processor, {lost:.1e} lost; {m.backend['name']}\n", flush=True)
            row(f"this program, {kind}", sides, wavelengths, polarized, n, segments, m.cpu, reflected, lost)
    mean = None
    for variant in VARIANTS if mi else ():
        llvm = variant.startswith("llvm")
        try:
            start(mi, variant)
            peer = Mitsuba(mi, centres, matrix)
            mean = mean or peer.segments(2_000 if args.quick else 10_000)
            # Few paths at once make poor use of the compiled kernel; the first time it is compiled.
            pixels, samples = 64 if args.quick else 256, 64 if llvm else 8
            if llvm and not args.quick:
                _, first = peer.render("around", pixels, samples, seed=1)
                print(f"mitsuba, {variant}, {matrix}: the first time {first.wall:.2f} s\n", flush=True)
            furnace, t = peer.render("around", pixels, samples, seed=2)
            few = min(pixels, 128)
            reflected, _ = peer.render("above", few, 16, seed=3)
        except (ImportError, RuntimeError) as trouble:
            print(f"mitsuba, {variant}: left out: {trouble}\n", flush=True)
            continue
        paths = pixels**2 * samples
        print(f"mitsuba, {variant}, {matrix}: {paths} paths, {t.wall:.2f} s, {t.cpu:.2f} s of the processor; white furnace "
              f"{furnace[0]:.4f} ± {furnace[1]:.4f}\n", flush=True)
        row(f"Mitsuba, {variant}", "open", 4, variant.endswith("_polarized"), paths, paths * mean, t.cpu, reflected,
            part=few**2 * 16 / paths)
    return rows


def compared(args, folder, centres, objects, matrix, mi):
    """R for wide and narrow light, and where the whole scene lies beside the origin; then with rays of our own that start
    nearer to the surfaces than Mitsuba's do."""
    rows, walk = [], walker(mi, centres, matrix) if mi else None
    for polarized in (False, True) if mi else ():
        start(mi, "scalar_spectral_polarized" if polarized else "scalar_spectral")
        for footprint in (NARROW, FOOTPRINT):
            path = sample(folder, objects, matrix, "open", footprint)
            _, _, _, exact, _ = ours(args.program, path, 200_000 if args.quick else 1_000_000, 1, polarized)

            def row(start, beside, theirs):
                rows.append(["yes" if polarized else "no", f"{footprint}", f"{beside}", start]
                            + [f"{r[0]:.5f} ± {r[1]:.5f}" for r in (exact, theirs)] + [f"{apart(theirs, exact):+.1f} σ"])

            for beside in (0, 300) if footprint == FOOTPRINT else (0,):
                peer = Mitsuba(mi, centres, matrix, beside)
                theirs, _ = peer.render("above", 128, 8 if args.quick else 32, seed=3, footprint=footprint)
                row("Mitsuba's", beside, theirs)
            if polarized and walk:
                row("1e-5", 0, walk(footprint, 100_000 if args.quick else 400_000))
    return rows


def walker(mi, centres, matrix):
    """R as Mitsuba's intersections and its dielectric have it, along the paths of tests/peers/mitsuba_goniometer.py."""
    sys.path.insert(0, str(ROOT / "tests/peers"))
    try:
        start(mi, "llvm_ad_mono_polarized")
        import mitsuba_goniometer
    except (ImportError, RuntimeError, SystemExit) as trouble:
        print(f"tests/peers/mitsuba_goniometer.py: left out: {trouble}\n", flush=True)
        return None

    def walk(footprint, rays):
        mi.set_variant("llvm_ad_mono_polarized")
        glass = mi.load_dict({"type": "dielectric", "int_ior": INDEX, "ext_ior": matrix})
        balls = {f"ball_{i}": {"type": "sphere", "radius": RADIUS, "center": c.tolist(), "bsdf": glass}
                 for i, c in enumerate(centres - [0, 0, SIZE[2] / 2])}
        body, edges = (mi.load_dict({"type": "scene"} | balls), glass), ((footprint, 0, 0), (0, footprint, 0))
        corner = (-footprint / 2, -footprint / 2, 14)
        out = mitsuba_goniometer.launch(body, (0, 0, -1), corner, edges, rays, seed=4, depth=DEPTH)
        up = out.mueller[out.direction[:, 2] > 0, 0, 0]
        mean = up.sum() / rays
        return mean, math.sqrt(((up**2).sum() / rays - mean**2) / rays)

    return walk


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Time to a Klems matrix that is known to 1 %, by Radiance's genBSDF (pyradiance) and this program: see README.md."""

import os

for threads in ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ[threads] = "1"

import math
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from beside import Timed, measure, module, parser, table

# Klems' full basis: where each ring begins, in degrees, and its patches.
RINGS = [(0, 1), (5, 8), (15, 16), (25, 20), (35, 24), (45, 24), (55, 24), (65, 16), (75, 12)]
BOUNDS = [lower for lower, _ in RINGS] + [90]
PATCHES = sum(count for _, count in RINGS)
NM = 550
# What light falls on: 10 by 10, of a larger device in Radiance, again and again for ever here.
PATCH, WIDE = 10, 60
# Per incidence, as many as take about as long.
SAMPLES = {"-ab 5 -ad 64": 100, "-ab 12 -ad 1": 2_500, "-lr 40 -lw 1e-6": 400, "-lr -200 -lw 1e-3": 1_000}


@dataclass
class Device:
    name: str
    scene: str  # for Radiance
    heights: tuple  # lowest and highest point
    settings: dict  # options of rfluxmtx, by name
    options: list  # of this program
    sample: Path


def slats(folder):
    """Opaque slats, 1 deep at a distance of 1, tilted by 30 degrees; grey by Lambert's law."""
    tilt, share, thick = math.radians(30), 0.5, 0.02
    along = 0.5 * np.array([math.sin(tilt), 0, math.cos(tilt)])
    across = 0.5 * thick * np.array([math.cos(tilt), 0, -math.sin(tilt)])

    def faces(count, length):
        for i in range(count):
            middle = np.array([i + 0.5 - count / 2, 0, -0.5])
            edges = [middle + along + across, middle + along - across, middle - along - across, middle - along + across]
            for a, b in zip(edges, edges[1:] + edges[:1]):
                yield [p + [0, y, 0] for p, y in ((a, -length / 2), (b, -length / 2), (b, length / 2), (a, length / 2))]

    scene = f"void plastic grey\n0\n0\n5 {share} {share} {share} 0 0\n"
    for i, face in enumerate(faces(WIDE, 20 * PATCH)):
        scene += f"grey polygon face_{i}\n0\n0\n12 {' '.join(f'{x:.9g}' for p in face for x in p)}\n"
    ours = list(faces(PATCH, PATCH))
    text = "o slats\n" + "".join(f"v {p[0]:.12g} {p[1]:.12g} {p[2]:.12g}\n" for face in ours for p in face)
    text += "".join(f"f {4 * i + 1} {4 * i + 2} {4 * i + 3}\nf {4 * i + 1} {4 * i + 3} {4 * i + 4}\n" for i in range(len(ours)))
    (folder / "slats.obj").write_text(text)
    path = folder / "slats.toml"
    path.write_text(f'[sample]\npatch = {{ size = [{PATCH}, {PATCH}] }}\n[[object]]\nshape = "mesh"\nfile = "slats.obj"\n'
                    f"surface = {{ diffuse = {share} }}\n")
    heights = [p[2] for face in ours for p in face]
    settings = {s: s.split() for s in ("-ab 5 -ad 64", "-ab 12 -ad 1")}
    return Device("slats", scene, (min(heights), max(heights)), settings, [], path)


def spheres(folder):
    """A layer of glass spheres with room between them."""
    radius, index = 0.3, 1.5
    place = lambda i, count: i + 0.5 - count / 2
    scene = f"void dielectric glass\n0\n0\n5 1 1 1 {index} 0\n"
    for i in range(WIDE**2):
        x, y = place(i % WIDE, WIDE), place(i // WIDE, WIDE)
        scene += f"glass sphere ball_{i}\n0\n0\n4 {x} {y} -0.5 {radius}\n"
    path = folder / "spheres.toml"
    text = f"[sample]\npatch = {{ size = [{PATCH}, {PATCH}] }}\n[media]\nglass = {index}\n"
    for i in range(PATCH**2):
        x, y = place(i % PATCH, PATCH), place(i // PATCH, PATCH)
        text += f'[[object]]\nshape = "sphere"\ncenter = [{x}, {y}, -0.5]\nradius = {radius}\nmedium = "glass"\n'
    path.write_text(text)
    # Every ray is split down to a share of 1e-6; or chance decides about those below 1e-3 (up to 200
    # of them: without a limit genBSDF has crashed). Radiance knows no polarization.
    settings = {s: s.split() for s in ("-lr 40 -lw 1e-6", "-lr -200 -lw 1e-3")}
    options = ["--effects", "auto,-polarization"]
    return Device("spheres", scene, (-0.5 - radius, -0.5 + radius), settings, options, path)


def numbers(text):
    return np.array(text.replace(",", " ").split(), float)


# Each gives T and R, [exit, incidence], as shares of the light.

def radiance(peer, device, settings, samples, threads, seed):
    """Radiance's chance cannot be seeded. The device is the same everywhere, so for another seed light falls on another part
    of it, and there are some more samples, which moves all after them on in the row of random numbers."""
    x, y = ((seed * step) % 12 - 6 for step in (math.sqrt(2), math.sqrt(3)))
    box = peer.genbsdf.SamplingBox(x - PATCH / 2, x + PATCH / 2, y - PATCH / 2, y + PATCH / 2, *device.heights)
    across = math.isqrt(samples) + seed % 8
    with Timed() as t:
        out = peer.generate_bsdf(device.scene.encode(), params=device.settings[settings], nsamp=across**2, nproc=threads,
                                 dim=box, front=False)
    # A row per exit; light from above is what genBSDF calls back.
    shares = [numbers(m.decode()).reshape(PATCHES, PATCHES) for m in (out.back.transmittance, out.back.reflectance)]
    return np.array(shares), t, 0


def ours(program, device, trees, threads, seed):
    """A measurement of light from the middle of each patch, and its export; both are timed, one by one."""
    result = device.sample.with_suffix(".nc")
    xml = result.with_suffix(".xml")
    with Timed() as t:
        measure(program, device.sample, ["--incident", "klems-full", *device.options, "--wavelengths", NM, "--trees", trees,
                                         "--threads", threads, "--seed", seed], result)
        with Timed() as export:
            subprocess.run([str(c) for c in (program, "export", result, "--to", "klems-full", "--wavelength", NM, "-o", xml,
                                             "--quiet")], check=True)
    return matrices(xml.read_text()), t, export.wall


def matrices(xml):
    """T and R of light from above, of an XML file: BSDF times projected solid angle."""
    out = {}
    for block in xml.split("<WavelengthData>")[1:]:
        kind = block.split("<WavelengthDataDirection>")[1].split("<")[0]
        data = block.split("<ScatteringData>")[1].split("<")[0]
        out[kind.split()[0]] = numbers(data).reshape(PATCHES, PATCHES) * solid_angles()[:, None]
    return np.array([out["Transmission"], out["Reflection"]])


def solid_angles():
    """Projected, of all patches."""
    squares = [math.sin(math.radians(b)) ** 2 for b in BOUNDS]
    return np.array([math.pi * (b - a) / count for (_, count), a, b in zip(RINGS, squares, squares[1:]) for _ in range(count)])


def errors(first, second):
    """Of one of two runs: rms over all incidences of T and of R, over their mean; and rms of the elements, relative, each
    weighted by its flux."""
    totals = [m.sum(axis=1) for m in (first, second)]
    total = [math.sqrt(np.mean((a - b) ** 2) / 2) / np.mean(a + b) * 2 for a, b in zip(*totals)]
    flux = 0.5 * (first + second)
    lit = flux > 0
    element = math.sqrt(np.sum((first - second)[lit] ** 2 / flux[lit]) / 2 / np.sum(flux))
    return total, element


def averaged(program, device, trees, across):
    """T and R per patch of incidence, as genBSDF has them: light from everywhere in the patch. Directions are on a grid with
    `across` of them from side to side, equal in projected solid angle."""
    means, squares = [], []
    for ring, (lower, count) in enumerate(RINGS):
        a, b = (math.sin(math.radians(x)) ** 2 for x in (lower, BOUNDS[ring + 1]))
        thetas = [math.degrees(math.asin(math.sqrt(a + (b - a) * (i + 0.5) / across))) for i in range(across)]
        each = across if count > 1 else 24
        step = 360 / (count * each)
        azimuths = [(180 + (j + 0.5 - 0.5 * each) * step) % 360 for j in range(count * each)]
        m = measure(program, device.sample, ["--incident", ",".join(f"{x:.9f}" for x in thetas), "--azimuth",
                                             ",".join(f"{x:.9f}" for x in azimuths), "--wavelengths", NM, "--trees", trees,
                                             "--threads", 1, *device.options], device.sample.with_suffix(".nc"))
        values = np.zeros((2, 2, count))
        for at in m.incidences:
            k = round(((at["phi_deg"] - 180 - 0.5 * step) / step + 0.5 * each)) // each % count
            for i, name in enumerate(("transmitted", "reflected")):
                values[0, i, k] += at[name][0]
                values[1, i, k] += at[f"{name}_se"][0] ** 2
        of = across * each
        means.append(values[0] / of)
        squares.append(values[1] / of**2)
    return np.concatenate(means, axis=1), np.sqrt(np.concatenate(squares, axis=1))


def main():
    p = parser(__doc__)
    p.add_argument("--device", choices=("slats", "spheres"), help="only this one")
    args = p.parse_args()
    peer = module("pyradiance")
    rows, agreement = [], []
    with tempfile.TemporaryDirectory() as folder:
        for make in (slats, spheres):
            if args.device in (None, make.__name__):
                device = make(Path(folder))
                speed(args, peer, device, rows)
                if peer:
                    agree(args, peer, device, agreement)
    print("Seconds of a clock, without export. Errors are those of one of two runs; the time to 1 % is as if they fell with the "
          "square root of the time.\n")
    table(["device", "program", "threads", "samples per incidence", "s", "s of export", "error of T", "error of R",
           "error of elements", "s to 1 % of T", "s to 1 % of R", "s to 1 % of elements"], rows)
    if agreement:
        table(["device", "program", "mean of", "this program", "the peer", "differs by", "rms of 145 differences",
               "expected of chance"], agreement)


def speed(args, peer, device, rows):
    def row(name, samples, run):
        matrix, t, exports = run(1, 1)
        total, element = errors(matrix, run(1, 2)[0])
        for threads in (1,) if args.quick else (1, 2):
            if threads == 2:
                _, t, exports = run(2, 1)
            seconds = t.wall - exports
            print(f"{device.name}, {name}, {threads} threads: {t.wall:.2f} s, {t.cpu:.2f} s of processors\n", flush=True)
            rows.append([device.name, name, f"{threads}", f"{samples}", seconds, f"{exports:.3g}" if exports else ""]
                        + [f"{100 * e:.2g} %" for e in (*total, element)]
                        + [seconds * (100 * e) ** 2 for e in (*total, element)])

    trees = 2_000 if args.quick else 20_000
    row("this program", trees, lambda threads, seed: ours(args.program, device, trees, threads, seed))
    for settings in device.settings if peer else ():
        samples = SAMPLES[settings] * (1 if args.quick else 4)
        try:
            row(f"genBSDF {settings}", samples,
                lambda threads, seed: radiance(peer, device, settings, samples, threads, seed))
        except RuntimeError as trouble:
            print(f"{device.name}, genBSDF {settings}: left out: {trouble}\n", flush=True)


def agree(args, peer, device, rows):
    across, runs = (3, 6) if args.quick else (8, 16)
    exact, exact_se = averaged(args.program, device, 2_000, across)
    for settings in device.settings:
        samples = SAMPLES[settings] // (4 if args.quick else 2)
        each = np.array([radiance(peer, device, settings, samples, 1, 3 + i)[0].sum(axis=1) for i in range(runs)])
        mean, se = each.mean(axis=0), each.std(axis=0, ddof=1) / math.sqrt(runs)
        for i, name in enumerate("TR"):
            error = np.hypot(se[i], exact_se[i])
            off, off_se = (mean[i] - exact[i]).mean(), math.sqrt(np.sum(error**2)) / PATCHES
            rows.append([device.name, f"genBSDF {settings}", name, f"{exact[i].mean():.5f}", f"{mean[i].mean():.5f}",
                         f"{off:+.5f} ± {off_se:.5f} ({off / off_se:+.1f} σ)",
                         f"{math.sqrt(np.mean(((mean[i] - exact[i]) / error) ** 2)):.2f} σ",
                         f"{math.sqrt((runs - 1) / (runs - 3)):.2f} σ"])


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Rays per second of RayFlare and this program on pyramids of silicon, bare and coated, and R of both: see README.md."""

import os

for threads in ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ[threads] = "1"

import logging
import math
import tempfile
import warnings
from pathlib import Path

import numpy as np

from beside import Timed, apart, measure, module, parser, table

ANGLE, SIZE = 55, 100  # degrees, µm
COATING = 0.075  # µm
THICK = 1000  # µm: nothing comes back from below
NM = np.arange(400, 900, 25)
# Silicon and silicon nitride, rounded: what matters is that both programs have the same.
SILICON = (np.array([5.57, 5.05, 4.70, 4.47, 4.30, 4.18, 4.08, 4.00, 3.94, 3.89, 3.85, 3.81, 3.78, 3.75, 3.73, 3.71, 3.69, 3.68,
                     3.67, 3.65]),
           np.array([0.387, 0.21, 0.13, 0.095, 0.073, 0.055, 0.044, 0.035, 0.028, 0.023, 0.019, 0.016, 0.013, 0.011, 0.0095,
                     0.0082, 0.0072, 0.0063, 0.0056, 0.005]))
NITRIDE = (np.full(len(NM), 2.0), np.zeros(len(NM)))


def samples(folder):
    """A pyramid that repeats for ever; of a coat as thick along the normal everywhere, the upper face is the same pyramid higher
    up."""
    top = 0.5 * SIZE * math.tan(math.radians(ANGLE))
    for name, (n, k) in (("silicon", SILICON), ("nitride", NITRIDE)):
        (folder / f"{name}.csv").write_text("wavelength,n,k\n" + "".join(f"{a},{b},{c}\n" for a, b, c in zip(NM, n, k)))
    out = {}
    for name, lift in (("bare", 0), ("coated", COATING / math.cos(math.radians(ANGLE)))):
        text = f'[sample]\npatch = {{ size = [{SIZE}, {SIZE}], center = [0, 0] }}\n[media]\nsilicon = {{ csv = "silicon.csv" }}\n'
        text += 'nitride = { csv = "nitride.csv" }\n'
        text += f'[[object]]\nname = "wafer"\nshape = "slab"\ntop = 0\nbottom = {-THICK}\nmedium = "silicon"\n'
        for medium, height, priority in (("silicon", 0, 1),) + ((("nitride", lift, 0),) if lift else ()):
            (folder / f"{medium}.obj").write_text(pyramid(top, height))
            text += f'[[object]]\nshape = "mesh"\nfile = "{medium}.obj"\nmedium = "{medium}"\npriority = {priority}\n'
        out[name] = folder / f"{name}.toml"
        out[name].write_text(text)
    return out


def pyramid(top, lift):
    """On the ground, or on a block as high as `lift`."""
    half = SIZE / 2
    square = [(-half, -half), (half, -half), (half, half), (-half, half)]
    rings = [0] if lift == 0 else [0, lift]
    points = [(x, y, z) for z in rings for x, y in square] + [(0, 0, top + lift)]
    apex, upper = len(points), 4 * (len(rings) - 1)
    faces = [(4, 3, 2), (4, 2, 1)] + [(upper + 1 + i, upper + 1 + (i + 1) % 4, apex) for i in range(4)]
    for i in range(4 if lift else 0):
        a, b = 1 + i, 1 + (i + 1) % 4
        faces += [(a, b, b + 4), (a, b + 4, a + 4)]
    return "o pyramid\n" + "".join("v {:.15g} {:.15g} {:.15g}\n".format(*p) for p in points) + "".join(
        "f {} {} {}\n".format(*f) for f in faces)


# Each gives rays, interactions or segments per ray, seconds, R and its error per wavelength.

def ours(program, sample, trees, everything):
    options = ["--wavelengths", f"{NM[0]}:{NM[-1]}:25", "--source-mode", "line", "--trees", trees, "--threads", 1,
               "--effects", "all" if everything else "auto"]
    m = measure(program, sample, options, sample.with_suffix(".nc"))
    at = m.incidences[0]
    print(f"this program, {sample.stem}: {m.wall:.2f} s, {m.cpu:.2f} s of the processor; lost {max(at['lost']):.1e}, transmitted "
          f"{max(at['transmitted']):.1e}, films end near {m.validity['edge_flux']:.1e} of the light\n", flush=True)
    return at["trees"], at["segments"] / at["trees"], m.cpu, np.array(at["reflected"]), np.array(at["reflected_se"])


class Medium:
    """What RayFlare takes for a material."""

    def __init__(self, name, values):
        self.name, self.values = name, values

    def __str__(self):
        return self.name

    def n(self, wavelength):
        return np.interp(1e9 * np.asarray(wavelength), NM, self.values[0])

    def k(self, wavelength):
        return np.interp(1e9 * np.asarray(wavelength), NM, self.values[1])


class RayFlare:
    def __init__(self, coated, folder):
        from rayflare.options import default_options
        from rayflare.ray_tracing import rt_structure
        from rayflare.textures import planar_surface, regular_pyramids
        from solcore.structure import Layer

        air, silicon = Medium("air", (np.ones(len(NM)), np.zeros(len(NM)))), Medium("silicon", SILICON)
        o = self.options = default_options()
        o.wavelength, o.theta_in, o.phi_in, o.pol = 1e-9 * NM, 0.0, 0.0, "u"
        o.parallel, o.n_jobs, o.random_ray_position, o.I_thresh = False, 1, True, 1e-6
        o.x_limits = o.y_limits = [0, SIZE]
        o.depth_spacing_bulk, o.project_name, o.lookuptable_angles = 1e-3, "peers", 1000
        layers = {"interface_layers": [Layer(1e-6 * COATING, Medium("nitride", NITRIDE))]} if coated else {}
        front = regular_pyramids(elevation_angle=ANGLE, upright=True, size=SIZE, name="front", **layers)
        with Timed() as self.start:
            self.structure = rt_structure([front, planar_surface(size=SIZE)], [silicon], [1e-6 * THICK], air, air, o,
                                          use_TMM=coated, save_location=str(folder), overwrite=True)
            self.trace(2)

    def trace(self, side):
        self.options.nx = self.options.ny = side
        self.options.n_rays = side**2
        with Timed() as t:
            out = self.structure.calculate(self.options)
        data = out["ray_data"]
        with np.errstate(invalid="ignore"):
            up = np.nan_to_num(data["Is"], nan=0.0) * (np.real(data["thetas"]) < math.pi / 2)
        spread = up.std(axis=1, ddof=1) / math.sqrt(up.shape[1])
        assert np.allclose(up.mean(axis=1), out["R"], atol=1e-9) and np.max(out["T"]) < 1e-6
        return up.size, float(np.mean(data["n_interactions"])), t, up.mean(axis=1), spread


def long_enough(seconds):
    """Less than programs take to start says nothing."""
    return seconds if seconds > 0.1 else "< 0.1"


def main():
    p = parser(__doc__)
    p.add_argument("--spectra", action="store_true", help="R of every wavelength, too")
    args = p.parse_args()
    warnings.simplefilter("ignore")
    logging.disable(logging.INFO)
    there = module("rayflare")
    rows, spectra = [], []
    with tempfile.TemporaryDirectory() as folder:
        for name, sample in samples(Path(folder)).items():
            trees, segments, seconds, exact, exact_se = ours(args.program, sample, 50_000 if args.quick else 1_000_000, True)
            rate = trees * len(NM) / seconds

            def row(program, rays, per_ray, seconds, r, se, differs, chance):
                mean, mean_se = r.mean(), math.sqrt(np.sum(se**2)) / len(NM)
                rows.append([name, program, rays / seconds, per_ray, rate * seconds / rays, f"{mean:.5f} ± {mean_se:.5f}", differs,
                             chance, long_enough(seconds * (100 * mean_se / mean) ** 2)])

            row("this program, all effects", trees * len(NM), segments, seconds, exact, exact_se, "", "")
            n, per, seconds, r, se = ours(args.program, sample, trees, False)
            row("this program", n * len(NM), per, seconds, r, se, "", "")
            if there:
                peer = RayFlare(name == "coated", folder)
                rays, per, t, r, se = peer.trace(40 if args.quick else 80)
                print(f"RayFlare, {name}: {t.wall:.2f} s, {t.cpu:.2f} s of the processor, and {peer.start.wall:.2f} s to begin\n",
                      flush=True)
                # Where it counted few rays its own error says little: that of counting, of the other program's R.
                counting = np.sqrt(exact * (1 - exact) * len(NM) / rays)
                z = (r - exact) / np.hypot(counting, exact_se)
                mean = apart((r.mean(), math.sqrt(np.sum(se**2)) / len(NM)),
                             (exact.mean(), math.sqrt(np.sum(exact_se**2)) / len(NM)))
                row("RayFlare", rays, per, t.cpu, r, se, f"{mean:+.1f} σ", f"{math.sqrt(np.mean(z**2)):.2f} σ")
                spectra += [[name, f"{nm}", f"{a:.5f} ± {b:.5f}", f"{c:.5f} ± {d:.5f}", f"{x:+.1f} σ"]
                            for nm, a, b, c, d, x in zip(NM, exact, exact_se, r, se, z)]
    print(f"A ray is a ray at one wavelength: a tree of this program is {len(NM)}. R is the mean of the {len(NM)} wavelengths.\n")
    table(["pyramids", "program", "rays/s", "interactions or segments per ray", "ratio of rays/s", "R", "differs by",
           "rms over wavelengths", "s to 1 % of R"], rows)
    if args.spectra:
        table(["pyramids", "λ/nm", "this program", "RayFlare", "differs by"], spectra)


if __name__ == "__main__":
    main()

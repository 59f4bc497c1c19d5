"""Mitsuba 3 loads and evaluates exported BSDFs: mitsuba_reads.py PROGRAM FOLDER

FOLDER holds what `cargo test exports::` leaves in target/tmp/exports."""

import subprocess
import sys
from pathlib import Path

import mitsuba as mi
import numpy as np

PROGRAM, FOLDER = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve()
COUNT = 400
rng = np.random.default_rng(1)
failures = 0


def check(what, error, allowed):
    global failures
    failures += not error < allowed
    print(f"{'ok' if error < allowed else 'FAILED':<7}{what}: {error:.2e} (allowed {allowed:.1e})")


def export(result, form, path, *more):
    command = [PROGRAM, "export", FOLDER / result, "--to", form, "-o", FOLDER / path, "--quiet", *more]
    subprocess.run([str(c) for c in command], check=True)
    return str(FOLDER / path)


def direction(theta, phi):
    return np.array([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])


def random_direction(most=69):
    return direction(np.arccos(rng.uniform(np.cos(np.radians(most)), 1)), rng.uniform(-np.pi, np.pi))


def surface(wi, wavelengths):
    si = mi.SurfaceInteraction3f()
    si.wi = mi.Vector3f(*wi)
    if wavelengths is not None:
        si.wavelengths = wavelengths
    return si


def evaluate(bsdf, wi, wo, wavelengths):
    return np.array(bsdf.eval(mi.BSDFContext(), surface(wi, wavelengths), mi.Vector3f(*wo))).ravel()


def errors(bsdf, truth, wavelengths):
    """Root mean square error, of the root mean square value."""
    pairs = [(random_direction(), random_direction()) for _ in range(COUNT)]
    ours = np.array([truth(wi, wo) for wi, wo in pairs])
    theirs = np.array([evaluate(bsdf, wi, wo, wavelengths) for wi, wo in pairs])
    return np.sqrt(np.mean((theirs - ours) ** 2) / np.mean(ours**2))


def ggx(wi, wo, alpha):
    m = (wi + wo) / np.linalg.norm(wi + wo)
    d = 1 / (np.pi * alpha[0] * alpha[1] * ((m[0] / alpha[0]) ** 2 + (m[1] / alpha[1]) ** 2 + m[2] ** 2) ** 2)
    g1 = lambda v: 2 / (1 + np.sqrt(1 + ((v[0] * alpha[0]) ** 2 + (v[1] * alpha[1]) ** 2) / v[2] ** 2))
    return d * g1(wi) * g1(wo) / (4 * wi[2] * wo[2])


def load(path, **more):
    return mi.load_dict({"type": "measured", "filename": path, **more})


def spectral():
    mi.set_variant("scalar_spectral")
    nm = [400.0, 480.0, 600.0, 700.0]
    colour = lambda l: (0.2 + 0.1 * (np.array(l) - 400) / 300) / np.pi
    lambert = load(export("lambert.nc", "rgl", "lambert.bsdf"))
    check("Lambert", errors(lambert, lambda wi, wo: colour(nm) * wo[2], nm), 0.01)
    for name, alpha, allowed in (("ggx", (0.2, 0.2), 1e-3), ("anisotropic", (0.4, 0.15), 3e-3)):
        bsdf = load(str(FOLDER / f"{name}.bsdf"))
        truth = lambda wi, wo: np.full(2, ggx(wi, wo, alpha) * wo[2])
        check(name, errors(bsdf, lambda wi, wo: np.repeat(truth(wi, wo), 2), nm), allowed)
    albedo(lambert, colour)
    render()
    assert evaluate(lambert, np.array([0, 0, 1.0]), np.array([0.1, 0, -0.99]), nm).max() == 0
    coloured = load(export("coloured.nc", "rgl", "coloured.bsdf"))
    for bsdf in (lambert, coloured):
        grazing = [evaluate(bsdf, random_direction(89.5), random_direction(89.9), nm).min() for _ in range(COUNT)]
        assert min(grazing) >= 0, "no light is negative"


def albedo(bsdf, colour):
    """Sampling finds the albedo: within 4 standard errors."""
    nm = [420.0, 520.0, 600.0, 690.0]
    si = surface(direction(0.5, 0.3), nm)
    weights = np.array([
        np.array(bsdf.sample(mi.BSDFContext(), si, rng.random(), mi.Point2f(*rng.random(2)))[1]).ravel() for _ in range(4000)
    ])
    error = np.abs(weights.mean(0) - np.pi * colour(nm)) / (weights.std(0) / np.sqrt(len(weights)) + 0.003)
    check("albedo by sampling, in standard errors", error.max(), 4.0)


def sphere(path):
    return {
        "type": "scene",
        "integrator": {"type": "direct"},
        "sensor": {
            "type": "perspective", "fov": 30,
            "to_world": mi.ScalarTransform4f().look_at([0, 0, 5], [0, 0, 0], [0, 1, 0]),
            "film": {"type": "hdrfilm", "width": 32, "height": 32, "rfilter": {"type": "box"}},
            "sampler": {"type": "independent", "sample_count": 16},
        },
        "light": {"type": "point", "position": [0, 0, 20], "intensity": 400.0},
        "sphere": {"type": "sphere", "bsdf": {"type": "measured", "filename": path}},
    }


def render():
    """A sphere seen from where it is lit is as bright as cos θ says; its rim is dark."""
    image = np.array(mi.render(mi.load_dict(sphere(str(FOLDER / "lambert.bsdf")))))
    middle, corner = image[15:17, 15:17].mean(), image[0, 0].mean()
    ring = image[15:17, 4:6].mean()
    check("a rendered sphere: corner over middle", corner / middle, 1e-6)
    print(f"       middle {middle:.4f}, off the middle {ring:.4f}")
    assert 0 < ring < middle


def rgb():
    mi.set_variant("scalar_rgb")
    bsdf = load(export("lambert.nc", "rgl-rgb", "lambert-rgb.bsdf"))
    coloured = load(export("coloured.nc", "rgl-rgb", "coloured-rgb.bsdf"))
    wi = wo = np.array([0, 0, 1.0])
    r, g, b = evaluate(bsdf, wi, wo, None)
    check("RGB of a reddish Lambertian: green against 0.25 / pi", abs(g * np.pi / 0.25 - 1), 0.05)
    assert r > g > b, (r, g, b)
    assert np.isfinite(evaluate(coloured, wi, wo, None)).all()


def polarized():
    """Mueller matrices of a rough metal against those that Mitsuba itself has for it."""
    mi.set_variant("scalar_spectral_polarized")
    path = export("mueller.nc", "pbsdf", "mueller.pbsdf")
    ours = mi.load_dict({"type": "measured_polarized", "filename": path})
    metal = {"type": "roughconductor", "distribution": "ggx", "alpha": 0.3, "sample_visible": True}
    metal |= {key: {"type": "regular", "wavelength_min": 300.0, "wavelength_max": 900.0, "values": f"{x}, {x}"} for key, x in (("eta", 0.8), ("k", 3.0))}
    theirs = mi.load_dict(metal)
    nm = [500.0] * 4
    difference, size = np.zeros((4, 4)), 0
    for _ in range(COUNT):
        wi, wo = random_direction(60), random_direction(60)
        a, b = (matrix(bsdf, wi, wo, nm) for bsdf in (ours, theirs))
        difference += (a - b) ** 2
        size += b[0, 0] ** 2
    for i, j in ((0, 0), (0, 1), (1, 0), (1, 1), (1, 2), (2, 1), (2, 2), (2, 3), (3, 2), (3, 3), (0, 2), (3, 1)):
        check(f"Mueller element {i}{j}", np.sqrt(difference[i, j] / size), 0.04)


def matrix(bsdf, wi, wo, nm):
    value = np.array(bsdf.eval(mi.BSDFContext(), surface(wi, nm), mi.Vector3f(*wo)))
    return value.reshape(4, 4, -1)[:, :, 0]


spectral()
rgb()
polarized()
sys.exit(failures > 0)

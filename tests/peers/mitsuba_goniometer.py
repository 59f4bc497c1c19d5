"""A virtual goniometer made with Mitsuba 3: parallel light on a footprint, and the Mueller matrix of every ray that
leaves. There is no camera and none of Mitsuba's integrators, only its intersections, its polarized dielectric and its
rules for turning Mueller matrices.

Light walks forward, from the source to the detector (`TransportMode.Importance`: powers, not radiances, so without
the factor n² of refraction). Chance reflects or refracts a ray, by the shares of unpolarized light; what polarization
changes of that is in the Mueller matrix of the ray. So the mere number of rays is the answer of transport without
polarization, by the same paths.

Mitsuba's Stokes vectors are the program's: `mitsuba_truth.py` compares them with Maxwell's equations, V included.
"""

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi
import numpy as np

mi.set_variant("llvm_ad_mono_polarized")
if dr.detail.llvm_version() < (17, 0):
    raise SystemExit("Mitsuba needs LLVM 17 or newer here: apt-get install libllvm19, or DRJIT_LIBLLVM_PATH=libLLVM.so")

# A ray starts this far beside the surface it leaves: some 20 roundings of a coordinate of 4. Mitsuba's own distance
# would be ten times that.
LIFT = 1e-5


def build(shapes, index):
    """A scene of dielectric bodies in air, from descriptions of their shapes; and the dielectric."""
    glass = mi.load_dict({"type": "dielectric", "int_ior": float(index), "ext_ior": 1.0})
    bodies = {f"body_{i}": shape | {"bsdf": glass} for i, shape in enumerate(shapes)}
    return mi.load_dict({"type": "scene"} | bodies), glass


@dataclass
class Rays:
    """What has left, one row per ray."""

    direction: np.ndarray  # (n, 3), unit vectors
    mueller: np.ndarray  # (n, 4, 4), for one unit of power per ray sent
    start: np.ndarray  # (3,), x̂ of the incident Stokes vector
    end: np.ndarray  # (n, 3), x̂ of those that left
    sent: int
    caught: float  # share of the power sent that was still inside after `depth` interfaces
    broken: float  # share of the rays that came to an interface from the wrong side


@dr.syntax
def walk(scene, glass, ray, sampler, depth):
    """Follows rays until nothing is met."""
    context = mi.BSDFContext(mi.TransportMode.Importance)
    mueller = mi.Spectrum(1)
    active, first = mi.Bool(True), mi.Bool(True)
    inside, broken = mi.Bool(False), mi.Bool(False)
    met = mi.UInt32(0)
    while active:
        si = scene.ray_intersect(ray, active)
        active &= si.is_valid()
        # Where a ray begins is taken from the first interface; then each refraction changes it.
        within = si.wi.z < 0
        broken |= active & ~first & (within != inside)
        active &= ~broken
        bs, weight = glass.sample(context, si, sampler.next_1d(active), sampler.next_2d(active), active)
        weight = si.to_world_mueller(weight, -si.wi, bs.wo)
        mueller = dr.select(active, weight @ mueller, mueller)
        out = si.to_world(bs.wo)
        beside = LIFT * dr.mulsign(mi.Vector3f(si.n), dr.dot(si.n, out))
        ray.o = dr.select(active, si.p + beside, ray.o)
        ray.d = dr.select(active, dr.normalize(out), ray.d)
        refracted = mi.has_flag(bs.sampled_type, mi.BSDFFlags.DeltaTransmission)
        inside = dr.select(active, within ^ refracted, inside)
        first &= ~active
        met += dr.select(active, 1, 0)
        active &= met < depth
    return ray.d, mueller, broken, met


def launch(body, incident, corner, edges, count, seed, depth=256):
    """Sends `count` rays in direction `incident` into a scene of `build`, from random points of the parallelogram of
    `corner` and `edges`."""
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(seed, count)
    x, y = sampler.next_1d(), sampler.next_1d()
    origin = [float(o) + x * float(a) + y * float(b) for o, a, b in zip(corner, *edges)]
    k = dr.normalize(mi.Vector3f([float(c) for c in incident]))
    ray = mi.Ray3f(mi.Point3f(origin), dr.zeros(mi.Vector3f, count) + k)
    direction, mueller, broken, met = walk(*body, ray, sampler, mi.UInt32(depth))
    end = mi.mueller.stokes_basis(direction)
    caught = (met >= depth) & ~broken
    dr.eval(direction, mueller, end, broken, caught)
    left = ~np.array(broken | caught)
    mueller = np.moveaxis(np.array(mueller, dtype=float).reshape(4, 4, count), -1, 0)
    direction = np.array(direction, dtype=float).T
    start = np.array(mi.mueller.stokes_basis(k), dtype=float).ravel()
    return Rays(
        direction=(direction / np.linalg.norm(direction, axis=1, keepdims=True))[left],
        mueller=mueller[left],
        start=start / np.linalg.norm(start),
        end=np.array(end, dtype=float).T[left],
        sent=count,
        caught=mueller[np.array(caught), 0, 0].sum() / count,
        broken=np.array(broken).mean(),
    )

"""Whether the goniometer made with Mitsuba is right by itself: against Maxwell's equations, where they can be solved
ray by ray."""

import tempfile
from pathlib import Path

import numpy as np

from mitsuba_goniometer import build, launch
from polarization_cases import Case, box, rhomb, turned
from stokes import across, chain, meet, turn

# Mitsuba computes with 24 bits; near the critical angle and at grazing incidence a few of them are lost.
SINGLE = 5e-6


def rotation(rng):
    q = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    return q * np.sign(np.linalg.det(q))


def interfaces(rng):
    """The largest error of a Mueller matrix of one interface, reflected and refracted, from both sides, in frames and
    planes of incidence at random, up to and beyond the critical angle (41.8°)."""
    worst = {"reflection": 0.0, "refraction": 0.0, "total reflection": 0.0}
    square = np.array([[-9, -9, 0], [9, -9, 0], [9, 9, 0], [-9, 9, 0.0]])
    for degrees in (0, 1, 20, 40, 41.5, 42, 45, 52, 56.3, 70, 85):
        for outside in (True, False):
            about = rotation(rng)
            k = about @ turned("z", rng.uniform(0, 360)) @ turned("y", degrees) @ [0, 0, -1.0 if outside else 1.0]
            with tempfile.TemporaryDirectory() as folder:
                sheet = Case("sheet", (0, 0), (1, 1), meshes=[(square @ about.T, [(0, 1, 2), (0, 2, 3)])])
                body = build(sheet.shapes(Path(folder)), sheet.index)
            rays = launch(body, k, -3 * k + 0.1 * about[:, 0], np.zeros((2, 3)), 4000, seed=1)
            for kind, error in errors(rays, k, about[:, 2], sheet.index):
                worst[kind] = max(worst[kind], error)
    return worst


def errors(rays, k, normal, index):
    """Of both beams of an interface."""
    reflectance = meet(k, rays.start, normal, 1.0, index, False)[2][0, 0]
    up = rays.direction @ normal * np.sign(k @ normal) < 0
    total = reflectance > 1 - 1e-6
    for refracted, chance in ((False, reflectance), (True, 1 - reflectance)):
        if refracted and total:
            continue
        out, x, truth = meet(k, rays.start, normal, 1.0, index, refracted)
        hit = up ^ refracted
        found = turn(rays.direction[hit], rays.end[hit], x) @ rays.mueller[hit] * chance
        kind = "refraction" if refracted else "total reflection" if total else "reflection"
        yield kind, max(np.abs(found - truth).max(), np.abs(rays.direction[hit] - out).max())


def straight(k, x, enter, inner, back, leave, orders=12):
    """The Mueller matrix, from x to x, of a body that light leaves as it came, with the light that goes to and fro in
    it: `inner` are the interfaces on the way, `back` those of one more way back and forth."""
    total = 0
    for order in range(orders):
        out, frame, mueller = chain(k, x, [enter, *inner, *(order * back), leave])
        total = total + turn(out, frame, x) @ mueller
    return total


def plate(k, x, normal, index):
    """A plane-parallel one, without interference."""
    up, down = (normal, 1.0, index), (-normal, 1.0, index)
    return straight(k, x, (*up, True), [], [(*down, False), (*up, False)], (*down, True))


def crossed_plates(rng):
    """Two plates near Brewster's angle, wide beside the beam, with perpendicular planes of incidence."""
    about = turned("z", rng.uniform(0, 360))
    turns = [about @ turned("x", 56.3), about @ turned("y", 53.0)]
    meshes = [box(np.array([9, 9, 0.02]), r, np.array([0, 0, z])) for r, z in zip(turns, (10, -10))]
    case = Case("wide-plates", (0.0, 0.0), (0.5, 0.5), meshes=meshes)
    k, x = case.propagation(), case.p_direction()
    upper, lower = (plate(k, x, r[:, 2], case.index) for r in turns)
    return case, case.footprint(), k, x, lower @ upper


def retarder(rng):
    """A rhomb of Fresnel's of any direction: two total reflections make a quarter wave plate."""
    about, angle, index = rotation(rng), np.radians(53.26), 1.5
    case = Case("rhomb", (0, 0), (1, 1), index, meshes=[rhomb(about, angle)])
    k, side = about[:, 0], about @ np.array([np.cos(angle), 0, -np.sin(angle)])
    first, last, low, high = ((n, 1.0, index, False) for n in (-k, k, side, -side))
    enter, leave = (-k, 1.0, index, True), (k, 1.0, index, True)
    x = across(k)
    truth = straight(k, x, enter, [low, high], [last, high, low, first, low, high], leave)
    return case, (about @ [-1, 0, 0.45], 0.1 * about[:, 1:].T), k, x, truth


def straight_beam(make, rng, rays=200_000):
    """The largest error of the Mueller matrix of light that leaves as it came; the same in standard errors."""
    case, footprint, k, x, truth = make(rng)
    with tempfile.TemporaryDirectory() as folder:
        body = build(case.shapes(Path(folder)), case.index)
    found = launch(body, k, *footprint, rays, seed=2)
    hit = found.direction @ k > 1 - 1e-9
    own = turn(found.direction[hit], found.end[hit], x) @ found.mueller[hit] @ turn(k, x, found.start)
    mean = own.sum(0) / found.sent
    variance = ((own**2).sum(0) / found.sent - mean**2) / found.sent
    return np.abs(mean - truth).max(), np.abs((mean - truth) / np.sqrt(variance + SINGLE**2)).max()

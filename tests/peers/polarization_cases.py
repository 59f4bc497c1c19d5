"""Samples of glass in air, each described once for both programs: as a sample file and as shapes of Mitsuba.

All lengths are mm: far above the coherence length, so that nothing is a film. Mitsuba rounds them to 24 bits.
"""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from geodesic import Dome


@dataclass
class Case:
    name: str
    incidence: tuple  # θ and φ of the source, degrees
    patch: tuple  # edge lengths of the footprint
    index: float = 1.5
    spheres: list = field(default_factory=list)  # (center, radius)
    meshes: list = field(default_factory=list)  # (vertices, triangles), flat

    def top(self):
        """Height of the highest point: there the rays start."""
        tops = [center[2] + radius for center, radius in self.spheres]
        return max(tops + [vertices[:, 2].max() for vertices, _ in self.meshes])

    def propagation(self):
        theta, phi = np.radians(self.incidence)
        return -np.array([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])

    def p_direction(self):
        """x̂ of the incident Stokes vector."""
        phi = np.radians(self.incidence[1])
        return np.cross([-np.sin(phi), np.cos(phi), 0], self.propagation())

    def footprint(self):
        """A corner and two edges."""
        w, d = self.patch
        return np.array([-w / 2, -d / 2, self.top()]), np.array([[w, 0, 0], [0, d, 0]])

    def write(self, folder: Path):
        """Writes the sample file, with its meshes, into a folder."""
        lines = ["[sample]", 'unit = "mm"', f'patch = {{ size = {list(self.patch)}, center = [0, 0], sides = "open" }}']
        lines += ["[media]", f"glass = {self.index!r}"]
        for center, radius in self.spheres:
            center = [float(c) for c in center]
            lines += ["[[object]]", 'shape = "sphere"', f"center = {center}", f"radius = {float(radius)}"]
            lines += ['medium = "glass"']
        for file in self._write_meshes(folder):
            lines += ["[[object]]", 'shape = "mesh"', f'file = "{file.name}"', 'medium = "glass"']
        path = folder / f"{self.name}.toml"
        path.write_text("\n".join(lines) + "\n")
        return path

    def shapes(self, folder: Path):
        """The same for Mitsuba, from the same mesh files."""
        spheres = [{"type": "sphere", "center": list(map(float, c)), "radius": float(r)} for c, r in self.spheres]
        meshes = [{"type": "obj", "filename": str(f), "face_normals": True} for f in self._write_meshes(folder)]
        return spheres + meshes

    def _write_meshes(self, folder):
        paths = [folder / f"{self.name}_{i}.obj" for i in range(len(self.meshes))]
        for path, (vertices, triangles) in zip(paths, self.meshes):
            lines = ["v " + " ".join(repr(float(x)) for x in v) for v in vertices]
            lines += ["f " + " ".join(str(i + 1) for i in t) for t in triangles]
            path.write_text("\n".join(lines) + "\n")
        return paths


def turned(axis, degrees):
    """A rotation about a coordinate axis."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    i, j = [(1, 2), (2, 0), (0, 1)]["xyz".index(axis)]
    matrix = np.eye(3)
    matrix[i, i], matrix[i, j], matrix[j, i], matrix[j, j] = c, -s, s, c
    return matrix


# The triangles of a block whose corners come with the first coordinate slowest, outward.
_QUADS = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
BLOCK = [t for a, b, c, d in _QUADS for t in ((a, b, c), (a, c, d))]


def box(half, rotation, center):
    """A rectangular block."""
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * half
    return corners @ rotation.T + center, BLOCK


def rhomb(about, angle):
    """Fresnel's, of height 1 and width 2: light along the x axis of `about` meets one end squarely in its middle at
    (0, 0, 1/2), two sides at `angle` (radians), and the other end."""
    along = np.array([np.sin(angle), 0, np.cos(angle)])
    far = 2 * np.sin(angle) ** 2 / np.cos(angle) * along
    corners = [np.zeros(3), np.array([0, 0, 1.0]), far, far + [0, 0, 1]]
    return np.array([p + [0, y, 0] for y in (1, -1) for p in corners]) @ about.T, BLOCK


def icosphere(divisions):
    """Vertices on the unit sphere and triangles."""
    facets = Dome(divisions).corners[-1]
    vertices, index = np.unique(facets.reshape(-1, 3).round(9), axis=0, return_inverse=True)
    return vertices / np.linalg.norm(vertices, axis=1, keepdims=True), index.reshape(-1, 3)


def sphere(_):
    return Case("sphere", (35.0, 20.0), (3.6, 3.2), spheres=[((0.0, 0.0, 0.0), 1.0)])


def plates(rng):
    """Two thick plates, one above the other: straight light meets both near Brewster's angle, in perpendicular
    planes of incidence. Their edges are in the light too."""
    about = turned("z", rng.uniform(10, 80))
    tilts = rng.uniform(50, 60, 2)
    half = np.array([1.5, 1.5, 0.1])
    upper = box(half, about @ turned("x", tilts[0]), np.array([0, 0, 1.5]))
    lower = box(half, about @ turned("y", tilts[1]), np.array([0, 0, -1.5]))
    return Case("crossed-plates", (0.0, 0.0), (2.6, 2.2), meshes=[upper, lower])


def cluster(rng, name="cluster", index=1.5, count=8):
    """Spheres beside, above and below one another that do not touch."""
    spheres = []
    while len(spheres) < count:
        center, radius = rng.uniform([-1.3, -1.3, -1.0], [1.3, 1.3, 1.0]), rng.uniform(0.4, 0.75)
        if all(np.linalg.norm(center - c) > radius + r + 0.03 for c, r in spheres):
            spheres.append((center, radius))
    return Case(name, (rng.uniform(0, 65), rng.uniform(0, 360)), (3.6, 3.6), index, spheres=spheres)


def retarder(rng):
    """A rhomb of Fresnel's, turned against the plane of incidence: it makes light circular."""
    case = Case("rhomb", (rng.uniform(0, 50), rng.uniform(0, 360)), (3.0, 3.0))
    k, p = case.propagation(), case.p_direction()
    about = np.stack([k, p, np.cross(k, p)], 1) @ turned("x", rng.uniform(10, 80))
    vertices, triangles = rhomb(about, np.radians(53.26))
    case.meshes = [(vertices - vertices.mean(0), triangles)]
    return case


def pebble(rng):
    """A closed mesh with dents, of 320 flat faces: total reflection, and light that leaves and enters again."""
    vertices, triangles = icosphere(2)
    waves = sum(
        rng.uniform(-0.1, 0.1) * np.cos(order * vertices @ rng.normal(size=3) + rng.uniform(0, 6))
        for order in (1, 1, 2, 2, 3, 3)
    )
    radius = 1 + waves + rng.uniform(-0.02, 0.02, len(vertices))
    mesh = vertices * radius[:, None], triangles
    return Case("pebble", (rng.uniform(20, 60), rng.uniform(0, 360)), (3.0, 3.0), meshes=[mesh])


def all_cases(seed):
    """The fixed sphere; everything else is new with each seed."""
    rng = np.random.default_rng(seed)
    return [
        sphere(rng),
        plates(rng),
        cluster(rng),
        cluster(rng, "dense-cluster", index=rng.uniform(1.3, 2.0), count=12),
        pebble(rng),
        retarder(rng),
    ]

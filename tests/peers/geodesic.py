"""The dome of the program in NumPy: facets, which of them a direction is in, and the frames of Stokes vectors there."""

import numpy as np

from stokes import turn


def _roots():
    z = 1 / np.sqrt(5)
    angle = np.pi / 5 * (2 * np.arange(6) % 10)
    up = np.stack([2 * z * np.cos(angle), 2 * z * np.sin(angle), np.full(6, z)], -1)
    angle = angle + np.pi / 5
    down = np.stack([2 * z * np.cos(angle), 2 * z * np.sin(angle), np.full(6, -z)], -1)
    north, south = np.array([0, 0, 1.0]), np.array([0, 0, -1.0])
    faces = [[north, up[k], up[k + 1]] for k in range(5)]
    faces += [[up[k], down[k], up[k + 1]] for k in range(5)]
    faces += [[down[k], down[k + 1], up[k + 1]] for k in range(5)]
    faces += [[south, down[k + 1], down[k]] for k in range(5)]
    return np.array(faces)


def _unit(v):
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def _divide(facets):
    a, b, c = facets[:, 0], facets[:, 1], facets[:, 2]
    ab, bc, ca = _unit(a + b), _unit(b + c), _unit(c + a)
    parts = [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
    return np.stack([np.stack(p, 1) for p in parts], 1).reshape(-1, 3, 3)


class Dome:
    """The facets of one level, and all above: `corners[level][code]` are three unit vectors."""

    def __init__(self, level):
        self.level = level
        self.corners = [_roots()]
        for _ in range(level):
            self.corners.append(_divide(self.corners[-1]))
        self._roots = _unit(self.corners[0].sum(1))

    def center(self, level, code):
        return _unit(self.corners[level][code].sum(-2))

    def locate(self, direction):
        """Codes of the facets of the finest level that hold the directions."""
        code = np.argmax(direction @ self._roots.T, axis=1)
        for level in range(1, self.level + 1):
            middle = self.corners[level][4 * code + 3]
            part = np.full(len(code), 3)
            # A corner is cut off by the plane through the two middles beside it.
            for corner, (p, q) in enumerate([(2, 0), (0, 1), (1, 2)]):
                plane = np.cross(middle[:, p], middle[:, q])
                own = self.corners[level - 1][code, corner]
                side = np.sum(plane * direction, 1) * np.sign(np.sum(plane * own, 1))
                part[side > 0] = corner
            code = 4 * code + part
        return code

    def parts(self, level, code):
        """The facets of the finest level in a facet."""
        many = 4 ** (self.level - level)
        return slice(code * many, (code + 1) * many)


def carried_x(k):
    """x̂ carried from the pole to the directions `k` by the smallest rotations that take the pole there."""
    pole = np.zeros_like(k)
    pole[..., 2] = np.where(k[..., 2] < 0, -1, 1)
    x = np.array([1.0, 0, 0])
    return x - (k @ x / (1 + np.sum(pole * k, -1)))[..., None] * (pole + k)


def theta_hat(k):
    """Unit vectors of growing polar angle; at the poles, for azimuth 0."""
    across = np.hypot(k[..., 0], k[..., 1])
    there = across > 1e-12
    cos, sin = (np.where(there, k[..., i] / np.where(there, across, 1), 1 - i) for i in (0, 1))
    return np.stack([k[..., 2] * cos, k[..., 2] * sin, -across], -1)


def to_theta(center):
    """What turns Stokes vectors of the carried frames of a facet into the frame of its centre, x̂ = θ̂."""
    return turn(center, carried_x(center), theta_hat(center))

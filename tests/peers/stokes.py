"""Stokes vectors as the program has them, and what plane interfaces do to them, from Maxwell's equations.

Fields go like exp(i(k·r - ωt)). In a frame (x̂, ŷ = k̂ × x̂): I = |Eₓ|² + |E_y|², Q = |Eₓ|² - |E_y|² and
U + iV = 2 Eₓ E_y*. Powers are those through a plane parallel to the interface.
"""

import numpy as np

# From (EₓEₓ*, EₓE_y*, E_yEₓ*, E_yE_y*) to (I, Q, U, V).
_COHERENCY = np.array([[1, 0, 0, 1], [1, 0, 0, -1], [0, 1, 1, 0], [0, -1j, 1j, 0]])


def mueller(jones):
    """The Mueller matrix of a Jones matrix."""
    return (_COHERENCY @ np.kron(jones, jones.conj()) @ np.linalg.inv(_COHERENCY)).real


def turn(k, old, new):
    """What makes Stokes vectors in frames of x̂ = `old` ones in frames of x̂ = `new`. Arrays of vectors broadcast."""
    k, old, new = np.broadcast_arrays(k, old, new)
    x, y = np.sum(old * new, -1), np.sum(np.cross(k, old) * new, -1)
    angle = 2 * np.arctan2(y, x)
    out = np.zeros((*angle.shape, 4, 4))
    out[..., 0, 0] = out[..., 3, 3] = 1
    out[..., 1, 1] = out[..., 2, 2] = np.cos(angle)
    out[..., 1, 2] = np.sin(angle)
    out[..., 2, 1] = -np.sin(angle)
    return out


def across(k):
    """Some unit vector across `k`."""
    k = np.asarray(k, float)
    other = np.eye(3)[np.argmin(np.abs(k))]
    x = np.cross(k, other)
    return x / np.linalg.norm(x)


def meet(k, x, normal, outside, inside, refracted):
    """One interface: the new direction, a frame x̂ for it, and the Mueller matrix from `x` to that. The `normal` points
    into the medium of index `outside`. Amplitudes solve the continuity of E and H along the interface: no sign of a
    Fresnel coefficient is taken from anywhere."""
    k, x, normal = (np.asarray(v, float) for v in (k, x, normal))
    n1, n2 = (outside, inside) if k @ normal < 0 else (inside, outside)
    n = -np.sign(k @ normal) * normal
    along = n1 * (k - (k @ n) * n)
    kt = along - n * np.emath.sqrt(n2**2 - along @ along)
    kr = n1 * (k - 2 * (k @ n) * n)
    tangents = across(n), np.cross(n, across(n))
    s = np.cross(n, k)
    s = s / np.linalg.norm(s) if np.linalg.norm(s) > 1e-9 else across(n)

    def traces(wave, field):
        """E and H along the interface, up to constants."""
        magnetic = np.cross(wave, field)
        return [v @ t for v in (field, magnetic) for t in tangents]

    reflected = s, np.cross(kr, s) / n1
    transmitted = s, np.cross(kt, s) / n2
    unknown = np.array(
        [traces(kr, e) for e in reflected] + [[-t for t in traces(kt, e)] for e in transmitted], complex
    ).T
    incident = np.array([traces(n1 * k, e) for e in (x, np.cross(k, x))]).T
    amplitudes = -np.linalg.solve(unknown, incident)
    if not refracted:
        return kr / n1, s, mueller(amplitudes[:2])
    out = kt.real / n2
    scale = np.sqrt(n2 * (out @ -n) / (n1 * (k @ -n)))
    return out, s, mueller(scale * amplitudes[2:])


def chain(k, x, interfaces):
    """Several interfaces, each (normal, outside, inside, refracted), one after the other."""
    total = np.eye(4)
    for interface in interfaces:
        frame = x
        k, x, step = meet(k, frame, *interface)
        total = step @ total
    return k, x, total

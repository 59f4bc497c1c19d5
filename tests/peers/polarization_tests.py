"""How far two measurements of a sample are apart: that of the program, and that of the goniometer made with Mitsuba."""

from dataclasses import dataclass

import numpy as np
import xarray as xr
from scipy import stats

from geodesic import carried_x, to_theta
from mitsuba_goniometer import launch
from stokes import turn

# Directions closer than this are the same for Mitsuba, which has 24 bits.
SAME = 2e-5
# Mitsuba's rounding, as a share of the power in a facet.
ROUNDING = 1e-5
# Facets hit by fewer trees have no standard error worth the name.
FEWEST_TREES = 20
# Scrambles of the program, from which its standard errors come.
SCRAMBLES = 32


@dataclass
class Tally:
    """Mitsuba's shares of the incident power, one row per batch of rays."""

    facets: np.ndarray  # (batches, facets, 4, 4), in the carried frames
    plain: np.ndarray  # (batches, facets), without polarization
    delta: dict  # "specular" and "undeflected": (batches, 4, 4), in the frame x̂ = θ̂ of that direction
    caught: float
    broken: float

    def side(self, name, dome):
        """Mean and standard error of the light "reflected" or "transmitted"."""
        delta = self.delta["specular" if name == "reflected" else "undeflected"]
        return mean_and_error((self.facets[:, above(dome, name)].sum(1) + delta)[:, 0, 0])


def above(dome, name):
    """Which facets of the finest level see the light "reflected", or that "transmitted"."""
    z = dome.corners[-1].sum(1)[:, 2]
    return z > 0 if name == "reflected" else z < 0


def mean_and_error(batches):
    """Of the mean over the batches."""
    return np.array([batches.mean(0), batches.std(0, ddof=1) / np.sqrt(len(batches))])


def tally(body, case, dome, rays, batches, seed):
    """Measures with Mitsuba."""
    k = case.propagation()
    directions = {"specular": k * [1, 1, -1], "undeflected": k}
    count = len(dome.corners[-1])
    result = Tally(np.zeros((batches, count, 4, 4)), np.zeros((batches, count)), {}, 0.0, 0.0)
    result.delta = {name: np.zeros((batches, 4, 4)) for name in directions}
    for b in range(batches):
        found = launch(body, k, *case.footprint(), rays, seed=seed * batches + b)
        result.caught += found.caught / batches
        result.broken += found.broken / batches
        mueller = found.mueller @ turn(k, case.p_direction(), found.start) / rays
        mueller = turn(found.direction, found.end, carried_x(found.direction)) @ mueller
        rest = np.full(len(mueller), True)
        for name, out in directions.items():
            same = np.linalg.norm(found.direction - out, axis=1) < SAME
            result.delta[name][b] = to_theta(out) @ mueller[same].sum(0)
            rest &= ~same
        code = dome.locate(found.direction[rest])
        result.plain[b] = np.bincount(code, minlength=count) / rays
        for i, j in np.ndindex(4, 4):
            result.facets[b, :, i, j] = np.bincount(code, mueller[rest, i, j], count)
    return result


@dataclass
class Own:
    """What the program measured: values and standard errors."""

    leaves: list  # (level, code)
    trees: np.ndarray  # (leaves,)
    mueller: np.ndarray  # (2, leaves, 4, 4), shares of the incident power, in the frame of the centre
    delta: dict  # "specular" and "undeflected": (2, 4, 4)
    sides: dict  # "reflected" and "transmitted": (2,)
    lost: float

    def first_row(self, name, delta, dome):
        """Of all light on a side: no choice of exit frames changes it. Facets count as independent; those of one dome
        vie for the same light, so the sum is surer than that."""
        up = np.array([dome.center(*leaf)[2] > 0 for leaf in self.leaves])
        here = up == (name == "reflected")
        value = self.mueller[0, here].sum(0) + self.delta[delta][0]
        error = np.sqrt((self.mueller[1, here] ** 2).sum(0) + self.delta[delta][1] ** 2)
        return np.stack([value, error])[:, 0, 1:]

    @staticmethod
    def read(path, dome):
        """From a result of one incidence and one wavelength; its facets must be those of `dome`."""
        with xr.open_dataset(path, engine="scipy") as file:
            get = lambda name: np.stack([file[n].values.squeeze() for n in (name, f"{name}_se")])
            leaves = list(zip(*(file[name].values.astype(int) for name in ("facet_level", "facet_code"))))
            angle = file.projected_solid_angle.values
            mueller = np.stack([file[n].values[:, 0] for n in ("mueller", "mueller_se")]) * angle[:, None, None]
            assert np.array_equal(file.mueller.values[:, 0, 0, 0], file.bsdf.values[:, 0]), "m00 is not bsdf"
            centers = np.array([dome.center(*leaf) for leaf in leaves])
            theta, phi = np.radians(file.theta_o.values), np.radians(file.phi_o.values)
            there = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], -1)
            assert np.abs(centers - there).max() < 1e-12, "the facets are not where they should be"
            return Own(
                leaves=leaves,
                trees=file.facet_trees.values,
                mueller=mueller,
                delta={name: get(f"{name}_mueller") for name in ("specular", "undeflected")},
                sides={name: get(name) for name in ("reflected", "transmitted")},
                lost=float(sum(file[n].values.squeeze() for n in file if n.startswith("lost") and "_se" not in n)),
            )


@dataclass
class Scores:
    """Differences as Student's t, of any shape."""

    t: np.ndarray
    freedom: np.ndarray

    @staticmethod
    def of(own, batches, floor, trees=np.inf):
        """Of values and errors of the program and Mitsuba's batches. A few trees are not normally distributed: their
        number bounds the degrees of freedom."""
        many = len(batches)
        errors = own[1] ** 2, batches.var(0, ddof=1) / many + floor**2
        variance = sum(errors) + 1e-30
        freedom = variance**2 / (errors[0] ** 2 / (SCRAMBLES - 1) + errors[1] ** 2 / (many - 1) + 1e-60)
        return Scores((own[0] - batches.mean(0)) / np.sqrt(variance), np.minimum(freedom, trees - 1))

    def chances(self):
        """Of differences at least as large."""
        return 2 * stats.t.sf(np.abs(self.t), self.freedom)

    def squares(self):
        """Squares of normally distributed numbers as rare."""
        return stats.chi2.isf(self.chances(), 1)


def in_leaves(own, mitsuba, dome):
    """Mitsuba's batches in the facets of the program, in its frames: (batches, leaves, 4, 4)."""
    sums = [mitsuba.facets[:, dome.parts(*leaf)].sum(1) for leaf in own.leaves]
    turns = [to_theta(dome.center(*leaf)) for leaf in own.leaves]
    return np.stack([t @ s for t, s in zip(turns, sums)], 1)


def compare(own, mitsuba, dome):
    """Scores by name: every element in every facet that is resolved, the two special directions, all light up and all
    light down, and the first row of their Mueller matrices, which no choice of exit frames changes."""
    batches = in_leaves(own, mitsuba, dome)
    resolved = own.trees >= FEWEST_TREES
    floor = ROUNDING * batches[:, resolved].mean(0)[:, :1, :1]
    trees = own.trees[resolved][:, None, None]
    scores = {"facets": Scores.of(own.mueller[:, resolved], batches[:, resolved], floor, trees)}
    for name, value in own.delta.items():
        scores[name] = Scores.of(value, mitsuba.delta[name], ROUNDING)
    for name, delta in (("reflected", "specular"), ("transmitted", "undeflected")):
        total = mitsuba.facets[:, above(dome, name)].sum(1) + mitsuba.delta[delta]
        scores[name] = Scores.of(own.sides[name], total[:, 0, 0], ROUNDING)
        scores[f"first row of {name}"] = Scores.of(own.first_row(name, delta, dome), total[:, 0, 1:], ROUNDING)
    return scores


def plain_score(own, mitsuba, dome):
    """What transport without polarization would give: the change of the reflectance, its error, and the largest
    difference from the program in a facet."""
    up = above(dome, "reflected")
    change = mean_and_error((mitsuba.plain - mitsuba.facets[..., 0, 0])[:, up].sum(1))
    reflectance = mitsuba.facets[:, up, 0, 0].sum(1).mean()
    resolved = [i for i in range(len(own.leaves)) if own.trees[i] >= FEWEST_TREES]
    plain = np.stack([mitsuba.plain[:, dome.parts(*own.leaves[i])].sum(1) for i in resolved], 1)
    score = Scores.of(own.mueller[:, resolved, 0, 0], plain, ROUNDING * plain.mean(0))
    return *(change / reflectance), np.abs(score.t).max()

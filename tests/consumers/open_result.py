"""Opens results as their users do, and holds their numbers against each other: open_result.py FILE.nc..."""

import sys

import numpy as np
import xarray as xr


def check(path):
    result = xr.open_dataset(path)
    assert np.isfinite(result.bsdf).all() and np.isfinite(result.bsdf_se).all()

    kept = result.reflected + result.transmitted + result.absorbed + result.side
    lost = result.lost_medium + result.lost_depth + result.lost_numeric
    assert_close("energy", kept + lost, 1.0)

    flux = result.bsdf * result.projected_solid_angle
    assert_close("reflected", flux_through(result, flux, result.theta_o < 90) + result.specular, result.reflected)
    assert_close("transmitted", flux_through(result, flux, result.theta_o > 90) + result.undeflected, result.transmitted)
    print(f"{path}: {dict(result.sizes)}, facets hit: {int((result.facet_trees > 0).sum())}")


def flux_through(result, flux, side):
    """Sum over the facets of one side, per incidence and wavelength."""
    of_incidence = [flux.where(side & (result.facet_incidence == i)).sum("facet") for i in range(result.sizes["incidence"])]
    return xr.concat(of_incidence, "incidence")


def assert_close(what, a, b):
    error = float(abs(a - b).max())
    assert error < 1e-9, f"{what}: differs by {error}"


for path in sys.argv[1:]:
    check(path)

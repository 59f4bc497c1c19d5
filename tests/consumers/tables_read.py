"""numpy, pandas and xarray read exported tables, and find the same numbers: tables_read.py PROGRAM FOLDER"""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

PROGRAM, FOLDER = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve()


def export(form, name):
    command = [PROGRAM, "export", FOLDER / "coloured.nc", "--to", form, "-o", FOLDER / name, "--quiet"]
    subprocess.run([str(c) for c in command], check=True)
    return FOLDER / name


table = pd.read_csv(export("csv", "coloured.csv"), comment="#")
array = pd.DataFrame(np.load(export("npy", "coloured.npy")))
result = xr.open_dataset(FOLDER / "coloured.nc")
assert len(table) == len(array) and np.allclose(table.bsdf, array.bsdf, rtol=1e-12)
assert np.allclose(table.theta_o_deg, array.theta_o, atol=1e-8) and (table.trees == array.trees).all()

facets = array[array.part == 0]
assert np.array_equal(facets.bsdf.to_numpy(), result.bsdf.to_numpy().ravel())
up = facets[facets.theta_o < 90]
flux = (up.bsdf * up.projected_solid_angle).groupby([up.theta_i, up.wavelength]).sum().unstack()
assert np.allclose(flux.to_numpy() + result.specular.to_numpy(), result.reflected.to_numpy(), atol=1e-9)



def merl(result):
    """Red, green and blue, by theta_h, theta_d and phi_d."""
    command = [PROGRAM, "export", FOLDER / f"{result}.nc", "--to", "merl", "-o", FOLDER / f"{result}.binary", "--quiet"]
    subprocess.run([str(c) for c in command], check=True)
    assert tuple(np.fromfile(FOLDER / f"{result}.binary", "<i4", 3)) == (90, 90, 180)
    values = np.fromfile(FOLDER / f"{result}.binary", "<f8", offset=12).reshape(3, 90, 90, 180)
    return np.where(values < 0, np.nan, values * np.array([1, 1.15, 1.66])[:, None, None, None] / 1500)


def luminance(reflectance):
    """Y under D65 of a spectrum that stays constant beyond 400 and 700 nm."""
    nm, _, ybar, _, daylight = np.loadtxt(HOME / "src/colour/cie_5nm.csv", delimiter=",").T
    return (reflectance(nm.clip(400, 700)) * ybar * daylight).sum() / (ybar * daylight).sum()


TO_Y = np.array([0.2126729, 0.7151522, 0.0721750])
HOME = Path(__file__).resolve().parents[2]

# A Lambertian has its Y everywhere, and nothing where a direction is below the horizon.
lambert = np.tensordot(TO_Y, merl("lambert"), 1)
expected = luminance(lambda nm: 0.2 + 0.1 * (nm - 400) / 300) / np.pi
valid = np.isfinite(lambert)
assert np.allclose(lambert[valid], expected, rtol=1e-4), (np.nanmin(lambert), np.nanmax(lambert), expected)

# GGX of roughness 0.5, where both directions are 28.2 degrees from the normal: facets of 9 degrees blur it.
half, diff = np.radians(np.array([42.5**2 / 90, 20.5])), np.radians(90.5)
cos = np.cos(half[0]) * np.cos(half[1]) - np.sin(half[0]) * np.sin(half[1]) * np.cos(diff)
tan2 = np.tan(half[0]) ** 2
g1 = 2 / (1 + np.sqrt(1 + 0.25 * (1 / cos**2 - 1)))
ggx = 1 / (np.pi * 0.25 * np.cos(half[0]) ** 4 * (1 + tan2 / 0.25) ** 2) * g1**2 / (4 * cos**2)
expected = 0.3 * ggx * luminance(lambda nm: 0.3 + 0.7 * (nm - 400) / 300)
value = TO_Y @ merl("coloured")[:, 42, 20, 90]
assert abs(value / expected - 1) < 0.1, (value, expected)
print(f"ok     tables: {len(table)} rows; MERL: {valid.mean():.2f} of the bins valid, {value:.4f} for {expected:.4f}")

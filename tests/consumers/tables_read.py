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

# MERL: the value of a bin against the table, and its invalid bins.
merl = export("merl", "coloured.binary")
assert tuple(np.fromfile(merl, "<i4", 3)) == (90, 90, 180)
red, green, blue = np.fromfile(merl, "<f8", offset=12).reshape(3, 90, 90, 180)
assert (red >= 0).any() and (red == -1).any() and ((red < 0) == (blue < 0)).all()
middle = facets[(facets.theta_i == 34) & (facets.theta_o < 90)]
# theta_h 20 degrees, theta_d 20 degrees, phi_d 90: both directions are 27.9 degrees from the normal.
value = red[int(np.sqrt(20 / 90) * 90), 20, 90] / 1500
assert 0.01 < value < 1, value
print(f"ok     tables: {len(table)} rows, MERL {(red >= 0).mean():.2f} valid")

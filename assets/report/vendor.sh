#!/usr/bin/env bash
# Fetches what pages of results carry with them, by npm, in the version that package.json asks for, into vendor/.
# Not part of a build: what it writes is kept with the sources, so that the program builds without npm or a network.
#
# What was chosen, and why (minified sizes):
#   scans, spectra   uPlot, 51 kB, MIT: axes, logarithmic scales, bands, gaps and a legend with values, drawn on a canvas.
#                    Observable Plot with d3 has 490 kB, the basic bundle of Plotly 1.2 MB.
#   lobe             none. three.js has 2.1 MB before it is minified; WebGL alone would be small, but a canvas is also there where WebGL
#                    is not (old machines, printing, remote desktops), and the tree of the dome is a binary space partition:
#                    walked from the back it draws the facets in an exact painter's order, without a depth buffer.
#   map              none: polygons on a canvas, by the projection that the SVG picture has.
set -euo pipefail
cd "$(dirname "$0")"

scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cp package.json "$scratch"
npm install --prefix "$scratch" --no-audit --no-fund --no-package-lock --silent
package=$scratch/node_modules/uplot
version=$(node -p "require('$package/package.json').version")

mkdir -p vendor
cp "$package/LICENSE" vendor/uPlot.LICENSE
# The banner is an address of the network, and pages of results have none: their text names the library instead.
sed '1{/^\/\*!.*\*\/$/d}' "$package/dist/uPlot.iife.min.js" >vendor/uPlot.min.js
cp "$package/dist/uPlot.min.css" vendor/uPlot.min.css
printf '%s\n' "$version" >vendor/uPlot.version
echo "uPlot $version: $(wc -c <vendor/uPlot.min.js) bytes and $(wc -c <vendor/uPlot.min.css) of style"

#!/bin/sh
# Lone Star geyser, 518,862 points of a terrestrial laser scanner: a ragged sheet with steep walls, holes and outliers.
. "$(dirname "$0")/common.sh"
file=$(input scan/lone_star_518k.ply "PDAL, test/data/ept/source/lone-star.laz (decoded, 515368 4918340 2322 subtracted, as PLY)")
"$strak" fit "$file" -o "$out/geyser.step" --kind surface --size 50 --trim
pictures geyser.step "$file" 1 24 0,1,1 -1,-1,2

#!/bin/sh
# EGM96, the geoid above the ellipsoid at 1,038,240 nodes, metres over degrees.
. "$(dirname "$0")/common.sh"
file=$(input grid/egm96_15.gtx "proj-datumgrid, egm96_15.gtx")
"$strak" fit "$file" -o "$out/geoid.g2" --size 200x120 --tolerance 2 --share 95
pictures geoid.g2 "$file" 2 6 1,1,1 0,0,1

#!/bin/sh
# Mount St. Helens after 1980, 148,885 heights of a USGS digital elevation model.
. "$(dirname "$0")/common.sh"
file=$(input grid/SainteHelens.dem "vtk-data, Data/SainteHelens.dem")
"$strak" fit "$file" -o "$out/volcano.g2" --tolerance 20 --share 99
pictures volcano.g2 "$file" 20 6 -1,1,1 0,-1,1

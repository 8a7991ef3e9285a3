#!/bin/sh
# A cornea by a Placido topographer, 5384 places on 256 half meridians, millimetres; its own figures for the ring of 3 mm
# are 41.46 and 41.98 dioptres.
. "$(dirname "$0")/common.sh"
file=$(input lens/cornea_N01.txt "rPACI, inst/extdata/N01.txt")
"$strak" fit "$file" -o "$out/cornea.step" --tolerance 0.001 --share 99 --trim 1
"$strak" info "$out/cornea.step" --ring 0,0,1.5 --index 1.3375
"$strak" inspect "$file" "$out/cornea.step" --remove sphere
pictures cornea.step "$file" 0.001 24 0.4,0.3,1 0,0,1

#!/bin/sh
# A pressed sheet with holes, 1138 vertices of a mesh.
. "$(dirname "$0")/common.sh"
file=$(input scan/ALSTOM_TEST4.off "CGAL, Data/data/meshes/ALSTOM_TEST4.off")
"$strak" fit "$file" -o "$out/sheet.step" --kind surface --tolerance 0.5 --share 99 --trim
pictures sheet.step "$file" 0.5 24 0,1,1

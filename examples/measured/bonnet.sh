#!/bin/sh
# The bonnet of the DrivAer body: the vertices in x -0.5 to 0.35, z above 0.62, within 0.6 of the middle, metres.
. "$(dirname "$0")/common.sh"
file=$(input scan/drivaer_fastback_body.obj.gz "OpenFOAM, tutorials/incompressibleFluid/drivaerFastback, constant/geometry/body.obj.gz")
gzip -dc "$file" | awk '$1 == "v" && $2 > -0.5 && $2 < 0.35 && $4 > 0.62 && $3 > -0.6 && $3 < 0.6 {print $2, $3, $4}' > "$out/bonnet.xyz"
"$strak" fit "$out/bonnet.xyz" -o "$out/bonnet.step" --kind surface --tolerance 0.001 --share 99 --trim
pictures bonnet.step "$out/bonnet.xyz" 0.001 24 0,1,1 -1,-1,2

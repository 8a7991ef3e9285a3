#!/bin/sh
# Draws the paper's figures 1 to 6: isophotes of the three surfaces before and after fairing.
# Usage: examples/paper/draw.sh [BUILD_FOLDER [OUT_FOLDER]], default build/release and out/paper.
set -eu
cd "$(dirname "$0")/../.."
build=${1:-build/release}
out=${2:-out/paper}
"$build/examples/paper/strak_paper_examples" "$out"
strak="$build/apps/cli/strak"
figure() { "$strak" render "$out/$2.g2" -o "$out/figure-$1.svg" --kind isophotes --view "$3" --light 0,1,1 --lines "$4" --size "$5"; }
figure 1 sphere 1,0,0 8 600x600
figure 2 sphere-local 1,0,0 16 600x600
figure 3 sheet 0,-1,2 16 700x500
figure 4 sheet-local 0,-1,2 16 700x500
figure 5 panel 0,-1,2 12 900x250
figure 6 panel-local 0,-1,2 16 900x250
echo "figures 1 to 6: $out/figure-*.svg"

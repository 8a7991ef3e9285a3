#!/bin/sh
# Installs what is missing, builds the program, fairs the sample hood and says where the results are.
set -eu
cd "$(dirname "$0")/.."
scripts/packages.sh
[ -f build/release/build.ninja ] || cmake --preset release -DSTRAK_BUILD_TESTS=OFF >/dev/null
cmake --build build/release --target strak_cli
mkdir -p out
build/release/apps/cli/strak fair examples/hood/hood.step -o out/hood-fair.step --tolerance 0.5 --report out/report.html
echo
echo "The faired part:   $PWD/out/hood-fair.step"
echo "Before and after:  $PWD/out/report.html  (open it in a browser)"

#!/bin/sh
# Installs what is missing, builds everything and runs all tests.
set -eu
cd "$(dirname "$0")/.."
scripts/packages.sh test
cmake --preset release -DSTRAK_BUILD_TESTS=ON >/dev/null
cmake --build build/release
ctest --test-dir build/release --output-on-failure -j2 2>&1 | tee build/release/tests.log
# The pipe hides ctest's own exit code: the summary line decides.
grep -q '^100% tests passed' build/release/tests.log

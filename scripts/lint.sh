#!/bin/sh
# Checks formatting, and runs clang-tidy on the library and the program. Needs clang-format and clang-tidy 14 and a
# configured build/release.
set -eu
cd "$(dirname "$0")/.."
git ls-files '*.h' '*.cpp' | xargs clang-format --dry-run --Werror
git ls-files 'strak/*.cpp' 'apps/*.cpp' | grep -v simd | xargs -P 2 -n 4 clang-tidy -p build/release --quiet

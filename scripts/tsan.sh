#!/bin/sh
# Builds the tests with the thread sanitizer and runs them. Debian's oneTBB is not instrumented: the sanitizer would see no
# hand-over of tasks and report every one as a race. So its source package is built first, into build/tbb-tsan.
# Needs what scripts/packages.sh test installs, and the network.
set -eu
cd "$(dirname "$0")/.."
tbb=$PWD/build/tbb-tsan
if [ ! -f "$tbb/lib/libtbb.so" ]; then
  work=$(mktemp -d)
  trap 'rm -rf "$work"' EXIT
  # The source packages of the distribution's own lists, without touching those.
  mkdir -p "$work/lists/partial"
  : > "$work/sources.list"
  for list in /etc/apt/sources.list /etc/apt/sources.list.d/*.list; do
    [ -f "$list" ] && sed -n 's/^deb /deb-src /p' "$list" >> "$work/sources.list"
  done
  mkdir "$work/parts"
  for list in /etc/apt/sources.list.d/*.sources; do
    [ -f "$list" ] && sed 's/^Types:.*/Types: deb-src/' "$list" > "$work/parts/$(basename "$list")"
  done
  apt_get() {
    apt-get -qq -o Dir::Etc::SourceList="$work/sources.list" -o Dir::Etc::SourceParts="$work/parts" \
      -o Dir::State::Lists="$work/lists" -o APT::Sandbox::User=root "$@"
  }
  apt_get update
  (cd "$work" && apt_get source --download-only onetbb)
  mkdir "$work/source"
  tar -xf "$work"/onetbb_*.orig.tar.* -C "$work/source" --strip-components=1
  cmake -S "$work/source" -B "$work/build" -G Ninja -DCMAKE_BUILD_TYPE=RelWithDebInfo -DTBB_SANITIZE=thread -DTBB_TEST=OFF \
    -DTBB_STRICT=OFF -DTBBMALLOC_BUILD=OFF -DCMAKE_INSTALL_PREFIX="$tbb" -DCMAKE_INSTALL_LIBDIR=lib > /dev/null
  cmake --build "$work/build" --target install > /dev/null
fi
cmake --preset tsan -DCMAKE_PREFIX_PATH="$tbb"
cmake --build --preset tsan
TSAN_OPTIONS=halt_on_error=1 ctest --preset tsan "$@"

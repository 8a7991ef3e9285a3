#!/bin/sh
# Installs the Debian 12 packages that are missing. Usage: scripts/packages.sh [test] [bench]
set -eu
packages="g++ cmake ninja-build libeigen3-dev libtbb-dev libfmt-dev libcli11-dev nlohmann-json3-dev zlib1g-dev
  libocct-foundation-dev libocct-modeling-data-dev libocct-modeling-algorithms-dev libocct-visualization-dev
  libocct-ocaf-dev libocct-data-exchange-dev"
for what in "$@"; do
  case $what in
    test) packages="$packages libgtest-dev librapidcheck-dev" ;;
    bench) packages="$packages libbenchmark-dev libsisl-dev" ;;
    *) echo "packages.sh: unknown set '$what': choose test or bench" >&2; exit 2 ;;
  esac
done
missing=""
for package in $packages; do
  dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null | grep -qx installed || missing="$missing $package"
done
[ -n "$missing" ] || exit 0
echo "Installing:$missing"
root=""
if [ "$(id -u)" != 0 ]; then
  command -v sudo >/dev/null || { echo "packages.sh: run as root, or install sudo, or install by hand:$missing" >&2; exit 1; }
  root="sudo"
fi
$root apt-get update -qq
# shellcheck disable=SC2086
$root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $missing >/dev/null

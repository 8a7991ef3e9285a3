# What the examples of this folder share; read by each of them.
#   DATA    the folder of the measured files, default $STRAK_DATA or ../shared/data beside the project
#   BUILD   the build folder, default build/release
#   OUT     where results go, default out/measured
set -eu
cd "$(dirname "$0")/../.."
data=${DATA:-${STRAK_DATA:-../shared/data}}
strak=${BUILD:-build/release}/apps/cli/strak
out=${OUT:-out/measured}
if [ ! -x "$strak" ]; then
  echo "there is no program '$strak': build it first, or name the build folder: BUILD=... $0" >&2
  exit 2
fi

# input FILE ORIGIN: the path of a measured file, or a sentence where it is to be had and exit 77 (for tests: skipped).
input() {
  if [ ! -f "$data/$1" ]; then
    echo "'$data/$1' is not here: get it from $2, and name the folder above it: DATA=... $0" >&2
    exit 77
  fi
  echo "$data/$1"
}

# pictures FIT FILE TOLERANCE LINES LIGHT [VIEW]: figures of the deviation and both drawings of $out/FIT.
pictures() {
  name=${1%.*}
  view=${6:+--view $6}
  "$strak" inspect "$2" "$out/$1" --tolerance "$3" --picture "$out/$name-deviation.svg" $view
  "$strak" render "$out/$1" -o "$out/$name-isophotes.svg" --kind isophotes --lines "$4" --light "$5" $view
}
mkdir -p "$out"

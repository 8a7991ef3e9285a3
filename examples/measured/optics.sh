#!/bin/sh
# What interferometers measured, with the figures that others published: a lens (peak to valley 330.7 nm, RMS 44.591 nm) and
# four mirrors (RMS 3.048, 2.505, 97.356, 47.577 nm without their parabola).
. "$(dirname "$0")/common.sh"
lens=$(input lens/zygo_interferogram.dat "prysm, sample_files/valid_zygo_dat_file.dat")
# Fair: the noise of single samples is gone, and the peaks with it. Then a control point a sample: the peaks are single samples.
"$strak" fit "$lens" -o "$out/lens.g2" --size 100
"$strak" inspect "$lens" "$out/lens.g2" --remove mean --tolerance 5e-6 --picture "$out/lens-deviation.svg"
"$strak" fit "$lens" -o "$out/lens-samples.g2" --size 425x432 --smoothing 1e-28 --most-points 200000
"$strak" inspect "$lens" "$out/lens-samples.g2" --remove mean
for mirror in 010 012 015 017; do
  profile=$(input profile/dabam-$mirror.dat "DabamFiles, dabam-$mirror.dat")
  "$strak" fit "$profile" -o "$out/mirror.g2" --columns 1,2 --kind function --quiet
  echo "mirror $mirror, nm:"
  "$strak" inspect "$profile" "$out/mirror.g2" --columns 1,2 --remove quadric
done

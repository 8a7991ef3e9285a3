#!/usr/bin/env python3
"""Franke's function with noise: strak beside FITPACK (scipy) and Open CASCADE, in one run, on one thread, as processor
seconds and ratios.

    bench/peers/fitting.py BUILD/bench [COUNT]

Scattered points: FITPACK is given the same 50 x 50 control points (least squares without smoothing), and its smoothing
spline with the exact noise, which chooses its own knots. Grids of 50 x 50 and 100 x 100, all that Open CASCADE
approximates: its approximation with three times the noise as tolerance, its variational form, and FITPACK's smoothing
spline of grids with the exact noise. Needs python3-scipy.
"""
import json
import math
import os
import pathlib
import subprocess
import sys
import time

os.environ["OPENBLAS_NUM_THREADS"] = os.environ["OMP_NUM_THREADS"] = "1"
import numpy
from scipy.interpolate import LSQBivariateSpline, RectBivariateSpline, SmoothBivariateSpline


def mersenne_twister_64(seed):
    """std::mt19937_64."""
    mask, state = (1 << 64) - 1, [seed]
    for i in range(1, 312):
        state.append((6364136223846793005 * (state[-1] ^ (state[-1] >> 62)) + i) & mask)
    while True:
        for i in range(312):
            x = (state[i] & ~0x7FFFFFFF & mask) | (state[(i + 1) % 312] & 0x7FFFFFFF)
            state[i] = state[(i + 156) % 312] ^ (x >> 1) ^ (0xB5026F5AA96619E9 if x & 1 else 0)
        for y in list(state):
            y ^= (y >> 29) & 0x5555555555555555
            y ^= (y << 17) & 0x71D67FFFEDA60000
            y ^= (y << 37) & 0xFFF7EEE000000000
            yield (y ^ (y >> 43)) & mask


def franke(x, y):
    return (0.75 * numpy.exp(-((9 * x - 2) ** 2 + (9 * y - 2) ** 2) / 4)
            + 0.75 * numpy.exp(-((9 * x + 1) ** 2) / 49 - (9 * y + 1) / 10)
            + 0.5 * numpy.exp(-((9 * x - 7) ** 2 + (9 * y - 3) ** 2) / 4)
            - 0.2 * numpy.exp(-((9 * x - 4) ** 2) - (9 * y - 7) ** 2))


def points(count):
    draws = mersenne_twister_64(42)
    u = numpy.array([[(next(draws) >> 11) * 2.0 ** -53 for _ in range(4)] for _ in range(count)])
    noise = numpy.sqrt(-2 * numpy.log(1 - u[:, 2])) * numpy.cos(2 * math.pi * u[:, 3])
    return u[:, 0], u[:, 1], franke(u[:, 0], u[:, 1]) + 0.01 * noise


def error(spline):
    grid = numpy.arange(200) / 199
    return math.sqrt(numpy.mean((spline(grid, grid) - franke(grid[:, None], grid[None, :])) ** 2))


def benchmark(program, filter):
    run = subprocess.run([program, f"--benchmark_filter={filter}", "--benchmark_format=json"],
                         check=True, capture_output=True, text=True)
    return [(b["name"], b["cpu_time"] / 1000, b["true_rms"])
            for b in json.JSONDecoder().raw_decode(run.stdout)[0]["benchmarks"] if not b.get("error_occurred")]


def timed(name, fit):
    start = time.process_time()
    spline = fit()
    return name, time.process_time() - start, error(spline)


def table(title, rows):
    print(title)
    for name, seconds, rms in rows:
        print(f"  {name:34} {seconds:8.3f} s {seconds / rows[0][1]:7.2f} x   rms {rms:.3g}")


def scattered(folder, count):
    x, y, z = points(count)
    rows = [(f"strak, {name.split('/')[1]}", seconds, rms)
            for name, seconds, rms in benchmark(folder / "bench_fitting", f"franke.*/{count}/")]
    knots = numpy.linspace(0, 1, 48)[1:-1]
    rows.append(timed("FITPACK 50 x 50, not smoothed", lambda: LSQBivariateSpline(x, y, z, knots, knots, bbox=[0, 1, 0, 1])))
    rows.append(timed("FITPACK, noise known", lambda: SmoothBivariateSpline(x, y, z, bbox=[0, 1, 0, 1], s=count * 1e-4)))
    table(f"{count} points, sums {x.sum():.12g} {y.sum():.12g} {z.sum():.12g}", rows)


def grids(folder, side):
    x, y, z = points(side * side)
    at = numpy.arange(side) / (side - 1)
    heights = franke(at[:, None], at[None, :]) + (z - franke(x, y)).reshape(side, side)
    rows = [(name.split("/")[0], seconds, rms)
            for name, seconds, rms in benchmark(folder / "bench_fitting_peers", f"/{side}/")]
    rows.append(timed("FITPACK, noise known", lambda: RectBivariateSpline(at, at, heights, s=side * side * 1e-4)))
    table(f"grid of {side} x {side}", rows)


def main():
    folder = pathlib.Path(sys.argv[1])
    scattered(folder, int(float(sys.argv[2])) if len(sys.argv) > 2 else 100000)
    for side in 50, 100:
        grids(folder, side)


if __name__ == "__main__":
    main()

"""Workload A by heyoka, one by one and in batches, beside `LaneTaylor`: see README.md."""

import re
import subprocess
import sys
import time
from pathlib import Path

import heyoka as hy
import numpy as np

HALF_BACKLASH = 6.2e-4
COUNT, TURNS = 64, 20
SPEEDS = np.linspace(0.15 / 63.0, 0.36 / 63.0, COUNT)
START = [-6.4e-4, 0.0]
ROUNDS = 5

# Parameters: slope of the flank (1, or 0 in the gap), its foot, the speed w_c.
SLOPE, FOOT, SPEED = 0, 1, 2


def equations():
    """q'' + 0.02 q' + F(t) f(q) = right-hand side, as in benches/common/mod.rs."""
    x, v = hy.make_vars("x", "v")
    angle = hy.par[SPEED] * hy.time
    norm = 1.0 / (1.0 + 0.3846 * 0.3846 / 2.0)
    radius = 1.0 + 0.3846 * hy.cos(angle)
    stiffness = norm * (1.0 + 0.29 * hy.cos(63.0 * angle)) * radius * radius
    pull = (
        -1.4e-5
        - 5.5e-6 * hy.sin(angle)
        + 2.2e-6 * hy.sin(2.0 * angle)
        + 6.8e-6 * hy.sin(63.0 * angle)
    )
    force = stiffness * hy.par[SLOPE] * (x - hy.par[FOOT])
    return x, [(x, v), (v, pull - 0.02 * v - force)]


def piece(below, above):
    """Slope and foot of the flank on which the contact stands."""
    return (1.0, -HALF_BACKLASH) if below else (1.0, HALF_BACKLASH) if above else (0.0, 0.0)


class OneByOne:
    def __init__(self, tolerance):
        x, system = equations()
        self.crossings = 0
        edges = [
            hy.t_event(x + HALF_BACKLASH, callback=self.crosses(lower=True)),
            hy.t_event(x - HALF_BACKLASH, callback=self.crosses(lower=False)),
        ]
        self.run_of = hy.taylor_adaptive(system, START, tol=tolerance, t_events=edges)

    def crosses(self, lower):
        def change(ta, sign):
            self.crossings += 1
            ta.pars[SLOPE], ta.pars[FOOT] = piece(lower and sign < 0, not lower and sign > 0)
            return True

        return change

    def run(self):
        ends = []
        for speed in SPEEDS:
            ta = self.run_of
            ta.time = 0.0
            ta.state[:] = START
            ta.pars[:] = [*piece(True, False), speed]
            ta.reset_cooldowns()
            outcome = ta.propagate_until(TURNS * 2.0 * np.pi / speed)[0]
            assert outcome == hy.taylor_outcome.time_limit, outcome
            ends.append(ta.state.copy())
        return np.array(ends)


class Batches:
    def __init__(self, tolerance, width):
        x, system = equations()
        self.width = width
        edges = [
            hy.t_event_batch(x + HALF_BACKLASH, callback=self.crosses(lower=True)),
            hy.t_event_batch(x - HALF_BACKLASH, callback=self.crosses(lower=False)),
        ]
        start = np.repeat(np.array(START)[:, None], width, axis=1)
        self.run_of = hy.taylor_adaptive_batch(system, start, tol=tolerance, t_events=edges)

    @staticmethod
    def crosses(lower):
        def change(ta, sign, lane):
            ta.pars[SLOPE, lane], ta.pars[FOOT, lane] = piece(
                lower and sign < 0, not lower and sign > 0
            )
            return True

        return change

    def run(self):
        ends = []
        for speeds in SPEEDS.reshape(-1, self.width):
            ta = self.run_of
            ta.set_time(0.0)
            ta.state[:] = np.array(START)[:, None]
            slope, foot = piece(True, False)
            ta.pars[SLOPE], ta.pars[FOOT], ta.pars[SPEED] = slope, foot, speeds
            ta.reset_cooldowns()
            ta.propagate_until(TURNS * 2.0 * np.pi / speeds)
            assert all(o[0] == hy.taylor_outcome.time_limit for o in ta.propagate_res)
            ends.append(ta.state.T.copy())
        return np.concatenate(ends)


def least(job):
    times = []
    for _ in range(ROUNDS):
        begun = time.perf_counter()
        ends = job()
        times.append(time.perf_counter() - begun)
    return min(times) / COUNT * 1e3, ends


def main():
    print(f"heyoka {hy.__version__}, {hy.recommended_simd_size()} lanes recommended")
    truth, finer = OneByOne(1e-16).run(), OneByOne(1e-15).run()
    size = np.abs(truth).max(axis=0)
    # Where two fine runs differ by more, the motion is sensitive and its end says nothing about a tolerance.
    plain = (np.abs(finer - truth) / size).max(axis=1) < 1e-10
    best = np.inf
    for tolerance in [1e-10, 1e-12]:
        jobs = [("one by one", OneByOne(tolerance))]
        jobs += [(f"batches of {width}", Batches(tolerance, width)) for width in (4, 8)]
        for name, job in jobs:
            job.run()
            each, ends = least(job.run)
            off = (np.abs(ends - truth) / size).max(axis=1)[plain]
            print(
                f"heyoka, tolerance {tolerance:g}, {name}: {each:.3f} ms a run, ends off by "
                f"{np.median(off):.1e} (median of {plain.sum()})"
            )
            best = min(best, each)
    root = Path(__file__).resolve().parents[2]
    command = ["cargo", "bench", "-p", "benches", "--bench", "series_lanes"]
    out = subprocess.run(command, cwd=root, check=True, capture_output=True, text=True).stdout
    print(out, end="")
    lanes = float(re.search(r"^A: .*, ([\d.]+) ms a row;", out, re.M).group(1))
    print(f"ratio lanes-taylor heyoka {best / lanes:.2f}")


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What Python costs: the ratios that docs/python.md states, each taken within one run on this machine.

    scripts/python && PYTHONPATH=build/python /usr/bin/python3 benchmarks/python_overhead.py [quick]
"""

import os
import platform
import resource
import sys
import time
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

import kalfem as kf
from plain_ukf import chain_filter

QUICK = "quick" in sys.argv[1:]
CASE = Path(__file__).parents[1] / "examples/chain/chain.yaml"
RATE = 1000.0
PLACES = {"a3": "body.2", "a5": "body.4", "a7": "body.6", "a11": "body.10"}
UNKNOWN = {"suspension.mu_k1": (10.0, "50 %"), "suspension.mu_c1": (16.0, "50 %")}
LAW = dict(k=5e3, mu_k1=20.0, mu_k2=2e-3, c=10.0, mu_c1=10.0, mu_c2=0.05)


def structure():
    """The chain of examples/chain: 24 states with its two unknowns."""
    s = kf.Structure()
    s.add(kf.lumped("wheel").mass("w", 1.5).spring("k_w", "ground", "w", 2e4))
    s.add(kf.chain("body", 10, mass=1.0, stiffness=3e4).modal_damping(0.01))
    s.connect("suspension", "wheel.w", "body.1", law="saturating", parameters=LAW)
    return s.base_displacement("road", "wheel.ground")


def sensors(noise):
    return {name: kf.acceleration(place, noise=noise) for name, place in PLACES.items()}


class Measured:
    """The record of the case."""

    def __init__(self, seconds):
        run = kf.run(CASE, set={"simulate.duration": f"{seconds} s"}, steps="simulate", progress=False)
        self.t, self.u = np.asarray(run["time"]), np.ascontiguousarray(run["inputs/road"])
        self.y = {name: np.ascontiguousarray(run[f"measurements/{name}"]) for name in PLACES}
        self.table = np.column_stack([self.y[name] for name in PLACES])
        self.noise = 0.15 * float(np.sqrt(np.mean(self.table**2)))


def live(data, **options):
    return kf.Filter(structure(), RATE, sensors=sensors(data.noise), unknown=UNKNOWN, **options)


def timed(work):
    """Processor time [s]: what else the machine does counts little."""
    begin = time.process_time()
    work()
    return time.process_time() - begin


def in_cpp(data, samples):
    filter = live(data)
    filter.update(data.table[0])
    u, y = data.u[1:samples, None].copy(), data.table[1:samples].copy()
    return timed(lambda: filter.advance(u, y)) / (samples - 1)


def in_python(data, samples):
    filter = live(data)
    filter.update(data.table[0])
    u, y = data.u[:samples, None].copy(), data.table[:samples].copy()

    def loop():
        for k in range(1, samples):
            filter.predict(u[k])
            filter.update(y[k])

    return timed(loop) / (samples - 1)


def by_blocks(data, samples, block=1000):
    filter = live(data)

    def push():
        for first in range(0, samples, block):
            t = first / RATE
            filter.push("road", t, data.u[first : first + block])
            for name in PLACES:
                filter.push(name, t, data.y[name][first : first + block])

    return timed(push) / samples


def in_turn(*works, times=7):
    """Least results of several works that take turns."""
    return [min(results) for results in zip(*[[work() for work in works] for _ in range(times)])]


def steps(data):
    samples = 5000
    cpp, python, blocks = in_turn(
        lambda: in_cpp(data, samples), lambda: in_python(data, samples), lambda: by_blocks(data, samples)
    )
    print(f"step in C++                               {1e6 * cpp:8.2f} us (24 states)")
    print(f"live.predict + live.update over it        {1e6 * (python - cpp):8.2f} us, at most 3")
    print(f"live.push, blocks of 1,000, over it       {1e6 * (blocks - cpp):8.3f} us a sample, at most 0.1")
    return cpp


def whole_record():
    """kf.estimate over 20,000 samples against the step `estimate` of the case, in turn."""
    data = Measured(20)

    def case(steps):
        return timed(lambda: kf.run(CASE, steps=steps, progress=False))

    def estimate():
        return timed(
            lambda: kf.estimate(
                structure(), data.t, data.y, sensors=sensors(data.noise), inputs={"road": data.u}, unknown=UNKNOWN,
                settle=2.0, progress=False,
            )
        )

    ours, with_filter, without = in_turn(
        estimate, lambda: case("estimate"), lambda: case("simulate"), times=2 if QUICK else 5
    )
    ratio = ours / (with_filter - without)
    print(f"kf.estimate of {len(data.t)} samples             {ratio:8.3f} of the command's filter time, at most 1.05")


def plain(data, step):
    """A filter in NumPy as it is commonly written, over the same samples."""
    filter = chain_filter(RATE, data.noise)
    samples = 100 if QUICK else 300

    def loop():
        for k in range(1, samples):
            filter.predict((data.u[k - 1], data.u[k]))
            filter.update(data.table[k], (data.u[k - 1], data.u[k]))

    plain_step = timed(loop) / (samples - 1)
    print(f"plain unscented filter in NumPy           {1e6 * plain_step:8.0f} us a step, {plain_step / step:.0f} times as long, at least 100")


def resident():
    """Memory of this process [MB]."""
    with open("/proc/self/status") as status:
        return next(int(line.split()[1]) for line in status if line.startswith("VmRSS")) / 1024


def memory():
    runs = 1000 if QUICK else 10_000
    short = {"simulate.duration": "0.1 s", "excitation.road.random.fade_in": "0.02 s", "simulate.tolerance": 0.1, "estimate.settle": "0 s", "estimate.diagnose": False}

    def once():
        kf.run(CASE, set=short, progress=False)

    for _ in range(50):
        once()
    before = resident()
    for _ in range(runs):
        once()
    print(f"memory after {runs:6d} runs in one process   {resident() - before:8.2f} MB more, at most 10")


def imports():
    import subprocess

    program = "import time; t = time.perf_counter(); import kalfem; kalfem.Structure; print(time.perf_counter() - t)"
    seconds = min(
        float(subprocess.run([sys.executable, "-c", program], capture_output=True, check=True).stdout) for _ in range(7)
    )
    print(f"import kalfem                             {1e3 * seconds:8.0f} ms, at most 150")


def main():
    cpu = next((line.split(":")[1].strip() for line in open("/proc/cpuinfo") if line.startswith("model name")), "?")
    print(f"{cpu}, {os.cpu_count()} processors, Python {platform.python_version()}, NumPy {np.__version__}")
    imports()
    data = Measured(6)
    step = steps(data)
    plain(data, step)
    whole_record()
    memory()
    print(f"largest memory                            {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:8.0f} MB")


if __name__ == "__main__":
    main()

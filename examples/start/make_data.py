# SPDX-License-Identifier: Apache-2.0
"""Makes the records and meshes of these cases: simulated, with the faults of a real test.

    PYTHONPATH=build/python python3 examples/start/make_data.py
"""

import math
from pathlib import Path

import numpy as np

import kalfem as kf

HERE = Path(__file__).parent

QUARTER_CAR = """
kalfem: 1
substructures:
  wheel: {masses: {m: 40 kg}, springs: [{from: ground, to: m, stiffness: 180 kN/m, damping: 50 N s/m}]}
  body: {masses: {m: 300 kg}}
connectors:
  suspension: {from: wheel.m, to: body.m, law: cubic, parameters: {k: 18 kN/m, k3: 1.2e7 N/m^3, c: 1200 N s/m}}
excitation: {road: {base_displacement: wheel.ground, random: {rms: 6 mm, band: [0.3, 12 Hz], seed: 5}}}
sensors: {body: {acceleration: body.m, noise: 1e-6 m/s^2}, wheel: {acceleration: wheel.m, noise: 1e-6 m/s^2}}
simulate: {duration: 20.5 s, sample_rate: 1000 Hz, tolerance: 1e-5, seed: 1}
"""


def quarter_car(folder):
    """Road and two accelerations at 200 Hz: noise, the body's channel 8 ms late with an offset, a gap in the wheel's."""
    case = folder / "truth.yaml"
    case.write_text(QUARTER_CAR)
    run = kf.run(case, progress=False)
    case.unlink()
    noise = np.random.default_rng(3)
    body, wheel, road = (np.asarray(run[name]) for name in ("measurements/body", "measurements/wheel", "inputs/road"))
    kept = np.arange(200, 20201, 5)
    body = body[kept - 8] + 0.15 + 0.05 * noise.standard_normal(kept.size)
    wheel = wheel[kept] + 0.3 * noise.standard_normal(kept.size)
    with open(folder / "quarter_car.csv", "w") as file:
        file.write("t_s,road_mm,body_m_s2,wheel_m_s2\n")
        for i, sample in enumerate(kept):
            gap = 5.0 <= i / 200 < 5.4
            file.write(f"{i / 200:.3f},{1e3 * road[sample]:.3f},{body[i]:.3f},{'' if gap else f'{wheel[i]:.2f}'}\n")


def damper(folder):
    """k x + c v + 180 N of dry friction, at 200 Hz for 15 s, with 8 N of noise."""
    noise = np.random.default_rng(4)
    t = np.arange(0, 15.0 + 1e-9, 0.005)
    x = np.zeros_like(t)
    v = np.zeros_like(t)
    for frequency, amplitude, phase in ((0.7, 12e-3, 0.3), (1.9, 5e-3, 1.1), (4.3, 1.5e-3, 2.0)):
        omega = 2 * math.pi * frequency
        x += amplitude * np.sin(omega * t + phase)
        v += amplitude * omega * np.cos(omega * t + phase)
    force = 6e3 * x + 900 * v + 180 * np.tanh(v / 5e-3) + 8 * noise.standard_normal(t.size)
    with open(folder / "damper.csv", "w") as file:
        file.write("t_s,displacement_mm,velocity_mm_s,force_N\n")
        for row in zip(t, 1e3 * x, 1e3 * v, force):
            file.write("{:.3f},{:.4f},{:.3f},{:.1f}\n".format(*row))


def plate(folder):
    """0.6 m x 0.4 m x 4 mm of steel, clamped at x = 0. Frequencies of 203 GPa and 0.55 kg on the tip, with 0.3 % of noise."""
    columns, rows, length, width = 12, 8, 0.6, 0.4
    number = lambda i, j: 100 * (i + 1) + j + 1
    cards = ["CEND", "SPC = 1", "BEGIN BULK", "MAT1,1,2.1+11,,0.3,7850.", "PSHELL,1,1,4.-3,1,,1"]
    for i in range(columns + 1):
        for j in range(rows + 1):
            cards.append(f"GRID,{number(i, j)},,{length * i / columns:.5f},{width * j / rows:.5f},0.")
    for i in range(columns):
        for j in range(rows):
            corners = (number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1))
            cards.append(f"CQUAD4,{rows * i + j + 1},1," + ",".join(map(str, corners)))
    cards += [f"SPC1,1,123456,{number(0, j)}" for j in range(rows + 1)]
    (folder / "plate.bdf").write_text("\n".join(cards + ["ENDDATA", ""]))
    (folder / "frequencies.csv").write_text("mode,f_Hz\n" + "".join(f"{k + 1},10\n" for k in range(6)))
    truth = {"substructures.plate.finite_elements.masses.tip.mass": "0.55 kg", "update": None,
             "substructures.plate.finite_elements.materials": {"mat1": {"youngs_modulus": 203e9, "density": 7850}}}
    run = kf.run(folder / "case.yaml", set=truth, steps="modes", progress=False)
    found = run.summary["model"]["substructures"]["plate"]["frequencies_hz"][:6]
    noise = np.random.default_rng(6).standard_normal(6)
    rows = [f"{k + 1},{f * (1 + 0.003 * e):.2f}" for k, (f, e) in enumerate(zip(found, noise))]
    (folder / "frequencies.csv").write_text("\n".join(["mode,f_Hz", *rows, ""]))


def ladder_frame(folder):
    """Two rails of 3 m and four cross members of one steel tube."""
    nodes, elements = ["node,x,y,z"], ["element,node1,node2,region"]
    for side, y in ((0, -0.4), (1, 0.4)):
        for i in range(7):
            nodes.append(f"{10 * side + i + 1},{0.5 * i},{y},0")
    pairs = [(10 * s + i + 1, 10 * s + i + 2, "rail") for s in (0, 1) for i in range(6)]
    pairs += [(i + 1, i + 11, "cross") for i in (0, 2, 4, 6)]
    elements += [f"{k + 1},{a},{b},{region}" for k, (a, b, region) in enumerate(pairs)]
    (folder / "nodes.csv").write_text("\n".join(nodes) + "\n")
    (folder / "beams.csv").write_text("\n".join(elements) + "\n")


quarter_car(HERE / "measured")
damper(HERE / "component")
plate(HERE / "plate")
ladder_frame(HERE / "vehicle")

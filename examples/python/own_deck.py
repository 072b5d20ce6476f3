# SPDX-License-Identifier: Apache-2.0
# A deck of your own with a measured CSV file: a steel portal frame (examples/cpp/frame.bdf) whose beam rests on a
# rubber mount with unknown cubic stiffness. A shaker drives one corner; three accelerometers record.

# %% The frame from its Nastran deck, reduced to the modes up to 200 Hz, and the mount under a quarter of the beam
import numpy as np

import kalfem as kf


def frame_on_mount(k3):
    nodes = {"left": 5, "seat": 11, "right": 13}  # by their numbers in the deck
    frame = kf.read_deck("examples/cpp/frame.bdf", name="frame", nodes=nodes, mass_matrix="consistent")
    s = kf.Structure()
    s.add(frame.modal_damping(0.01, up_to=1000.0).reduce(up_to=200.0, boundary=list(nodes)))
    s.connect("mount", "frame.seat.z", "ground", law="k*x + k3*x^3 + c*v", parameters=dict(k=2e4, k3=k3, c=10.0))
    return s.force("shaker", "frame.left.x")


sensors = {
    "left": kf.acceleration("frame.left.x", noise=0.5),
    "seat": kf.acceleration("frame.seat.z", noise=0.5),
    "right": kf.acceleration("frame.right.x", noise=0.5),
}


# %% The measured file. There is no frame in this room, so a simulation writes it; leave this cell out with a real one
def write_measured(file):
    rate = 2000.0
    t = np.arange(6000) / rate
    force = 60 * np.sin(2 * np.pi * (5 + 5 * t) * t)
    record = kf.simulate(frame_on_mount(k3=4e9), t, sensors=sensors, inputs={"shaker": force}, seed=3)
    table = np.column_stack([t, force, *record.values()])
    header = "t [s],shaker [N],left [m/s^2],seat [m/s^2],right [m/s^2]"
    np.savetxt(file, table, delimiter=",", header=header, comments="")


write_measured("measured.csv")

# %% Estimate the mount from the file
file = kf.read("measured.csv")
print(file)
model = frame_on_mount(k3=2e9)
run = kf.estimate(
    model,
    file["shaker"].t,
    file,
    sensors=sensors,
    inputs={"shaker": file["shaker"]},
    unknown={"mount.k3": (2e9, "60 %"), "mount.c": (15.0, "50 %")},
    outputs={"mount/deformation": kf.deformation("mount"), "mount/force": kf.force("mount")},
    settle=0.5,
)
print(run)

# %% What was not measured: the mount's force
force = run["estimate/mount/force"]
print(f"largest force in the mount: {abs(force).max():.1f} +- {force.std[abs(force).argmax()]:.1f} N")
run.plot("law").savefig("law.png", dpi=120)
run.plot("innovations").savefig("innovations.png", dpi=120)

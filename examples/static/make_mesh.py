#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes hole.msh: a quarter of a square plate, 200 mm wide, with a hole of 20 mm in the middle.

The rays of the mesh run from the hole to the sides, ever longer away from the hole. Groups: plate; left and bottom, the
planes of symmetry; end, the side that is pulled."""
import math
import pathlib

RADIUS, HALF_WIDTH = 10.0, 100.0  # [mm]
AROUND, OUTWARDS, GROWTH = 24, 24, 1.16


def place(ray, ring):
    angle = 0.5 * math.pi * ray / AROUND
    direction = (math.cos(angle), math.sin(angle))
    outer = HALF_WIDTH / max(direction)
    share = (GROWTH**ring - 1.0) / (GROWTH**OUTWARDS - 1.0)
    distance = RADIUS + share * (outer - RADIUS)
    return tuple(round(distance * component, 9) for component in direction)


def node(ray, ring):
    return ray * (OUTWARDS + 1) + ring + 1


def elements():
    """Tuples of Gmsh's type, the group and the nodes."""
    for ray in range(AROUND):
        for ring in range(OUTWARDS):
            yield 3, 4, (node(ray, ring), node(ray, ring + 1), node(ray + 1, ring + 1), node(ray + 1, ring))
    for ring in range(OUTWARDS):
        yield 1, 1, (node(AROUND, ring), node(AROUND, ring + 1))
        yield 1, 2, (node(0, ring), node(0, ring + 1))
    for ray in range(AROUND // 2):
        yield 1, 3, (node(ray, OUTWARDS), node(ray + 1, OUTWARDS))


def main():
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", "4"]
    lines += ['1 1 "left"', '1 2 "bottom"', '1 3 "end"', '2 4 "plate"', "$EndPhysicalNames", "$Nodes"]
    places = [place(ray, ring) for ray in range(AROUND + 1) for ring in range(OUTWARDS + 1)]
    lines += [str(len(places))] + [f"{i + 1} {x:.6g} {y:.6g} 0" for i, (x, y) in enumerate(places)]
    cells = list(elements())
    lines += ["$EndNodes", "$Elements", str(len(cells))]
    for i, (kind, group, nodes) in enumerate(cells):
        lines.append(f"{i + 1} {kind} 2 {group} {group} " + " ".join(map(str, nodes)))
    lines.append("$EndElements")
    pathlib.Path(__file__).with_name("hole.msh").write_text("\n".join(lines) + "\n")


main()

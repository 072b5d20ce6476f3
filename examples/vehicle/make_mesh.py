#!/usr/bin/env python3
"""Shell mesh of a laboratory vehicle frame: a ladder of rectangular steel tubes with brackets and an upper structure.

    python3 make_mesh.py frame.msh              the mesh of the example, 7594 nodes
    python3 make_mesh.py --coarse small.msh     the same structure with few nodes, for quick tests
    python3 make_mesh.py --check frame.msh      also checks what it wrote and prints its figures

Every wall is a rectangle between planes of one lattice and is divided by all lattice lines that cross it, so walls that
meet share their nodes. x points forward, y to the left, z up; lengths in m, coordinates on the walls' middle surfaces.
"""

import argparse
import collections
import itertools
import math

LENGTH, WIDTH = 2.0, 0.8
RAIL_WIDTH, RAIL_HEIGHT = 0.04, 0.06
CROSS_WIDTH, CROSS_HEIGHT = 0.03, 0.04
POST_DEPTH, UPPER_HEIGHT = 0.015, 0.015
DECK = 0.58  # underside of the upper ladder
CROSS_MEMBERS = [0.015, 0.52, 1.02, 1.50, 1.985]  # middle planes
POSTS = [0.52, 1.02, 1.50, 1.985]
UPPER_CROSS_MEMBERS = [0.52, 0.86, 1.24, 1.60, 1.985]
BRACKETS = [0.28, 1.74]
BRACKET_LENGTH, BRACKET_DEPTH = 0.10, 0.08

THICKNESS = {"rails": 0.003, "cross_members": 0.002, "brackets": 0.005, "upper": 0.0015}
DENSITY = 7850.0
NODES = 7594

Division = collections.namedtuple("Division", "x y rail_height post bracket halves")
FINE = Division(x=0.0175, y=0.0175, rail_height=3, post=0.0175, bracket=5, halves=True)
COARSE = Division(x=0.3, y=0.4, rail_height=2, post=0.3, bracket=1, halves=False)


def divided(lines, size):
    """The lines with as many between them as bring their distances nearest to the size."""
    lines = sorted({round(line, 9) for line in lines})
    result = [lines[0]]
    for low, high in zip(lines, lines[1:]):
        count = max(1, round((high - low) / size))
        result += [round(low + (high - low) * i / count, 9) for i in range(1, count + 1)]
    return result


def lattice(division):
    """Coordinates of all lattice planes along x, y and z."""
    x = [0.0, LENGTH]
    for middle in CROSS_MEMBERS + UPPER_CROSS_MEMBERS:
        x += [middle - CROSS_WIDTH / 2, middle + CROSS_WIDTH / 2]
    for middle in POSTS + [m for m in CROSS_MEMBERS + UPPER_CROSS_MEMBERS if division.halves]:
        x.append(middle)
    for middle in BRACKETS:
        x += [middle - BRACKET_LENGTH / 2, middle, middle + BRACKET_LENGTH / 2]
    half = RAIL_WIDTH / 2
    y = [0.0, half, RAIL_WIDTH, WIDTH / 2, WIDTH - RAIL_WIDTH, WIDTH - half, WIDTH]
    z = [-BRACKET_DEPTH * i / division.bracket for i in range(division.bracket + 1)]
    z += [0.0, CROSS_HEIGHT, RAIL_HEIGHT] + ([CROSS_HEIGHT / 2] if division.rail_height == 3 else [])
    return divided(x, division.x), divided(y, division.y), sorted({round(v, 9) for v in z}) + divided(
        [RAIL_HEIGHT, DECK], division.post)[1:] + [round(DECK + UPPER_HEIGHT, 9)]


class Mesh:
    """Quadrilaterals by group, with nodes that are found by their coordinates."""

    def __init__(self, planes):
        self.planes = planes
        self.nodes = {}
        self.groups = collections.defaultdict(list)
        self.points = {}

    def node(self, place):
        return self.nodes.setdefault(tuple(round(c, 9) for c in place), len(self.nodes) + 1)

    def wall(self, group, low, high):
        """A rectangle between two opposite corners that agree in one coordinate."""
        normal = next(a for a in range(3) if abs(high[a] - low[a]) < 1e-9)
        u, v = [a for a in range(3) if a != normal]
        lines = [[c for c in self.planes[a] if low[a] - 1e-9 < c < high[a] + 1e-9] for a in (u, v)]
        for (u0, u1), (v0, v1) in itertools.product(*(list(zip(line, line[1:])) for line in lines)):
            cell = []
            for cu, cv in ((u0, v0), (u1, v0), (u1, v1), (u0, v1)):
                place = list(low)
                place[u], place[v] = cu, cv
                cell.append(self.node(place))
            self.groups[group].append(tuple(cell))

    def tube(self, group, low, high, axis):
        """The four long walls of a box along an axis."""
        for a in range(3):
            if a != axis:
                for side in (low, high):
                    one, other = list(low), list(high)
                    one[a] = other[a] = side[a]
                    self.wall(group, one, other)

    def name(self, point, place):
        key = tuple(round(c, 9) for c in place)
        if key not in self.nodes:
            raise SystemExit(f"there is no node at {point} {place}")
        self.points[point] = self.nodes[key]


def bracket(mesh, x, y):
    """Side plates below the webs of a rail, a plate across in their middle and one below them."""
    front, rear, bottom = x - BRACKET_LENGTH / 2, x + BRACKET_LENGTH / 2, -BRACKET_DEPTH
    for side in (y, y + RAIL_WIDTH):
        mesh.wall("brackets", (front, side, bottom), (rear, side, 0.0))
    mesh.wall("brackets", (x, y, bottom), (x, y + RAIL_WIDTH, 0.0))
    mesh.wall("brackets", (front, y, bottom), (rear, y + RAIL_WIDTH, bottom))


def build(division):
    mesh = Mesh(lattice(division))
    half = CROSS_WIDTH / 2
    sides = (0.0, WIDTH - RAIL_WIDTH)
    inner = (RAIL_WIDTH, WIDTH - RAIL_WIDTH)
    for y in sides:
        mesh.tube("rails", (0.0, y, 0.0), (LENGTH, y + RAIL_WIDTH, RAIL_HEIGHT), axis=0)
    for x in CROSS_MEMBERS:
        mesh.tube("cross_members", (x - half, inner[0], 0.0), (x + half, inner[1], CROSS_HEIGHT), axis=1)
    for x, y in itertools.product(BRACKETS, sides):
        bracket(mesh, x, y)
    for x, y in itertools.product(POSTS, sides):
        mesh.tube("upper", (x - POST_DEPTH, y, RAIL_HEIGHT), (x, y + RAIL_WIDTH, DECK), axis=2)
    for y in sides:
        mesh.tube("upper", (UPPER_CROSS_MEMBERS[0] - half, y, DECK), (LENGTH, y + RAIL_WIDTH, DECK + UPPER_HEIGHT), axis=0)
    for x in UPPER_CROSS_MEMBERS:
        mesh.tube("upper", (x - half, inner[0], DECK), (x + half, inner[1], DECK + UPPER_HEIGHT), axis=1)
    return mesh


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--coarse", action="store_true")
    args = parser.parse_args()
    mesh = build(COARSE if args.coarse else FINE)
    print(len(mesh.nodes), {k: len(v) for k, v in mesh.groups.items()})

if __name__ == "__main__":
    main()

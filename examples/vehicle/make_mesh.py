#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
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
DECK = 0.62  # underside of the upper ladder
CROSS_MEMBERS = [0.015, 0.52, 1.02, 1.50, 1.985]  # middle planes
POSTS = [0.52, 1.02, 1.50, 1.985]
UPPER_CROSS_MEMBERS = [0.52, 0.86, 1.24, 1.60, 1.985]
BRACKETS = [0.28, 1.74]
BRACKET_LENGTH, BRACKET_DEPTH = 0.10, 0.08

THICKNESS = {"rails": 0.003, "cross_members": 0.002, "brackets": 0.005, "upper": 0.0015}
DENSITY = 7850.0
NODES = 7594

# Sizes between lattice planes along x, y and the posts; the fine ones were chosen so that NODES come out.
Division = collections.namedtuple("Division", "x y rail_height post bracket halves")
FINE = Division(x=0.0186, y=0.0185, rail_height=3, post=0.019, bracket=5, halves=True)
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
    half, top = CROSS_WIDTH / 2, DECK + UPPER_HEIGHT
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
        mesh.tube("upper", (UPPER_CROSS_MEMBERS[0] - half, y, DECK), (LENGTH, y + RAIL_WIDTH, top), axis=0)
    for x in UPPER_CROSS_MEMBERS:
        mesh.tube("upper", (x - half, inner[0], DECK), (x + half, inner[1], top), axis=1)
    stiffen(mesh)
    return mesh


def stiffen(mesh):
    """Plates across the lower rails where cross-members and posts meet them, and across the upper rails likewise."""
    half, top = CROSS_WIDTH / 2, DECK + UPPER_HEIGHT

    def ends(middles):
        return {round(m + side * half, 9) for m in middles for side in (-1, 1)}

    for y in (0.0, WIDTH - RAIL_WIDTH):
        for x in ends(CROSS_MEMBERS) | {round(p - POST_DEPTH, 9) for p in POSTS} | set(POSTS):
            mesh.wall("rails", (x, y, 0.0), (x, y + RAIL_WIDTH, RAIL_HEIGHT))
        for x in ends(UPPER_CROSS_MEMBERS) | {round(p - POST_DEPTH, 9) for p in POSTS} | set(POSTS):
            mesh.wall("upper", (x, y, DECK), (x, y + RAIL_WIDTH, top))


def name_points(mesh):
    """p1 to p4 below the brackets, front left and right, rear left and right; p5 to p8 where the motion is sought."""
    rear, front = BRACKETS
    right, left = RAIL_WIDTH / 2, WIDTH - RAIL_WIDTH / 2
    top, half = DECK + UPPER_HEIGHT, CROSS_WIDTH / 2
    for point, x, y in (("p1", front, left), ("p2", front, right), ("p3", rear, left), ("p4", rear, right)):
        mesh.name(point, (x, y, -BRACKET_DEPTH))
    mesh.name("p5", (CROSS_MEMBERS[2] + half, WIDTH / 2, CROSS_HEIGHT))
    mesh.name("p6", (LENGTH, 0.0, RAIL_HEIGHT))
    mesh.name("p7", (UPPER_CROSS_MEMBERS[0] - half, WIDTH, top))
    mesh.name("p8", (UPPER_CROSS_MEMBERS[2] + half, WIDTH / 2, top))


def text_of(place):
    return " ".join(f"{c:.6g}" for c in place)


def node_blocks(mesh, places):
    """Blocks of nodes: those of the named points, then those of each group that no earlier block holds."""
    blocks, written = [], set()
    for i, node in enumerate(mesh.points.values(), 1):
        blocks.append((0, i, [node]))
        written.add(node)
    for i, cells in enumerate(mesh.groups.values(), 1):
        own = sorted({node for cell in cells for node in cell} - written)
        blocks.append((2, i, own))
        written.update(own)
    lines = [f"{len(blocks)} {len(places)} 1 {len(places)}"]
    for dimension, entity, nodes in blocks:
        lines.append(f"{dimension} {entity} 0 {len(nodes)}")
        lines += [str(node) for node in nodes] + [text_of(places[node]) for node in nodes]
    return lines


def element_blocks(mesh):
    """A point element for each named point, then the quadrilaterals of each group."""
    count = len(mesh.points) + sum(len(cells) for cells in mesh.groups.values())
    lines = [f"{len(mesh.points) + len(mesh.groups)} {count} 1 {count}"]
    numbers = itertools.count(1)
    for i, node in enumerate(mesh.points.values(), 1):
        lines += [f"0 {i} 15 1", f"{next(numbers)} {node}"]
    for i, cells in enumerate(mesh.groups.values(), 1):
        lines.append(f"2 {i} 3 {len(cells)}")
        lines += [f"{next(numbers)} {' '.join(map(str, cell))}" for cell in cells]
    return lines


def write(mesh, file):
    """Gmsh format 4.1, ASCII: physical points p1 to p8 and a physical surface for each group."""
    places = {number: place for place, number in mesh.nodes.items()}
    names = [f'0 {i} "{name}"' for i, name in enumerate(mesh.points, 1)]
    names += [f'2 {len(mesh.points) + i} "{name}"' for i, name in enumerate(mesh.groups, 1)]
    entities = [f"{len(mesh.points)} 0 {len(mesh.groups)} 0"]
    entities += [f"{i} {text_of(places[node])} 1 {i}" for i, node in enumerate(mesh.points.values(), 1)]
    for i, cells in enumerate(mesh.groups.values(), 1):
        corners = [places[node] for cell in cells for node in cell]
        extent = [pick(place[a] for place in corners) for pick in (min, max) for a in range(3)]
        entities.append(f"{i} {text_of(extent)} 1 {len(mesh.points) + i} 0")
    sections = {"MeshFormat": ["4.1 0 8"], "PhysicalNames": [str(len(names))] + names, "Entities": entities,
                "Nodes": node_blocks(mesh, places), "Elements": element_blocks(mesh)}
    with open(file, "w", encoding="ascii") as stream:
        for name, lines in sections.items():
            stream.write(f"${name}\n" + "\n".join(lines) + f"\n$End{name}\n")


def parts(mesh):
    """Number of parts that no cell joins."""
    parent = list(range(len(mesh.nodes) + 1))

    def root(node):
        while parent[node] != node:
            parent[node] = node = parent[parent[node]]
        return node

    for cell in itertools.chain(*mesh.groups.values()):
        for node in cell:
            parent[root(node)] = root(cell[0])
    return len({root(node) for node in mesh.nodes.values()})


def hanging_nodes(mesh, places):
    """Nodes that lie inside an edge of a cell, which would join nothing there; all edges run along an axis."""
    lines = collections.defaultdict(list)
    for place in mesh.nodes:
        for a in range(3):
            lines[a, place[:a] + place[a + 1:]].append(place[a])
    hanging = 0
    for cell in itertools.chain(*mesh.groups.values()):
        for one, other in zip(cell, cell[1:] + cell[:1]):
            p, q = places[one], places[other]
            a = max(range(3), key=lambda i: abs(p[i] - q[i]))
            low, high = sorted((p[a], q[a]))
            hanging += sum(low < c < high for c in lines[a, p[:a] + p[a + 1:]])
    return hanging


def corner_jacobians(corners):
    """Areas that the two edges at each corner span, positive where they turn as the cell's diagonals do."""
    minus = lambda p, q: [a - b for a, b in zip(p, q)]
    cross = lambda p, q: [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]
    normal = cross(minus(corners[2], corners[0]), minus(corners[3], corners[1]))
    size = math.hypot(*normal)
    return [sum(a * b for a, b in zip(cross(minus(corners[(i + 1) % 4], corners[i]), minus(corners[i - 1], corners[i])),
                                      normal)) / size for i in range(4)]


def check(mesh, expected_nodes):
    """Prints the mesh's figures; ends the program with every fault that was found."""
    places = {number: place for place, number in mesh.nodes.items()}
    cells = list(itertools.chain(*mesh.groups.values()))
    close = {tuple(round(c, 5) for c in place) for place in mesh.nodes}
    aspect, lowest = 1.0, math.inf
    for cell in cells:
        edges = [math.dist(places[p], places[q]) for p, q in zip(cell, cell[1:] + cell[:1])]
        aspect = max(aspect, max(edges) / min(edges))
        lowest = min(lowest, *corner_jacobians([places[node] for node in cell]))
    faults = [text for text, wrong in [
        (f"{len(places)} nodes, not {expected_nodes}", expected_nodes not in (None, len(places))),
        ("two nodes are nearer than 0.01 mm", len(close) != len(places)),
        ("two cells have the same nodes", len({frozenset(cell) for cell in cells}) != len(cells)),
        ("a node belongs to no cell", len({node for cell in cells for node in cell}) != len(places)),
        (f"{parts(mesh)} parts, not one", parts(mesh) != 1),
        (f"{hanging_nodes(mesh, places)} nodes lie inside an edge", hanging_nodes(mesh, places) > 0),
        ("a cell has a Jacobian that is not positive", lowest <= 0.0)] if wrong]
    mass = 0.0
    for group, members in mesh.groups.items():
        area = sum(sum(corner_jacobians([places[node] for node in cell])) / 4 for cell in members)
        mass += area * THICKNESS[group] * DENSITY
        print(f"{group:14} {len(members):5} cells  {area:.4f} m2  {area * THICKNESS[group] * DENSITY:6.2f} kg")
    print(f"{len(places)} nodes, {len(cells)} cells, {mass:.2f} kg in steel, longest to shortest edge {aspect:.1f}")
    if faults:
        raise SystemExit("\n".join(faults))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", help="the .msh file to write")
    parser.add_argument("--coarse", action="store_true", help="few nodes, for quick tests")
    parser.add_argument("--check", action="store_true", help="check the mesh and print its figures")
    args = parser.parse_args()
    mesh = build(COARSE if args.coarse else FINE)
    name_points(mesh)
    write(mesh, args.file)
    if args.check:
        check(mesh, None if args.coarse else NODES)


if __name__ == "__main__":
    main()

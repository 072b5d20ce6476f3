"""A barrel of shells as a Nastran deck: barrel_deck.py AROUND RINGS [--held] > barrel.bdf

AROUND x RINGS nodes, six degrees of freedom each; steel, 0.9 m long, radius 0.24 m at the ends and 0.3 m in the middle, 1.5 mm
thick, free or held at the lower end. 440 x 257 has 678,480 degrees of freedom.
"""
import argparse
import math
import sys

arguments = argparse.ArgumentParser()
arguments.add_argument("around", type=int)
arguments.add_argument("rings", type=int)
arguments.add_argument("--held", action="store_true")
given = arguments.parse_args()

length, end_radius, bulge, thickness = 0.9, 0.24, 0.06, 0.0015


def number(ring, place):
    return 1 + ring * given.around + place % given.around


write = sys.stdout.write
write("SOL 103\nCEND\n" + ("SPC = 1\n" if given.held else "") + "BEGIN BULK\n")
write(f"MAT1,1,2.1E11,,0.3,7850.\nPSHELL,1,1,{thickness},1,,1\n")
for ring in range(given.rings):
    height = ring / (given.rings - 1)
    radius = end_radius + 4.0 * bulge * height * (1.0 - height)
    for place in range(given.around):
        angle = 2.0 * math.pi * place / given.around
        write(f"GRID,{number(ring, place)},,{radius * math.cos(angle):.6f},{radius * math.sin(angle):.6f},{length * height:.6f}\n")
for ring in range(given.rings - 1):
    for place in range(given.around):
        corners = (number(ring, place), number(ring, place + 1), number(ring + 1, place + 1), number(ring + 1, place))
        write(f"CQUAD4,{number(ring, place)},1,{corners[0]},{corners[1]},{corners[2]},{corners[3]}\n")
if given.held:
    write(f"SPC1,1,123456,1,THRU,{given.around}\n")
write("ENDDATA\n")

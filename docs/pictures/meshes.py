# SPDX-License-Identifier: Apache-2.0
"""Meshes with results from the VTU files that a run writes: appended data in binary form."""

import re

import numpy as np

TYPES = {"Int64": np.int64, "Int32": np.int32, "UInt8": np.uint8, "Float64": np.float64, "Float32": np.float32}
CORNERS = {5: 3, 9: 4}  # triangles and quadrilaterals by their VTK number


class Mesh(dict):
    """Arrays by name; tensors and vectors have a row a node or cell."""

    @property
    def cells(self):
        kinds = zip(self["offsets"], self["types"])
        return [self["connectivity"][end - CORNERS[kind] : end] for end, kind in kinds if kind in CORNERS]

    @property
    def triangles(self):
        """Quadrilaterals in two triangles."""
        halves = ([cell[:3], cell[[0, 2, 3]]] if len(cell) == 4 else [cell] for cell in self.cells)
        return np.array([part for parts in halves for part in parts])


def read_vtu(file):
    text = file.read_bytes()
    start = text.index(b"_", text.index(b"<AppendedData")) + 1
    mesh = Mesh()
    for tag in re.findall(rb"<DataArray [^>]*format=\"appended\"[^>]*>", text[:start]):
        found = dict(re.findall(r'(\w+)="([^"]*)"', tag.decode()))
        place = start + int(found["offset"])
        size = int(np.frombuffer(text, np.uint64, 1, place)[0])
        kind = np.dtype(TYPES[found["type"]])
        values = np.frombuffer(text, kind, size // kind.itemsize, place + 8)
        columns = int(found.get("NumberOfComponents", 1))
        mesh[found["Name"]] = values.reshape(-1, columns) if columns > 1 else values
    return mesh

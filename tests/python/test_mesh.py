# SPDX-License-Identifier: Apache-2.0
"""Meshes for PyVista and VTK."""

import sys

import pytest
from kalfem.errors import InvalidInput, MissingPackage
from kalfem.mesh import mesh_of, read_mesh

TRIANGLE = """<?xml version="1.0"?>
<VTKFile type="UnstructuredGrid" version="0.1"><UnstructuredGrid><Piece NumberOfPoints="3" NumberOfCells="1">
<PointData><DataArray type="Float64" Name="height" format="ascii">0 1 2</DataArray></PointData>
<Points><DataArray type="Float64" NumberOfComponents="3" format="ascii">0 0 0 1 0 0 0 1 0</DataArray></Points>
<Cells><DataArray type="Int64" Name="connectivity" format="ascii">0 1 2</DataArray>
<DataArray type="Int64" Name="offsets" format="ascii">3</DataArray>
<DataArray type="UInt8" Name="types" format="ascii">5</DataArray></Cells>
</Piece></UnstructuredGrid></VTKFile>
"""


class Elements:
    """Stands for a finite-element substructure."""

    def write_vtu(self, file, fields):
        assert list(fields) == ["height"]
        with open(file, "w") as opened:
            opened.write(TRIANGLE)


def test_a_mesh_with_its_fields():
    pytest.importorskip("vtkmodules")
    mesh = mesh_of(Elements(), {"height": [[0, 1, 2]]})
    assert mesh.GetNumberOfCells() == 1 and mesh.GetPoint(1) == (1.0, 0.0, 0.0)
    assert mesh.GetPointData().GetArray("height").GetValue(2) == 2.0


def test_an_absent_file_is_told(tmp_path):
    with pytest.raises(InvalidInput, match="there is no file"):
        read_mesh(tmp_path / "absent.vtu")


def test_absent_packages_are_one_message(tmp_path, monkeypatch):
    (tmp_path / "a.vtu").write_text(TRIANGLE)
    monkeypatch.setitem(sys.modules, "pyvista", None)
    monkeypatch.setitem(sys.modules, "vtkmodules.vtkIOXML", None)
    with pytest.raises(MissingPackage, match=r"needs VTK: install python3-vtk9 \(Debian\) or 'pyvista' \(pip\)"):
        read_mesh(tmp_path / "a.vtu")

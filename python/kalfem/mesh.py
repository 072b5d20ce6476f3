# SPDX-License-Identifier: Apache-2.0
"""Meshes for PyVista and VTK."""

from __future__ import annotations

import tempfile
from pathlib import Path

from .errors import InvalidInput, Issue, MissingPackage, optional


def read_mesh(file: str | Path):
    """A ``.vtu`` file as a mesh to draw.

    Parameters
    ----------
    file : path
        One that ``report: {pictures: ...}`` of a case or ``write_vtu`` wrote.

    Returns
    -------
    pyvista.UnstructuredGrid, or vtkUnstructuredGrid
        That of PyVista where it is installed. Fields over the nodes have the names of the file, such as
        ``displacement`` [m].
    """
    if not Path(file).is_file():
        raise InvalidInput(Issue(f"there is no file '{file}'", fix="give the path of a .vtu file"))
    try:
        return optional("pyvista", "read_mesh()").read(str(file))
    except MissingPackage:
        pass
    try:
        reader = optional("vtkmodules.vtkIOXML", "read_mesh()").vtkXMLUnstructuredGridReader()
    except MissingPackage as error:
        message = "drawing a mesh needs VTK: install python3-vtk9 (Debian) or 'pyvista' (pip)"
        raise MissingPackage(message, name="vtkmodules") from error
    reader.SetFileName(str(file))
    reader.Update()
    return reader.GetOutput()


def mesh_of(elements, fields=None):
    """The mesh of a finite-element substructure, as :func:`read_mesh` gives it.

    Parameters
    ----------
    elements : FiniteElements
        What ``kf.read_deck`` returns, or anything else with ``write_vtu(file, fields)``.
    fields : dict of name to array (components x nodes), optional
        Shown over the nodes: ``{"mode 1": shape}``.
    """
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "mesh.vtu"
        elements.write_vtu(str(file), fields or {})
        return read_mesh(file)

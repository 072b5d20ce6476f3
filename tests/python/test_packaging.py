# SPDX-License-Identifier: Apache-2.0
"""The package as it is installed: its wheel, its import, its documentation."""

import ast
import doctest
import importlib
import inspect
import os
import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

import kalfem as kf

PROJECT = Path(__file__).parents[2]
MODULES = ["analysis", "inferring", "law_library", "live", "loading", "modal_identification", "placing", "records", "running", "validating", "vibration", "errors", "series", "results", "grid", "display"]


@pytest.fixture(scope="module")
def wheel():
    found = list((PROJECT / "build/wheel").glob("kalfem-*.whl"))
    if not found:
        pytest.skip("there is no wheel: scripts/python builds it")
    return found[0]


def test_the_wheel_says_what_it_needs(wheel):
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
        metadata = archive.read(next(name for name in names if name.endswith("METADATA"))).decode()
    assert "Requires-Dist: numpy" in metadata and "<2" in metadata
    assert {"kalfem/py.typed", "kalfem/_core.pyi", "kalfem/__init__.py"} <= set(names)
    assert any(name.startswith("kalfem/_core") and name.endswith(".so") for name in names)
    assert "linux" in wheel.name and "cp3" in wheel.name


def test_the_wheel_installs_into_a_fresh_environment(wheel, tmp_path):
    environment = {k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "VIRTUAL_ENV")}
    python = tmp_path / "venv/bin/python"
    subprocess.run(
        ["/usr/bin/python3", "-m", "venv", "--system-site-packages", tmp_path / "venv"], check=True, env=environment
    )
    install = [python, "-m", "pip", "install", "-q", "--no-index", wheel]
    subprocess.run(install, check=True, env=environment, cwd=tmp_path)
    program = "import kalfem as kf; print(kf.__file__); print(len(kf.modes(kf.Structure().add(kf.chain('b', 3, 1.0, 3e4)))))"
    done = subprocess.run([python, "-c", program], check=True, env=environment, cwd=tmp_path, capture_output=True, text=True)
    place, modes = done.stdout.split()
    assert place.startswith(str(tmp_path)) and modes == "3"


def test_the_import_leaves_slow_packages_alone():
    """They cost seconds; benchmarks/python_overhead.py times the rest."""
    program = "import sys; import kalfem as kf; kf.Structure; print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", program], capture_output=True, check=True, text=True).stdout.split()
    assert "numpy" in loaded
    assert not {"scipy", "pandas", "xarray", "matplotlib", "h5py", "vtk", "pyvista", "distributed", "mpi4py"} & set(loaded)


def test_results_need_no_compiled_module():
    program = "import sys; sys.modules['kalfem._core'] = None; import kalfem as kf; kf.read_results, kf.Run; print('read'); kf.Structure"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.stdout == "read\n" and "scripts/python" in done.stderr


def test_another_processor_is_one_message():
    program = "import kalfem._built_for as b; b.FEATURES = ['warp_drive']; import kalfem as kf; kf.Structure"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert "a processor with warp_drive, which this one does not have" in done.stderr.splitlines()[-1]


def test_another_python_is_one_message(tmp_path):
    here = Path(kf.__file__).parent
    shutil.copytree(here, tmp_path / "kalfem", ignore=shutil.ignore_patterns("_core*.so", "_libraries", "__pycache__"))
    (tmp_path / "kalfem/_core.cpython-399-x86_64-linux-gnu.so").touch()
    program = "import kalfem as kf; kf.Structure"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, cwd=tmp_path, env=os.environ | {"PYTHONPATH": str(tmp_path)})
    assert "kalfem was built for cpython-399, and this is Python 3." in done.stderr.splitlines()[-1]


def test_the_version_is_one():
    stated = {
        "CMakeLists.txt": r"project\(kalfem VERSION ([\d.]+)",
        "src/kalfem/base/version.hpp": r'version = "([\d.]+)"',
        "python/pyproject.toml": r'^version = "([\d.]+)"',
        "CITATION.cff": r"^version: ([\d.]+)",
    }
    found = {file: re.search(pattern, (PROJECT / file).read_text(), re.MULTILINE)[1] for file, pattern in stated.items()}
    assert set(found.values()) == {kf.__version__}, found


def test_a_numpy_that_cannot_be_served_is_one_message():
    program = "import numpy; numpy.__version__ = '2.1.0'; import kalfem as kf; kf.Structure"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert "install 'numpy<2'" in done.stderr.splitlines()[-1]


@pytest.mark.parametrize("module", ["kalfem", *(f"kalfem.{each}" for each in MODULES), "kalfem._core"])
def test_doctests(module):
    found = doctest.testmod(importlib.import_module(module), optionflags=doctest.ELLIPSIS)
    assert found.failed == 0


def test_every_public_name_is_documented():
    for name in kf.__all__:
        assert inspect.getdoc(getattr(kf, name)), name


def test_the_stubs_are_those_of_the_module():
    core = importlib.import_module("kalfem._core")
    stubs = ast.parse((Path(kf.__file__).parent / "_core.pyi").read_text())
    for node in stubs.body:
        if isinstance(node, ast.FunctionDef):
            assert callable(getattr(core, node.name))
        if isinstance(node, ast.ClassDef):
            members = {each.name for each in node.body if isinstance(each, ast.FunctionDef)}
            assert members <= set(dir(getattr(core, node.name))), node.name
    named = {node.name for node in stubs.body if isinstance(node, (ast.FunctionDef, ast.ClassDef))}
    assert {name for name in dir(core) if not name.startswith("_")} <= named

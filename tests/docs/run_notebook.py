#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Runs the code cells of a notebook in order, in one namespace, and compares what each prints with its output in the file.

    run_notebook.py NOTEBOOK --build BUILD --python FOLDER [--accept]

Numbers agree to the digits shown, as in the pages (outputs.py); --accept writes what was printed into the notebook. A cell
with the tag "matplotlib" is left out where Matplotlib is absent. Exit code 77 where the Python package is not built.
"""

import argparse
import contextlib
import importlib.util
import io
import json
import os
import sys
import tempfile
from pathlib import Path

from outputs import first_difference, lines_of

SKIPPED = 77


def shown(cell):
    """The text that the notebook shows below a cell."""
    return "".join("".join(output.get("text", "")) for output in cell["outputs"])


def stream(text):
    return [{"name": "stdout", "output_type": "stream", "text": text.splitlines(keepends=True)}] if text else []


def left_out(cell):
    tags = cell["metadata"].get("tags", [])
    return next((tag for tag in tags if importlib.util.find_spec(tag) is None), None)


def difference(cell, printed):
    """What is wrong with the output of a cell, or None."""
    if len(lines_of(shown(cell))) != len(lines_of(printed)) or first_difference(shown(cell), printed) is not None:
        return f"shown is\n{shown(cell)}\nprinted was\n{printed}"
    return None


def run(notebook):
    """Runs all cells; the text that each code cell printed (None: left out)."""
    names, printed = {"__name__": "__main__"}, []
    for number, cell in enumerate(cell for cell in notebook["cells"] if cell["cell_type"] == "code"):
        if package := left_out(cell):
            print(f"cell {number} is left out: {package} is absent")
            printed.append(None)
            continue
        with contextlib.redirect_stdout(io.StringIO()) as text:
            exec(compile("".join(cell["source"]), f"cell {number}", "exec"), names)
        printed.append(text.getvalue())
    return printed


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("notebook", type=Path)
    parser.add_argument("--build", type=Path, required=True, help="the folder of bin/kalfem")
    parser.add_argument("--python", type=Path, help="the folder of the Python package")
    parser.add_argument("--accept", action="store_true")
    arguments = parser.parse_args()
    if not arguments.python or not (arguments.python / "kalfem").is_dir():
        print("the Python package is not built; scripts/python builds it")
        sys.exit(1 if os.environ.get("CI") == "true" else SKIPPED)
    file = arguments.notebook.resolve()
    sys.path.insert(0, str(arguments.python.resolve()))
    os.environ["PATH"] = f"{arguments.build.resolve() / 'bin'}{os.pathsep}{os.environ['PATH']}"
    os.environ["MPLBACKEND"] = "Agg"
    notebook = json.loads(file.read_text())
    with tempfile.TemporaryDirectory(prefix="kalfem-notebook-") as folder, contextlib.chdir(folder):
        printed = run(notebook)
    code = [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]
    ran = [(number, cell, text) for number, (cell, text) in enumerate(zip(code, printed)) if text is not None]
    problems = {number: problem for number, cell, text in ran if (problem := difference(cell, text))}
    if arguments.accept:
        for number, cell, text in ran:
            if number in problems:
                cell["outputs"] = stream(text)
        file.write_text(json.dumps(notebook, indent=1, ensure_ascii=False) + "\n")
        return
    print(f"{arguments.notebook}: {len(ran)} cells ran")
    if problems:
        sys.exit("\n".join(f"cell {number}: {problem}" for number, problem in problems.items()))


if __name__ == "__main__":
    main()

#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""docs/python-reference.md from the docstrings of the Python package, and the signatures of its type stub.

    python_reference.py write      write the page
    python_reference.py check      fail where the page is not what the docstrings say

Needs the package in PYTHONPATH: scripts/python builds it into build/python.
"""

import ast
import difflib
import inspect
import re
import sys
from pathlib import Path

import kalfem

PROJECT = Path(__file__).resolve().parents[1]
PAGE = PROJECT / "docs/python-reference.md"
STUB = ast.parse((PROJECT / "python/kalfem/_core.pyi").read_text())
WIDTH = 110

GROUPS = {
    "Structures": "Structure Lumped FiniteElements lumped chain read_deck read_matrices deck_notes write_updated_deck laws",
    "Sensors": "Sensor displacement velocity acceleration force deformation rate strain low_pass high_pass delay without_lag resonance gain",
    "Records": "read Record MeasuredFile TimeSeries",
    "Simulation and identification": "simulate estimate predict validate Validation SensorValidation",
    "Updating": "update MeasuredModes MeasuredResponses MeasuredDeflections MeasuredRecord",
    "Posteriors": "infer infer_comparisons Posterior mixture Mixture compare ComparedStructure Likelihood",
    "Modes, frequency responses, statics": "modal modal_of_responses merge_setups track_modes IdentifiedMode IdentifiedModes ModeTrack read_modes ModeSet match_points PointMatch MatchedPoint PlaceFit correlate Correlation CorrelatedMode SetupMistake ShapeExpansion correlate_responses ResponseAgreement modes Modes frf frequency_responses "
    "FrequencyResponses FrequencyResponse mac statics Statics StaticCase",
    "Sensor placement": "place Placement SensorSet",
    "Sample by sample": "Filter Estimate watch Watch",
    "Cases and results": "run read_results Run compare_runs RunComparison read_case to_case Case read_mesh mesh_of plots",
    "Many runs": "sweep Sweep map Ensemble Failure",
    "Errors": "InvalidInput Issue MissingPackage UnknownName",
}
HEAD = """# Python reference

<!-- Written by tools/python_reference.py from the docstrings; change those. -->

Every name of the package, as `help()` prints it: `import kalfem as kf`, then `kf.estimate`. [kalfem in Python](python.md) shows them at work.

"""


def stub_of(path):
    """The definition of "Structure.connect" in the type stub, or None."""
    found = STUB
    for name in path.split("."):
        found = next((node for node in getattr(found, "body", []) if getattr(node, "name", None) == name), None)
    return found


def arguments_of(path, thing):
    """The arguments, each a text as it is written; None of what is not called."""
    if (stub := stub_of(path)) and isinstance(stub, ast.ClassDef):
        stub = stub_of(f"{path}.__init__")
    if isinstance(stub, ast.FunctionDef):
        given = stub.args
        bare = [None] * (len(given.args) - len(given.defaults))
        texts = [with_default(arg, value) for arg, value in zip(given.args, bare + given.defaults)]
        texts += ["*"] if given.kwonlyargs else []
        texts += [with_default(arg, value) for arg, value in zip(given.kwonlyargs, given.kw_defaults)]
        return [text for text in texts if not re.match(r"self\b", text)], stub.returns and ast.unparse(stub.returns)
    signature = inspect.signature(thing)
    texts, starred = [], False
    for parameter in signature.parameters.values():
        if parameter.kind is parameter.KEYWORD_ONLY and not starred:
            texts.append("*")
        starred |= parameter.kind in (parameter.KEYWORD_ONLY, parameter.VAR_POSITIONAL)
        texts.append(str(parameter).replace("'", ""))
    returns = signature.return_annotation
    return [text for text in texts if text != "self"], None if returns is signature.empty else str(returns).strip("'")


def with_default(argument, value):
    text = argument.arg + (f": {ast.unparse(argument.annotation)}" if argument.annotation else "")
    return text if value is None else f"{text} = {ast.unparse(value)}"


def signature_of(path, thing):
    """The call in one line, or an argument in each."""
    texts, returns = arguments_of(path, thing)
    end = f") -> {returns}" if returns and not inspect.isclass(thing) else ")"
    line = f"{path}({', '.join(texts)}{end}"
    broken = f"{path}(\n    " + ",\n    ".join(texts) + f",\n{end}"
    return line if len(line) <= WIDTH else broken


def has_entry(path):
    """Whether the page has "Structure.connect"."""
    name, _, member = path.partition(".")
    found = getattr(kalfem, name) if name in kalfem.__all__ else None
    return found is not None and (not member or member in dict(members_of(found)))


def inline(text):
    """reStructuredText in a line as Markdown: literals, and links to names of the package."""

    def link(found):
        name = found[1].removeprefix("kalfem.")
        return f"[`{name}`](#kf.{name})" if has_entry(name) else f"`{name}`"

    text = re.sub(r":\w+:`~?([\w.]+)`", link, text)
    return re.sub(r"``(.+?)``", r"`\1`", text)


def body_of(docstring):
    """A docstring of NumPy's form as Markdown: its sections as headings of their own, its names as a list."""
    lines, out = docstring.splitlines(), []
    section, in_example = None, False
    for i, line in enumerate(lines):
        if re.fullmatch(r"-{3,}", line):
            continue
        if i + 1 < len(lines) and re.fullmatch(r"-{3,}", lines[i + 1]):
            section = line
            out += ["", f"**{line}**", ""]
        elif line.startswith(">>>") and not in_example:
            in_example = True
            out += ["", "```pycon", line]
        elif in_example and not line:
            in_example = False
            out += ["```", ""]
        elif in_example:
            out.append(line)
        elif section and section not in ("Examples", "Notes") and line and not line.startswith(" "):
            name, colon, kind = line.partition(" : ")
            out.append(f"* `{name}`{colon and ' : '}{inline(kind)}" if re.fullmatch(r"[\w*, ]+", name) else f"* {inline(line)}")
        elif section and line.startswith("    "):
            out.append("  " + inline(line.strip()))
        else:
            out.append(inline(line))
    if in_example:
        out.append("```")
    return re.sub(r"\n{3,}", "\n\n", "\n".join(out)).strip()


def docstring_of(thing):
    """What help() prints, without the line of signature that pybind11 puts before it."""
    text = inspect.getdoc(thing) or ""
    if "Overloaded function." in text:
        text = re.sub(r"^(\d+\. )?\w+\(.*\)( -> .*)?\n?|^Overloaded function\.$", "", text, flags=re.MULTILINE)
    elif re.match(r"\w+\(.*\) -> ", text):
        text = text.partition("\n")[2]
    return text.strip()


def members_of(thing):
    """Methods and properties of a class, or functions of a module, that are public and say what they do."""
    for name, member in vars(thing).items() if inspect.isclass(thing) or inspect.ismodule(thing) else ():
        if inspect.ismodule(thing) and getattr(member, "__module__", "") != thing.__name__:
            continue
        if not name.startswith("_") and docstring_of(member) and (callable(member) or isinstance(member, property)):
            yield name, member


def entry(name, thing):
    parts = [f'<a id="kf.{name}"></a>', f"### {name}", ""]
    docstring = docstring_of(thing)
    if not inspect.isclass(thing) and callable(thing) or "Parameters\n---" in docstring:
        parts += ["```text", signature_of(name, thing), "```", ""]
    parts += [body_of(docstring), ""]
    for member_name, member in members_of(thing):
        path = f"{name}.{member_name}"
        parts += [f'<a id="kf.{path}"></a>', f"#### {path}", ""]
        if callable(member):
            parts += ["```text", signature_of(path, member), "```", ""]
        parts += [body_of(docstring_of(member)), ""]
    return "\n".join(parts)


def page():
    grouped = " ".join(GROUPS.values()).split()
    if wrong := set(grouped) ^ set(kalfem.__all__):
        sys.exit(f"tools/python_reference.py: GROUPS and kalfem.__all__ differ by {', '.join(sorted(wrong))}")
    parts = [HEAD]
    for title, names in GROUPS.items():
        parts += [f"## {title}\n\n", *(entry(name, getattr(kalfem, name)) + "\n" for name in names.split())]
    return "".join(parts).rstrip() + "\n"


def main():
    text = page()
    if sys.argv[1:] == ["write"]:
        PAGE.write_text(text)
    elif sys.argv[1:] == ["check"]:
        lines = difflib.unified_diff(PAGE.read_text().splitlines(), text.splitlines(), str(PAGE), "docstrings", lineterm="")
        if changes := "\n".join(lines):
            sys.exit(f"{changes}\ntools/python_reference.py write takes them over")
    else:
        sys.exit(__doc__)


if __name__ == "__main__":
    main()

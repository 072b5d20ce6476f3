# SPDX-License-Identifier: Apache-2.0
"""What notebooks show of parameters, verdicts, runs and structures: plain HTML tables, without scripts."""

import math
from html import escape

_COLOURS = {"consistent": "#2e7d32", "suspicious": "#b26a00", "unusable": "#c62828"}


def rounded(value, std=None):
    """A number with the digits that its standard deviation justifies, or with four.

    >>> rounded(19.97832, 0.0893), rounded(0.0893, 0.0893), rounded(2.0713e11, 3.1e9), rounded(None)
    ('19.978', '0.089', '2.071e+11', '-')
    """
    if value is None:
        return "-"
    if not math.isfinite(value) or value == 0:
        return f"{value:g}"
    size = math.floor(math.log10(abs(value)))
    digits = 4
    if std and math.isfinite(std):
        digits = min(max(size - math.floor(math.log10(abs(std))) + 2, 2), 12)
    if not -4 <= size < 6:
        return f"{value:.{digits - 1}e}"
    decimals = digits - 1 - size
    return f"{round(value, decimals):.{max(decimals, 0)}f}"


def table(rows):
    """An HTML table of dictionaries; their keys are the columns."""
    rows = list(rows)
    columns = dict.fromkeys(key for row in rows for key in row)
    head = "".join(f"<th style='text-align:left'>{escape(str(column))}</th>" for column in columns)
    cells = ["".join(f"<td style='text-align:left'>{_cell(row.get(key))}</td>" for key in columns) for row in rows]
    body = "".join(f"<tr>{line}</tr>" for line in cells)
    return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


def _cell(value):
    if value is None:
        return ""
    if isinstance(value, dict):
        return ", ".join(f"{escape(str(key))} {_cell(each)}" for key, each in value.items())
    if isinstance(value, (list, tuple)):
        return " ".join(map(_cell, value))
    return rounded(value) if isinstance(value, float) else escape(str(value))


def parameters_html(parameters):
    """One row a parameter: estimate, both deviations, 95 % interval, truth, initial value."""
    return table(map(_parameter_row, parameters.values())) if parameters else "<p>no parameters</p>"


def _parameter_row(each):
    lower, upper = each.interval or (None, None)
    row = {"parameter": each.name, "value": rounded(each.value, each.std), "std": rounded(each.std, each.std)}
    row["robust std"] = rounded(each.std_robust, each.std_robust)
    row["95 %"] = "" if each.interval is None else f"{rounded(lower, each.std)} to {rounded(upper, each.std)}"
    if each.truth is not None:
        row["truth"] = rounded(each.truth)
    row["initial"] = rounded(each.initial)
    row["unit"] = each.unit
    return row


def verdict_html(verdict):
    """The state in colour, and the reasons with their remedies."""
    colour = _COLOURS.get(verdict.state, "#555")
    head = f"<p><b style='color:{colour}'>{escape(verdict.state)}</b></p>"
    rows = [{"about": each.subject, "reason": each.text, "remedy": each.remedy} for each in verdict.reasons]
    return head + (table(rows) if rows else "")


def run_html(run):
    """Title, verdict, parameters and the filter's consistency."""
    title = run.summary.get("title") or run.summary.get("case") or "run"
    parts = [f"<h4>{escape(title)}</h4>", verdict_html(run.verdict)]
    if run.message:
        parts.append(f"<p>{escape(run.message)}</p>")
    parts.append(parameters_html(run.parameters))
    estimation = run.summary.get("estimation", {})
    nis = estimation.get("nis", {})
    if nis.get("mean") is not None:
        parts.append(
            f"<p>{escape(estimation.get('filter', 'filter'))}: NIS {rounded(nis['mean'])} "
            f"(expected {rounded(nis.get('expected'))})</p>"
        )
    return "".join(parts)


_STRUCTURE = {
    "substructures": ("name", "kind", "degrees of freedom"),
    "connectors": ("name", "from", "to", "law", "parameters"),
    "inputs": ("name", "unit", "place"),
}


def structure_html(structure):
    """Substructures, connectors and inputs of a structure, from the tuples of ``structure.contents``."""
    parts = []
    for title, columns in _STRUCTURE.items():
        rows = [dict(zip(columns, each)) for each in structure.contents[title]]
        parts.append(f"<p><b>{title}</b></p>" + (table(rows) if rows else "<p>none</p>"))
    return "".join(parts)


def ensemble_html(ensemble):
    """How many runs there are, how many failed and why, and the first rows of the table."""
    failures = ensemble.failures
    parts = [f"<p>{len(ensemble)} runs, {len(failures)} failed</p>"]
    if failures:
        parts.append(table({"settings": each.settings, "error": str(each)} for each in failures[:5]))
    parts.append(table(ensemble.rows()[:10]))
    return "".join(parts)

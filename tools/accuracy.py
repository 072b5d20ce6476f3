#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""docs/accuracy.md from docs/accuracy.md.in and docs/figures.txt.

    accuracy.py page              write the page
    accuracy.py check             fail where the page is not what template and figures make
    accuracy.py update FOLDER     take over what the tests left in FOLDER, then write the page
    accuracy.py measured FOLDER   fail where a figure that is not heavy was measured by no test

A line of figures.txt is "name = 0.24 %"; a comment that begins with # may follow. "# heavy, <date>" marks a figure of a
test that only `scripts/accuracy heavy` runs. The template shows a figure by {name}.
"""

import datetime
import pathlib
import re
import sys

DOCS = pathlib.Path(__file__).resolve().parent.parent / "docs"
FIGURES, TEMPLATE, PAGE = DOCS / "figures.txt", DOCS / "accuracy.md.in", DOCS / "accuracy.md"
LINE = re.compile(r"^(?P<name>[\w.-]+) = (?P<text>[^#]*?) *(?P<comment>#.*)?$")
NAME = re.compile(r"\{([\w.-]+)\}")
NOTE = "<!-- Written by scripts/accuracy from accuracy.md.in and figures.txt; change those. -->\n"


def stated():
    """Name -> text of every figure."""
    figures = {}
    for number, line in enumerate(FIGURES.read_text().splitlines(), 1):
        if not line.strip() or line.startswith("#"):
            continue
        match = LINE.match(line)
        if not match:
            sys.exit(f"{FIGURES}:{number}: not a figure: {line!r}; write 'name = 0.24 %'")
        if match["name"] in figures:
            sys.exit(f"{FIGURES}:{number}: '{match['name']}' is stated twice")
        figures[match["name"]] = match["text"]
    return figures


def page():
    figures, shown = stated(), set()

    def text_of(match):
        name = match[1]
        if name not in figures:
            sys.exit(f"{TEMPLATE}: shows '{name}', which {FIGURES} does not state")
        shown.add(name)
        return figures[name]

    text = NAME.sub(text_of, TEMPLATE.read_text())
    unused = sorted(set(figures) - shown)
    if unused:
        sys.exit(f"{FIGURES}: the page shows no {', '.join(unused)}")
    return NOTE + text


def in_digits_of(text, value):
    """The value in the form of a stated text: as many digits, % where it stands.

    >>> in_digits_of("0.24 %", 0.00257), in_digits_of("18", 15.6), in_digits_of("-3.1", -2.96)
    ('0.26 %', '16', '-3.0')
    >>> in_digits_of(".989", 0.9934), in_digits_of(".989", 1.0051), in_digits_of(".427", -0.1)
    ('.993', '1.005', '-.100')
    >>> in_digits_of("4.6e-6", 0.00000512)
    '5.1e-6'
    """
    number, percent = text.removesuffix(" %"), " %" if text.endswith(" %") else ""
    mantissa, exponent = re.fullmatch(r"([^e]*)(e.*)?", number).groups()
    decimals = len(mantissa.partition(".")[2])
    value *= 100 if percent else 1
    if exponent:
        written = f"{value:.{decimals}e}"
        mantissa, power = written.split("e")
        return f"{mantissa}e{int(power)}{percent}"
    written = f"{value:.{decimals}f}"
    if number.lstrip("-").startswith("."):
        written = written.replace("0.", ".", 1) if written.lstrip("-").startswith("0.") else written
    return written + percent


def unit_of_last_digit(text):
    """
    >>> [round(unit_of_last_digit(text), 12) for text in ("0.24 %", "18", ".989", "4.6e-6")]
    [0.0001, 1.0, 0.001, 1e-07]
    """
    number = text.removesuffix(" %")
    mantissa, exponent = re.fullmatch(r"([^e]*)(?:e(.*))?", number).groups()
    return (0.01 if text.endswith(" %") else 1.0) * 10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2]))


def value_of(text):
    return float(text.removesuffix(" %")) * (0.01 if text.endswith(" %") else 1.0)


def update(folder):
    """A figure at the edge of its rounding stays as it is, so that noise changes no file."""
    lines = []
    for line in FIGURES.read_text().splitlines():
        match = LINE.match(line) if not line.startswith("#") else None
        left = folder / match["name"] if match else None
        if match and left.exists():
            measured, text, comment = float(left.read_text()), match["text"], match["comment"] or ""
            moved = abs(measured - value_of(text)) > 0.6 * unit_of_last_digit(text)
            new = in_digits_of(text, measured) if moved else text
            if moved:
                print(f"{match['name']}: {text} -> {new}")
            if comment.startswith("# heavy"):
                comment = f"# heavy, {datetime.date.fromtimestamp(left.stat().st_mtime)}"
            line = f"{match['name']} = {new}" + (f"  {comment}" if comment else "")
        lines.append(line)
    FIGURES.write_text("\n".join(lines) + "\n")


def not_measured(folder):
    heavy = {m["name"] for m in map(LINE.match, FIGURES.read_text().splitlines()) if m and "# heavy" in (m["comment"] or "")}
    return [name for name in stated() if name not in heavy and not (folder / name).exists()]


def main(arguments):
    verb = arguments[0] if arguments else ""
    if verb == "page":
        PAGE.write_text(page())
    elif verb == "check":
        if PAGE.read_text() != page():
            sys.exit("docs/accuracy.md is not what its template and figures make: run scripts/accuracy page")
    elif verb == "update" and len(arguments) == 2:
        update(pathlib.Path(arguments[1]))
        PAGE.write_text(page())
    elif verb == "measured" and len(arguments) == 2:
        missing = not_measured(pathlib.Path(arguments[1]))
        if missing:
            sys.exit("no test measured these figures of docs/accuracy.md: " + ", ".join(missing))
    else:
        sys.exit(__doc__)


if __name__ == "__main__":
    main(sys.argv[1:])

"""The pages of the reference. The command prints them; here they only get headings."""

import html
import json
import re
import textwrap


def block(text):
    return f"```text\n{text.rstrip()}\n```\n"


def command_page(printed):
    """`kalfem --help`, then that of each verb."""
    overview = printed("--help")
    verbs = re.findall(r"^  ([a-z]+) {2,}\S", overview, re.MULTILINE)
    parts = ["# The command\n", "As `kalfem --help` and `kalfem VERB --help` print it.\n", block(overview)]
    for verb in verbs:
        parts += [f"## {verb}\n", block(printed(verb, "--help"))]
    return "\n".join(parts)


def cell(text):
    return html.escape(text, quote=False).replace("|", "&#124;")


def row(line):
    """A line of `kalfem schema`, "  mass: number [kg] > 0 (required)   meaning", as a row: key, what it takes, meaning."""
    indent = "&emsp;" * ((len(line) - len(line.lstrip())) // 2)
    left, _, meaning = re.sub(r" {2,}", "\n", line.strip(), count=1).partition("\n")
    if alternative := re.match(r"(or) (.*)", left):
        return f"| {indent}{alternative[1]} | {cell(alternative[2])} | {cell(meaning)} |"
    key, _, takes = left.partition(": ")
    return f"| {indent}<code>{cell(key.rstrip(':'))}</code> | {cell(takes)} | {cell(meaning)} |"


def case_page(printed):
    """`kalfem schema SECTION` of every section."""
    sections = json.loads(printed("schema", "--json"))["properties"]
    parts = [
        "# The case file\n",
        "Every key of a case, as `kalfem schema` prints them; `kalfem schema estimate` prints one section. "
        "Your editor completes and checks them by `kalfem.schema.json`, which `kalfem new` writes beside its case.\n",
    ]
    for section in sections:
        rows = [row(line) for line in printed("schema", section).splitlines() if line.strip()]
        parts += [f"## {section}\n", "\n".join(["| key | takes | meaning |", "|---|---|---|", *rows, ""])]
    return "\n".join(parts)


def laws_page(printed):
    """`kalfem schema --laws`: a law begins at the margin with its name and a colon."""
    laws, functions = printed("schema", "--laws").split("In expressions:", 1)
    parts = ["# Connector laws\n", "As `kalfem schema --laws` prints them. Numbers without a unit are SI.\n"]
    for law in re.split(r"^(?=[a-z_]+: )", laws, flags=re.MULTILINE):
        if law.strip():
            name, rest = law.split(": ", 1)
            meaning, _, body = rest.partition("\n")
            parts += [f"## {name}\n", meaning[:1].upper() + meaning[1:] + ".\n", block(textwrap.dedent(body))]
    parts += ["## Expressions\n", block("In expressions:" + functions)]
    return "\n".join(parts)

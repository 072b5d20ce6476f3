"""references.bib as a page, and its keys as links."""

import re
from pathlib import Path

BIBLIOGRAPHY = Path(__file__).resolve().parents[1] / "references.bib"
ENTRY = re.compile(r"^@(\w+)\{(\w+),(.*?)(?=^@|\Z)", re.MULTILINE | re.DOTALL)
FIELD = re.compile(r"(\w+) = \{((?:[^{}]|\{[^{}]*\})*)\}")
ACCENTS = {
    '"': "\u0308",
    "'": "\u0301",
    "`": "\u0300",
    "^": "\u0302",
    "~": "\u0303",
    "v": "\u030c",
    "c": "\u0327",
    "=": "\u0304",
}
ACCENT = re.compile(r"""\\(["'`^~=]|[vc](?=\{|\s))\s*\{?\\?([A-Za-z])\}?""")


def plain(text):
    """BibTeX's text as Unicode: accents, dashes, no braces."""
    text = ACCENT.sub(lambda found: found[2] + ACCENTS[found[1]], " ".join(text.split()))
    for written, meant in (
        ("\\o", "ø"),
        ("\\l", "ł"),
        ("\\ss", "ß"),
        ("\\&", "&"),
        ("\\_", "_"),
        ("{", ""),
        ("}", ""),
        ("--", "–"),
    ):
        text = text.replace(written, meant)
    return text


def entries():
    """Key -> fields of every source."""
    found = ENTRY.findall(BIBLIOGRAPHY.read_text())
    return {key: {name: plain(text) for name, text in FIELD.findall(body)} for _, key, body in found}


def citation(fields):
    """One source as a sentence: authors, title, where, volume, pages, year, doi."""
    where = next(
        (
            fields[key]
            for key in ("journal", "booktitle", "institution", "school", "publisher", "howpublished")
            if key in fields
        ),
        None,
    )
    parts = [fields.get("author"), f"*{fields['title']}*", where]
    parts += [fields.get("volume"), f"pp. {fields['pages']}" if "pages" in fields else None, fields.get("year")]
    parts += [f"doi {fields['doi']}" if "doi" in fields else None]
    return ", ".join(part for part in parts if part) + "."


def page():
    lines = [f'<a id="{key}"></a>**[{key}]** {citation(fields)}\n' for key, fields in sorted(entries().items())]
    return "# Sources\n\nThe keys stand in these pages and in the headers of the library.\n\n" + "\n".join(lines)


def linked(text, target):
    """Keys in brackets, [CB68] or [SS82, AZH17], as links to the page of the sources."""
    known = entries()

    def link(found):
        parts = re.split(r"([,;] )", found[1])
        if parts[0] not in known:
            return found[0]
        return "[" + "".join(f"[{part}]({target}#{part})" if part in known else part for part in parts) + "]"

    return re.sub(r"\[([A-Z]\w+(?:[,;] [^\[\]]*)?)\](?![(\[])", link, text)

"""Notebooks as pages: their text, their code, and what it printed."""

import json
import re


def block(language, text):
    return f"```{language}\n{text.rstrip()}\n```\n"


def page(file):
    """A notebook as Markdown, with a link to the file itself below its heading."""
    parts = []
    for cell in json.loads(file.read_text())["cells"]:
        text = "".join(cell["source"])
        parts.append(text if cell["cell_type"] == "markdown" else block("python", text))
        parts += [block("text", "".join(output["text"])) for output in cell.get("outputs", [])]
    link = f"[This page as a notebook]({file.name})"
    return re.sub(r"\A(# .*)", rf"\1\n\n{link}", "\n\n".join(parts), count=1) + "\n"


def pages(folder):
    """Markdown by the path of the page."""
    return {f"notebooks/{file.stem}.md": page(file) for file in sorted((folder / "notebooks").glob("*.ipynb"))}

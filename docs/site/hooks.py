"""Hooks of mkdocs: what the site has beside the pages of this folder.

* reference/*.md, printed by the command itself: its verbs, every key of a case, the connector laws;
* notebooks/*.md, from the notebooks beside them;
* sources.md, from references.bib; a key such as [CB68] in a page becomes a link to it;
* KaTeX, from Debian's package libjs-katex;
* search in a site that is opened from the disk, see from_disk.py.

The command is $KALFEM_COMMAND, or build/release/bin/kalfem.
"""

import os
import posixpath
import re
import subprocess
import sys
from pathlib import Path

from mkdocs.exceptions import PluginError
from mkdocs.structure.files import File

sys.path.insert(0, str(Path(__file__).parent))
import from_disk  # noqa: E402
import notebooks  # noqa: E402
import reference  # noqa: E402
import sources  # noqa: E402

PROJECT = Path(__file__).resolve().parents[2]
GENERATED = PROJECT / "build/docs-pages"
KATEX = Path("/usr/share/javascript/katex")
SHOWN = {".md", ".ipynb", ".png", ".svg", ".css", ".js"}
CODE = re.compile(r"(^```.*?^```|^ {4}.*?$|`[^`\n]+`)", re.MULTILINE | re.DOTALL)


def printed(*arguments):
    """What the command prints."""
    command = os.environ.get("KALFEM_COMMAND", str(PROJECT / "build/release/bin/kalfem"))
    try:
        return subprocess.run([command, *arguments], check=True, capture_output=True, text=True).stdout
    except (OSError, subprocess.CalledProcessError) as error:
        raise PluginError(f"the reference is printed by {command}, which cannot run ({error}); scripts/build makes it")


def generated_pages():
    return {
        "reference/command.md": reference.command_page(printed),
        "reference/case.md": reference.case_page(printed),
        "reference/laws.md": reference.laws_page(printed),
        "sources.md": sources.page(),
        **notebooks.pages(PROJECT / "docs"),
    }


def on_files(files, config):
    for file in list(files):
        if Path(file.src_path).suffix not in SHOWN:
            files.remove(file)

    def add(path, folder):
        files.append(File(path, str(folder), config["site_dir"], config["use_directory_urls"]))

    for path, text in generated_pages().items():
        (GENERATED / path).parent.mkdir(parents=True, exist_ok=True)
        (GENERATED / path).write_text(text)
        add(path, GENERATED)
    if not KATEX.is_dir():
        raise PluginError(f"formulas need {KATEX}, of Debian's package libjs-katex; scripts/setup --docs installs it")
    for part in ("katex.min.js", "katex.min.css", "contrib/auto-render.js", *fonts()):
        add(f"katex/{part}", KATEX.parent)
    return files


def fonts():
    return [f"fonts/{font.name}" for font in sorted((KATEX / "fonts").glob("*.woff2"))]


def on_page_markdown(markdown, page, config, files):
    """Links the sources' keys, outside code."""
    if page.file.src_path == "sources.md":
        return markdown
    target = posixpath.relpath("sources.md", posixpath.dirname(page.file.src_path))
    parts = CODE.split(markdown)
    return "".join(part if CODE.fullmatch(part) else sources.linked(part, target) for part in parts)


def on_post_page(output, page, config):
    return from_disk.with_search(output, posixpath.relpath(".", posixpath.dirname(page.url)))


def on_post_build(config):
    from_disk.write_index(Path(config["site_dir"]))

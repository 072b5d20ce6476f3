#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Builds the site and looks at its pages: links that lead nowhere, formulas that KaTeX cannot set, and whatever a
browser would fetch from the network.

    check_site.py --out FOLDER      exit code 77 where mkdocs is absent, except with CI=true
"""

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urldefrag

PROJECT = Path(__file__).resolve().parents[2]
SKIPPED = 77
FETCHED = {"link": "href", "script": "src", "img": "src", "iframe": "src", "source": "src", "video": "src"}
STYLE_URL = re.compile(r"""(?:url\(|@import\s+)\s*["']?(https?:)?//""")


SET_FORMULAS = """
const katex = require("/usr/share/javascript/katex/katex.js");
for (const formula of JSON.parse(require("fs").readFileSync(0)))
  try { katex.renderToString(formula.slice(2, -2), { displayMode: true, throwOnError: true }); }
  catch (error) { console.log(`${formula}: ${error.message}`); }
"""


class Page(HTMLParser):
    """What a page fetches, links to and can be linked by, and its formulas."""

    def __init__(self, text):
        super().__init__()
        self.fetched, self.links, self.anchors, self.formulas = [], [], set(), []
        self.in_formula = False
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        found = dict(attributes)
        self.anchors.update(filter(None, (found.get("id"), found.get("name"))))
        if tag in FETCHED and found.get(FETCHED[tag]) and found.get("rel") != "canonical":
            self.fetched.append(found[FETCHED[tag]])
        if tag == "a" and found.get("href"):
            self.links.append(found["href"])
        self.in_formula = found.get("class") == "arithmatex"

    def handle_data(self, data):
        if self.in_formula:
            self.formulas.append(data.strip())
            self.in_formula = False


def is_remote(address):
    return address.startswith(("http:", "https:", "//"))


def bad_formulas(formulas):
    """What KaTeX says of those that it cannot set."""
    done = subprocess.run(
        ["node", "-e", SET_FORMULAS], input=json.dumps(formulas), capture_output=True, text=True, check=True
    )
    return done.stdout.splitlines()


def problems_of(site):
    pages = {file: Page(file.read_text()) for file in site.rglob("*.html") if file.name != "404.html"}
    problems = []
    for file, page in pages.items():
        problems += [f"{file}: fetches {address}" for address in page.fetched if is_remote(address)]
        problems += [f"{file}: {formula}" for formula in bad_formulas(page.formulas)]
        for link in filter(lambda link: not is_remote(link) and not link.startswith(("mailto:", "html/")), page.links):
            path, anchor = urldefrag(unquote(link))
            target = (file.parent / path).resolve() if path else file
            if not target.exists() or (anchor and target in pages and anchor not in pages[target].anchors):
                problems.append(f"{file}: links to {link}, which is not there")
    problems += [
        f"{file}: fetches from the network" for file in site.rglob("*.css") if STYLE_URL.search(file.read_text())
    ]
    return problems


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", required=True, type=Path)
    site = parser.parse_args().out.resolve()
    if not shutil.which("mkdocs"):
        print("mkdocs is not installed: scripts/setup --docs installs it")
        sys.exit(1 if os.environ.get("CI") == "true" else SKIPPED)
    subprocess.run(["mkdocs", "build", "--strict", "--quiet", "--site-dir", site], cwd=PROJECT, check=True)
    if problems := problems_of(site):
        sys.exit("\n".join(problems))


if __name__ == "__main__":
    main()

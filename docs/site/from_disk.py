"""Search in a site that is opened from the disk.

A browser lets no page of file:// fetch the index or start a worker from a file. Both come as one script there, and the
worker starts from a blob; the theme takes them from the variable __search. Over HTTP nothing changes.
"""

import json

SCRIPT = "search/from_disk.js"
LOADER = """<script>location.protocol === "file:" && document.write('<script src="{base}/{script}"><\\/script>')</script>"""
FOUND = """var __search = {{
  index: Promise.resolve({index}),
  worker: URL.createObjectURL(new Blob([{worker}], {{type: "text/javascript"}}))
}};
"""


def with_search(html, base):
    """A page that loads the script where it was opened from the disk, before the theme's own."""
    return html.replace("</head>", LOADER.format(base=base, script=SCRIPT) + "</head>", 1)


def write_index(site):
    worker = next((site / "assets/javascripts/workers").glob("search.*.min.js")).read_text()
    index = json.loads((site / "search/search_index.json").read_text())
    texts = [json.dumps(part).replace("</", "<\\/") for part in (index, worker)]
    (site / SCRIPT).write_text(FOUND.format(index=texts[0], worker=texts[1]))

# SPDX-License-Identifier: Apache-2.0
"""The fenced blocks of a page and the marks before them.

A mark is an HTML comment in front of a block, which no reader sees:

    <!-- output -->                  the block is what the block above prints, see outputs.py
    <!-- exits with: 3 -->           the exit code of a shell block, default 0
    <!-- in: FILE -->                the block is a part of this case, `FILE at KEY` of this section of it
    <!-- without: KEY, KEY -->       ... which stands in the place of these keys
    <!-- absent: A, B -->            ... and names files or channels that are the reader's own
    <!-- file: FILE -->              the block is the content of this file
    <!-- before: TEXT -->            lines that the page does not show, run before the block
    <!-- data: FOLDER -->            the block needs this folder of measured data
    <!-- not run: REASON -->         the block cannot run in a test
"""

import re
from dataclasses import dataclass, field

MARKS = {"output", "exits with", "in", "without", "absent", "file", "before", "data", "not run"}
FENCED = re.compile(
    r"(?P<marks>(?:^<!--(?:(?!-->).)*-->\n+)*)^```(?P<language>[\w+]*)[^\n]*\n(?P<text>.*?)^```$",
    re.MULTILINE | re.DOTALL,
)
COMMENT = re.compile(r"<!--\s*(?P<name>[a-z ]+?)\s*(?::\s*(?P<value>.*?))?\s*-->", re.DOTALL)
COMMAND = re.compile(r"^ {4,}(kalfem|scripts/|build/|ctest|cmake|python3|apt|nice|import |#include)\b", re.MULTILINE)


class BadPage(Exception):
    """What is wrong with a page, with its line."""


@dataclass
class Block:
    language: str
    text: str
    line: int
    marks: dict = field(default_factory=dict)


def line_at(page, position):
    return page.count("\n", 0, position) + 1


def blocks_of_text(page):
    """Every fenced block of a page in order; raises BadPage for a mark that is none, and for commands without a fence."""
    blocks = []
    for found in FENCED.finditer(page):
        line = line_at(page, found.start("language"))
        marks = {mark["name"]: mark["value"] or "" for mark in COMMENT.finditer(found["marks"])}
        if unknown := set(marks) - MARKS:
            raise BadPage(
                f"line {line}: '{unknown.pop()}' is no mark of a block; the marks are {', '.join(sorted(MARKS))}"
            )
        blocks.append(Block(found["language"], found["text"], line, marks))
    outside = FENCED.sub(lambda fence: "\n" * fence[0].count("\n"), page)
    if command := COMMAND.search(outside):
        raise BadPage(
            f"line {line_at(outside, command.start())}: commands and programs stand in fenced blocks, which a test runs"
        )
    return blocks

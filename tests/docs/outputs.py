# SPDX-License-Identifier: Apache-2.0
"""What a page shows of an output, against the output.

The lines of the page are found in the output, in order. A line `...` stands for any lines, `...` within a line for any
text. Numbers agree if they differ by no more than one in the last digit that the page shows. The lengths of spaces and
rules do not count.
"""

import re
from difflib import SequenceMatcher

DIGITS = r"[-+]?\d+(?:,\d{3})*(?:\.\d+)?(?:e[-+]?\d+)?"
NUMBER = re.compile(r"(?<![\w.])" + DIGITS)


def step_of(text):
    """One in the last digit of a number as it is written."""
    mantissa, _, exponent = text.replace(",", "").partition("e")
    return 10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2]))


def value_of(text):
    return float(text.replace(",", ""))


def same_number(shown, printed):
    return abs(value_of(shown) - value_of(printed)) <= 1.001 * step_of(shown)


def spaced(line):
    """With single spaces, and rules of a table of one length."""
    return re.sub(r"-{3,}", "---", " ".join(line.split()))


def pattern_of(shown):
    """Of a line with `...` and numbers: matches the same words with any numbers in their places."""
    number = f"({DIGITS})"
    texts = spaced(shown).split("...")
    return re.compile(".*?".join(number.join(map(re.escape, NUMBER.split(text))) for text in texts))


def same_line(shown, printed):
    found = pattern_of(shown).fullmatch(spaced(printed))
    return bool(found) and all(map(same_number, NUMBER.findall(shown), found.groups()))


def matched(shown, printed):
    """How many of the lines shown are those printed, from the first on."""
    pairs = zip(shown, printed)
    return next((i for i, pair in enumerate(pairs) if not same_line(*pair)), min(len(shown), len(printed)))


def lines_of(text):
    return [line for line in text.splitlines() if line.strip()]


def parts_of(shown):
    """The lines between the lines `...`."""
    return [lines_of(part) for part in re.split(r"^\s*\.\.\.\s*$", shown, flags=re.MULTILINE)]


def first_difference(shown, printed):
    """The first line of the page that the output does not have where it should, or None."""
    lines, place = lines_of(printed), 0
    for wanted in parts_of(shown):
        best = max(range(place, len(lines) + 1), key=lambda i: matched(wanted, lines[i:]))
        found = matched(wanted, lines[best:])
        if found < len(wanted):
            return wanted[found]
        place = best + len(wanted)
    return None


def likeness(wanted, lines):
    return sum(SequenceMatcher(None, spaced(a), spaced(b)).ratio() for a, b in zip(wanted, lines))


def refreshed(shown, printed):
    """What the page shows as it is printed now, part by part: the lines most like it, where they do not agree."""
    lines, place, new = lines_of(printed), 0, []
    for wanted in parts_of(shown):
        best = max(range(place, len(lines) + 1), key=lambda i: likeness(wanted, lines[i:]))
        now = lines[best : best + len(wanted)]
        agrees = all(map(same_line, wanted, now))
        new += [a if agrees or "..." in a else b for a, b in zip(wanted, now)] + wanted[len(now) :]
        place = best + len(now)
    following = iter(new)
    kept = [line if line.strip() in ("", "...") else next(following) for line in shown.splitlines()]
    return "\n".join(kept) + "\n"

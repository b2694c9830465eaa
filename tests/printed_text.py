"""Printed text compared: words exactly, numbers to one unit of their last digit."""

import difflib
import re
from html.parser import HTMLParser

# Not the numbers within a word, as in a name like 6chn25-34, which is compared as a word.
NUMBER = re.compile(r"(?<![\w.-])[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?(?!\w|\.\w)")
# What is left of zero differs from machine to machine.
ROUND_OFF = re.compile(r"-?\d(?:\.\d)?e-1[1-9]|-?\d(?:\.\d+)?e-(?:1[5-9]|[2-9]\d)")
# Whole numbers below this are counts and places: no rounding changes them.
COUNTS = 100.0
# Of a page: what has a line of its own, what is a part of one, what is not read.
LINES = {
    "p",
    "h1",
    "h2",
    "h3",
    "h4",
    "li",
    "tr",
    "caption",
    "figcaption",
    "section",
    "div",
    "dt",
    "dd",
    "br",
}
LINES |= {"summary", "figure", "header", "footer", "nav", "title", "ul", "table"}
CELLS = {"td", "th", "span", "option"}
UNREAD = {"script", "style", "svg", "template"}


def alike(one, other):
    """Tell whether two lines have the same words, and numbers that differ by one last digit at most."""
    if _words(one) != _words(other):
        return False
    pairs = zip(NUMBER.findall(one), NUMBER.findall(other), strict=True)
    return all(a == b or _same_number(a, b) for a, b in pairs)


def difference(kept, printed, name=""):
    """Return a unified diff of two texts, "" if all lines are alike; spaces between words do not count."""
    before, after = kept.splitlines(), printed.splitlines()
    matched = difflib.SequenceMatcher(None, [*map(_words, before)], [*map(_words, after)], False)
    for start, other, length in matched.get_matching_blocks():
        for place in range(length):
            if alike(before[start + place], after[other + place]):
                after[other + place] = before[start + place]
    return "\n".join(
        difflib.unified_diff(before, after, f"{name} (kept)", "printed", n=1, lineterm="")
    )


def _words(line):
    return " ".join(NUMBER.sub("#", line).split())


def _same_number(one, other):
    if ROUND_OFF.fullmatch(one) and ROUND_OFF.fullmatch(other):
        return True
    return abs(float(one) - float(other)) <= 1.001 * _last_digit(one)


def _last_digit(number):
    digits, _, exponent = number.partition("e")
    _, _, decimals = digits.partition(".")
    unit = 10.0 ** (int(exponent or 0) - len(decimals))
    return 0.0 if unit == 1.0 and abs(float(number)) < COUNTS else unit


class _Page(HTMLParser):
    def __init__(self):
        super().__init__()
        self.words, self.unread = [], 0

    def handle_starttag(self, tag, attributes):
        self.unread += tag in UNREAD
        alternative = dict(attributes).get("alt")
        self.words.append("\n" if tag in LINES else "")
        self.words.append(f"[{alternative}]\n" if alternative else "")

    def handle_endtag(self, tag):
        self.unread -= tag in UNREAD
        self.words.append("\n" if tag in LINES else " " if tag in CELLS else "")

    def handle_data(self, data):
        self.words.append("" if self.unread else " ".join(re.split(r"\s+", data)))


def page_words(text):
    """Words of an HTML page, each paragraph, heading, item and row of a table on a line; no scripts."""
    page = _Page()
    page.feed(text)
    lines = (" ".join(line.split()) for line in "".join(page.words).splitlines())
    return "".join(f"{line}\n" for line in lines if line)

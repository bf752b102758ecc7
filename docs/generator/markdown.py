"""Markdown: tables, blocks of code, sentences."""

from __future__ import annotations

import re
from collections.abc import Iterable
from html import escape


def table(head: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """Return a table; line ends and `|` in cells are replaced."""
    titles = [*head]
    lines = [titles, ["---"] * len(titles), *rows]
    return "".join(f"| {' | '.join(map(_cell, cells))} |\n" for cells in lines).replace(
        "| --- ", "|---"
    )


def _cell(text: str) -> str:
    """Return the text of a cell; code with `|` becomes HTML, which all sites read."""

    def html(found: re.Match[str]) -> str:
        plain = escape(found[1].replace("\\|", "|"), quote=False)
        return f"<code>{plain.replace('|', '&#124;')}</code>"

    return re.sub(r"`([^`|]*\|[^`]*)`", html, " ".join(text.split()))


def code(text: str) -> str:
    """Return a text as code; an empty text stays empty."""
    return f"`{text}`" if text else ""


def block(language: str, text: str) -> str:
    """Return a fenced block of code."""
    return f"```{language}\n{text.rstrip()}\n```\n"


def sentence(text: str) -> str:
    """Return a text with a capital letter and a full stop."""
    return f"{text[:1].upper()}{text[1:]}{'' if text.endswith('.') else '.'}"

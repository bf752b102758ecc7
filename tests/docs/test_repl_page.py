"""The page of the debugger: what it shows of Python runs."""

from __future__ import annotations

from .pages import blocks, page


def test_what_the_page_shows_of_python_runs() -> None:
    code = [block.text for block in blocks(page("reference/repl"), "python")]
    names: dict[str, object] = {}
    exec("\n".join(code), names)  # noqa: S102  # our own page
    assert "session" in names

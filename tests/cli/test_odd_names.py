"""Names of files with line ends and control characters: no output shows them raw."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pytest

from .command import rapc

ODD = "d\n::error file=x::pwn\x1b[2J\u202e"

WAYS: dict[str, Sequence[str]] = {
    "check": ("check", "."),
    "check one": ("check", f"{ODD}/bad.rap"),
    **{
        form: ("check", ".", "--output-format", form)
        for form in ("concise", "grouped", "github", "json-lines", "sarif", "junit")
    },
    "statistics": ("check", ".", "--statistics"),
    "fix": ("check", "--fix", "."),
    "diff": ("check", "--diff", "."),
    "output file": ("check", ".", "--output-file", f"{ODD}/found"),
    "baseline": ("check", ".", "--write-baseline", f"{ODD}/known"),
    "known": ("check", ".", "--baseline", f"{ODD}/noted"),
    "configured": ("check", f"{ODD}/bad.rap", "--config", f"{ODD}/rapc.toml"),
    "fmt": ("fmt", "."),
    "fmt --check": ("fmt", "--check", "."),
    "fmt --diff": ("fmt", "--diff", "."),
    "compile": ("compile", f"{ODD}/good.rap", "-o", f"{ODD}/out"),
    "test": ("test", f"{ODD}"),
    "graph": ("graph", f"{ODD}/good.rap"),
    "run": ("run", f"{ODD}/good.rap", "--world", "truck", "--task", "(go)"),
    "missing": ("check", f"{ODD}/none.rap"),
    "no option": ("check", f"--{ODD}"),
    "no folder": ("experiment", f"{ODD}/none.toml"),
}


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("more", [(), ("-v", "--color", "always")])
def test_odd_names_are_shown_safely(
    way: str, more: tuple[str, ...], tmp_path: Path
) -> None:
    folder = tmp_path / ODD
    folder.mkdir()
    (folder / "good.rap").write_text('(require "truck")(define-rap (go)(succeed t))\n')
    (folder / "bad.rap").write_text(
        "; rapc: ignore[unknown-rap] nothing\n(define-rap (a) (succeed (no-such)))\n"
    )
    (folder / "it.test.rap").write_text(
        '(require "good")(define-test it (task (go)) (expect (fails (go))))\n'
    )
    (folder / "rapc.toml").write_text("")
    assert rapc("check", ".", "--write-baseline", "known", cwd=tmp_path).stdout
    (tmp_path / "known").rename(folder / "noted")
    done = rapc(*more, *WAYS[way], cwd=tmp_path)
    printed = f"\n{done.stdout}\n{done.stderr}"
    if more:
        assert "d\ufffd::error" in printed
    assert "\n::error file=x" not in printed
    assert "\x1b[2J" not in printed
    if way not in ("json-lines", "junit"):  # for programs, which read it as it is
        assert "\u202e" not in printed

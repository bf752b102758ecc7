"""`define-method` changes no finding: the methods of a RAP may stand anywhere."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pytest

from rapc.analysis.driver import check_library
from rapc.base.source import SourceFile
from rapc.ir import nodes
from rapc.library.loader import Loaded, load, load_sources, load_text
from rapc.parser.parse import parse

CHECKOUT = Path(__file__).parents[2]
PROGRAMS = sorted(
    path
    for path in Path(__file__).parent.glob("*.rap")
    if path.stem != "suppressions"  # comments do not move with the methods
)
FOLDERS = [CHECKOUT / "stdlib" / "truck", CHECKOUT / "examples" / "laboratory"]


def moved(file: SourceFile) -> tuple[SourceFile, str]:
    """Return a file without the methods of its sound RAPs, and these as forms."""
    unit = parse(file)
    torn = [partial.form for partial in unit.partial]
    text, added = file.text, []
    for rap in unit.forms:
        if not isinstance(rap, nodes.DefineRap) or rap in torn:
            continue
        for method in rap.methods:
            start, end = method.span.start, method.span.end
            words = text[start:end].partition("method")
            added.append(f"(define-method {rap.name} {words[2]}")
            blank = "".join(c if c == "\n" else " " for c in text[start:end])
            text = text[:start] + blank + text[end:]
    return SourceFile(file.name, text), "\n".join(added)


def moved_apart(loaded: Loaded) -> Loaded:
    """Return a library with all its methods in files of their own, before the rest."""
    pairs = [moved(file) for file in loaded.files.values()]
    apart = [
        SourceFile(f"{file.name}.methods", text) for file, text in pairs if text.strip()
    ]
    return load_sources([*apart, *[file for file, _ in pairs]])


def findings(loaded: Loaded) -> Counter[tuple[str, str]]:
    report = check_library(load_sources(loaded.files.values()))
    return Counter((one.rule.name, one.diagnostic.message) for one in report.findings)


@pytest.mark.parametrize("path", [*PROGRAMS, *FOLDERS], ids=lambda path: path.stem)
def test_findings_are_those_of_methods_in_their_raps(path: Path) -> None:
    loaded = load([str(path)])
    apart = moved_apart(loaded)
    assert findings(apart) == findings(loaded)
    assert apart.library.raps == load_sources(loaded.files.values()).library.raps


RAP = """
(declare-memory-proposition done ())
(define-rap (work)
  (succeed (or (done) (method-tried fast)))
  (method slow (task-net)))
"""


def _rules(added: str) -> list[str]:
    return [rule for rule, _ in findings(load_text(RAP + added))]


def test_syntax_error_in_an_added_method_withholds_findings_of_its_rap() -> None:
    assert "unknown-method" in _rules("")
    assert "unknown-method" in _rules("(define-method work quick (task-net))")
    assert "unknown-method" not in _rules("(define-method work fast (task-net))")
    broken = _rules('(define-method work "fast" (task-net))')
    assert "malformed-clause" in broken
    assert "unknown-method" not in broken


def test_suppression_before_an_added_method_covers_its_findings() -> None:
    method = "(define-method work fast (task-net (t1 (work) (for t2))))"
    assert "unknown-tag" in _rules(method)
    assert "unknown-tag" not in _rules(f"; rapc: ignore[unknown-tag]\n{method}")

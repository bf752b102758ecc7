"""The bench of mutants: what is changed in a module, and that it stays Python."""

from __future__ import annotations

import ast
from pathlib import Path

from bench.mutants import chosen, folders_of, mutants

CHECKOUT = Path(__file__).parents[1]

SOURCE = '''"""A module."""

from typing import Annotated


def gone(x: "Annotated[int, 5]") -> bool:
    """Tell something."""
    if x < 3 and not done:
        log.append("word")
        state.x += 1
    return x == 2
'''


def test_mutants_change_what_runs_and_nothing_else() -> None:
    found = list(mutants("a.py", SOURCE))
    lines = [SOURCE.splitlines()[mutant.line - 1].strip() for mutant in found]
    assert not {'"""A module."""', '"""Tell something."""'} & {*lines}
    assert not any(line.startswith("def") for line in lines)
    assert sorted({mutant.kind for mutant in found}) == [
        *("and-or", "comparison", "condition", "constant"),
        *("negation", "result", "statement"),
    ]
    changed = {mutant.apply(SOURCE) for mutant in found}
    assert len(changed) == len(found)
    for text in changed:
        ast.parse(text)
        assert len(text.splitlines()) == len(SOURCE.splitlines())


def test_each_mutant_of_rapc_is_python_and_has_tests() -> None:
    drawn = chosen(CHECKOUT, 300, seed=1)
    assert drawn == chosen(CHECKOUT, 300, seed=1)
    for mutant in drawn:
        source = (CHECKOUT / mutant.file).read_text(encoding="utf-8")
        changed = mutant.apply(source)
        assert changed != source
        ast.parse(changed)
        assert all((CHECKOUT / tests).is_dir() for tests in folders_of(mutant.file))

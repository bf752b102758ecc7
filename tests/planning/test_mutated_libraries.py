"""Libraries with plans, changed at random: findings or runs, and no other exception."""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path
from random import Random

import pytest

import rapc
from tests.damage import slipped

FOLDER = Path(__file__).parents[1] / "rap"
TEXT = "\n".join(
    [(FOLDER / name).read_text() for name in ("say.rap", "planning.test.rap")]
).replace('(require "say")', "")

_WORD = re.compile(r"(?<=[(\s])[^()\s;\"]+(?=[)\s])")
_LIST = re.compile(r"\([^()]*\)|\((?:[^()]|\([^()]*\))*\)")
_OTHERS = ("?", "?x", "not", "may", "and", "or", "believe", "unknown", "7", "plan")


def mutant(seed: int) -> str:
    """Return the text with some words and lists replaced, doubled or removed."""
    dice, text = Random(seed), TEXT
    if seed % 8 == 0:
        return slipped(text, dice)
    for _ in range(dice.randint(1, 3)):
        pattern = dice.choice((_WORD, _LIST))
        found = list(pattern.finditer(text))
        one, other = dice.choice(found), dice.choice(found)
        after = dice.choice(("", one[0] * 2, other[0], other[0], dice.choice(_OTHERS)))
        text = text[: one.start()] + after + text[one.end() :]
    return text


def outcomes(seeds: range) -> Counter[str]:
    """Return how the tests of mutants ended; each seed is one mutant."""
    found: Counter[str] = Counter()
    for seed in seeds:
        try:
            results = rapc.test(f"\n;\n{mutant(seed)}".lstrip())
        except rapc.Error as error:
            found[type(error).__name__] += 1
        else:
            found.update("passed" if one.passed else "failed" for one in results)
    return found


def test_mutated_libraries_have_findings_or_runs() -> None:
    found = outcomes(range(60))
    assert min(found["CheckError"], found["failed"], found["passed"]) > 10


@pytest.mark.nightly
@pytest.mark.timeout(3600)
def test_many_mutated_libraries_have_findings_or_runs() -> None:
    found = outcomes(range(1000, 11_000))
    assert min(found["CheckError"], found["failed"], found["passed"]) > 1000

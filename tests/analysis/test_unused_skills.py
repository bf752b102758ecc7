"""Which skills that nothing enables are told of, over libraries of several files."""

from __future__ import annotations

from pathlib import Path

import pytest

from rapc.analysis.check_files import check_files

ARRIVED = "(declare-event :arrived ())"
DRIVE = "(declare-skill :drive () :events (:arrived))"
LOOK = "(declare-skill :look-out ())"
USE = """(require "words")
(define-rap (go)
  (method (primitive (enable (:drive)) (wait-for (:arrived) :succeed))))
"""


def unused(folder: Path, **files: str) -> list[str]:
    """The files in which a skill is told of that nothing enables, all checked."""
    for name, text in files.items():
        (folder / f"{name}.rap").write_text(text)
    return [
        Path(found.diagnostic.span.file).stem
        for found in check_files([str(folder)]).findings
        if found.rule.name == "unused-skill"
    ]


@pytest.mark.parametrize("besides", ["", "(declare-kind place)"])
def test_what_a_world_offers_need_not_all_be_used(tmp_path: Path, besides: str) -> None:
    words = ARRIVED + DRIVE + LOOK + besides
    assert unused(tmp_path, words=words, use=USE) == []


def test_a_file_with_raps_declares_what_it_uses(tmp_path: Path) -> None:
    words = ARRIVED + DRIVE
    assert unused(tmp_path, words=words, use=USE + LOOK) == ["use"]


def test_a_rap_beside_its_skills_makes_no_list_of_a_world(tmp_path: Path) -> None:
    words = ARRIVED + DRIVE + LOOK + "(define-rap (rest))"
    assert unused(tmp_path, words=words, use=USE) == ["words"]

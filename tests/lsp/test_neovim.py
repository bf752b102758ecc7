"""All features of the language server in Neovim, with `editors/neovim`."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from tests.lsp.programs import EXTRACTED, PYTHON, RAPS, SUPPRESSED, TESTS, WORLD

NVIM = shutil.which("nvim")

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(NVIM is None, reason="Neovim is not installed"),
    pytest.mark.xdist_group("neovim"),
]

HERE = Path(__file__).parent
CONFIG = HERE.parents[1] / "editors" / "neovim" / "rap.lua"

FEATURES = (
    *("findings", "quick_fix", "fix_all", "suppress", "declare", "define"),
    *("extract_and_inline", "hover", "definition", "references", "highlight"),
    *("rename", "calls", "symbols", "folding", "colours", "signature", "completion"),
    *("formatting", "typing", "inlay_hints", "code_lenses", "python"),
    *("test_files", "configuration"),
)
"""The functions of `neovim.lua`, in the order of the session."""


@pytest.fixture(scope="module")
def shown(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """What Neovim shows of each feature, in one session."""
    folder = tmp_path_factory.mktemp("robot")
    (folder / "rapc.toml").write_text("")
    (folder / "world.rap").write_text(WORLD)
    (folder / "raps.rap").write_text(RAPS)
    (folder / "raps.test.rap").write_text(TESTS)
    (folder / "robot.py").write_text(PYTHON)
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(
        [
            *(str(NVIM), "--headless", "--clean", "-i", "NONE", "-n"),
            *("-c", f"luafile {CONFIG}", "-c", f"luafile {HERE / 'neovim.lua'}"),
        ],
        check=False,
        cwd=folder,
        env={**os.environ, "PATH": path, "FEATURES": " ".join(FEATURES)},
        capture_output=True,
        text=True,
        timeout=120,
    )
    result = folder / "result.json"
    assert result.exists(), done.stderr
    found = json.loads(result.read_text())
    assert "problem" not in found, found["problem"]
    return found


def test_findings_have_pages_and_related_places(shown: Any) -> None:
    found = shown["findings"]
    unknown, duplicate = found["unknown-rap"], found["duplicate-tag"]
    assert unknown["message"] == "unknown RAP `goo`\nhelp: did you mean `go`?"
    assert unknown["page"].endswith("/rules/unknown-rap.md")
    assert (unknown["row"], duplicate["row"]) == (11, 12)
    assert duplicate["related"] == 1


def test_quick_fix_corrects_a_name(shown: Any) -> None:
    assert shown["quick_fix"] == RAPS


def test_fix_all_applies_all_safe_fixes(shown: Any) -> None:
    assert shown["fix_all"] == RAPS.replace("; Go", "\n; Go")


def test_finding_can_be_suppressed(shown: Any) -> None:
    assert shown["suppress"] == SUPPRESSED


def test_missing_declaration_is_added(shown: Any) -> None:
    declared = "(declare-memory-proposition seen (?place ?arg2))"
    assert declared in shown["declare"]


def test_unknown_step_becomes_a_rap(shown: Any) -> None:
    assert shown["define"].endswith(
        "\n\n(define-rap (inspect ?arg1 => ?seen)\n  (method (task-net)))\n"
    )


def test_steps_become_a_rap_and_are_inlined(shown: Any) -> None:
    found = shown["extract_and_inline"]
    assert found["extracted"] == EXTRACTED
    assert found["inlined"].startswith(RAPS)


def test_hover_shows_documentation_and_uses(shown: Any) -> None:
    assert "(drive (?place symbol))" in shown["hover"]
    assert "Drive to a place. äöü 🤖" in shown["hover"]
    assert "used 3 times: `go`, `drives`" in shown["hover"]


def test_names_lead_to_definitions_and_uses(shown: Any) -> None:
    assert shown["definition"] == ["world.rap", 2]
    assert [one[:2] for one in shown["references"]] == [
        ["raps.rap", 4],
        ["raps.rap", 12],
        ["raps.rap", 13],
        ["raps.test.rap", 5],
    ]
    assert shown["highlight"] == 3


def test_rename_changes_all_files(shown: Any) -> None:
    assert shown["rename"]["raps"] == RAPS.replace("(go ", "(travel ")
    assert shown["rename"]["tests"] == TESTS.replace("(go ", "(travel ")


def test_calls_lead_both_ways(shown: Any) -> None:
    assert shown["calls"] == {
        "incoming": [["raps.rap", 12, "tour"], ["raps.rap", 13, "tour"]],
        "outgoing": [["raps.rap", 12, "go"], ["raps.rap", 13, "go"]],
    }


def test_symbols_of_a_file_and_of_the_workspace(shown: Any) -> None:
    found = shown["symbols"]
    assert ["raps.rap", 9, "[Function] tour"] in found["file"]
    assert ["raps.rap", 13, "[Object] t2 go"] in found["file"]
    names = {text.partition("] ")[2] for _, _, text in found["workspace"]}
    assert names == {"drive", "drives"}


def test_folding_has_the_forms(shown: Any) -> None:
    """Old versions show no folds: the answer has all lists."""
    assert [fold for fold in shown["folding"] if fold[0] in (4, 9)] == [[4, 7], [9, 13]]


def test_words_have_colours(shown: Any) -> None:
    """Old versions show no colours: the answer has a token for each word."""
    if isinstance(shown["colours"], int):
        assert shown["colours"] > 20
    else:
        assert shown["colours"] == {
            "define-rap": "keyword",
            "go ?place": "function",
            "?place": "variable",
            "; Go": "comment",
            '"world"': "string",
        }


def test_signature_and_completion(shown: Any) -> None:
    assert "(at ?thing ?place)" in shown["signature"]
    assert shown["completion"] == ["tour"]


def test_formatting_of_file_range_and_line(shown: Any) -> None:
    assert shown["formatting"]["file"] == RAPS
    assert shown["formatting"]["range"] == RAPS.replace("(t1 (go", "(t1  (go")
    assert shown["typing"] == 8


def test_inlay_hints_show_inferred_kinds(shown: Any) -> None:
    assert shown["inlay_hints"] == ": symbol"


def test_lenses_count_callers_and_run_tests(shown: Any) -> None:
    found = shown["code_lenses"]
    assert found["raps"] == ["2 callers", "0 callers"]
    assert found["tests"] == ["run test"]
    assert found["result"].startswith("test `drives`: passed")


def test_declarations_and_handlers_in_python(shown: Any) -> None:
    assert shown["python"]["handler"] == ["robot.py", 4]
    assert shown["python"]["declaration"] == ["world.rap", 2]


def test_test_files_and_configuration_are_checked(shown: Any) -> None:
    assert shown["test_files"] == ["unknown-rap"]
    assert "unknown key `check`" in shown["configuration"]

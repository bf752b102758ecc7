"""The features of the language server as an editor shows them: tests of any editor."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tests.lsp.programs import EXTRACTED, PYTHON, RAPS, SUPPRESSED, TESTS, WORLD

FEATURES = (
    *("findings", "quick_fix", "fix_all", "suppress", "declare", "define"),
    *("extract_and_inline", "hover", "definition", "references", "highlight"),
    *("rename", "calls", "symbols", "folding", "colours", "signature", "completion"),
    *("formatting", "typing", "inlay_hints", "code_lenses", "python"),
    *("test_files", "configuration"),
)
"""The functions of `neovim.lua` and `emacs.el`, in the order of the session."""


def project(folder: Path) -> Path:
    """Write a project into a folder, and return the folder."""
    (folder / "rapc.toml").write_text("")
    (folder / "world.rap").write_text(WORLD)
    (folder / "raps.rap").write_text(RAPS)
    (folder / "raps.test.rap").write_text(TESTS)
    (folder / "robot.py").write_text(PYTHON)
    return folder


class Features:
    """The tests of one editor; `shown` is what the editor shows of each feature."""

    def test_findings_follow_edits(self, shown: Any) -> None:
        unknown, duplicate = shown["findings"]
        assert unknown[0] == 12
        assert unknown[1].endswith("unknown RAP `goo`\nhelp: did you mean `go`?")
        assert duplicate[0] == 13
        assert "duplicate tag `t1`" in duplicate[1]

    def test_quick_fix_corrects_a_name(self, shown: Any) -> None:
        assert shown["quick_fix"] == RAPS

    def test_fix_all_applies_all_safe_fixes(self, shown: Any) -> None:
        assert shown["fix_all"] == RAPS

    def test_finding_can_be_suppressed(self, shown: Any) -> None:
        assert shown["suppress"] == SUPPRESSED

    def test_missing_declaration_is_added(self, shown: Any) -> None:
        declared = "(declare-memory-proposition seen (?place ?arg2))"
        assert declared in shown["declare"]

    def test_unknown_step_becomes_a_rap(self, shown: Any) -> None:
        assert shown["define"].endswith(
            "\n\n(define-rap (inspect ?arg1 => ?seen)\n  (method (task-net)))\n"
        )

    def test_steps_become_a_rap_and_are_inlined(self, shown: Any) -> None:
        found = shown["extract_and_inline"]
        assert found["extracted"] == EXTRACTED
        assert found["inlined"].startswith(RAPS)

    def test_hover_shows_documentation_and_uses(self, shown: Any) -> None:
        assert "(drive (?place symbol))" in shown["hover"]
        assert "Drive to a place. äöü 🤖" in shown["hover"]
        assert "used 3 times: `go`, `drives`" in shown["hover"]

    def test_names_lead_to_definitions_and_uses(self, shown: Any) -> None:
        assert shown["definition"] == ["world.rap", 2]
        assert shown["references"] == [
            ["raps.rap", 4],
            ["raps.rap", 12],
            ["raps.rap", 13],
            ["raps.test.rap", 5],
        ]
        assert shown["highlight"] == 3

    def test_rename_changes_all_files(self, shown: Any) -> None:
        assert shown["rename"]["raps"] == RAPS.replace("(go ", "(travel ")
        assert shown["rename"]["tests"] == TESTS.replace("(go ", "(travel ")

    def test_calls_lead_both_ways(self, shown: Any) -> None:
        assert shown["calls"] == {"incoming": "tour", "outgoing": "go"}

    def test_symbols_of_a_file_and_of_the_workspace(self, shown: Any) -> None:
        names = {"go", "tour", "t1 go", "t2 go"}
        assert names <= {*shown["symbols"]["file"]}
        assert shown["symbols"]["workspace"] == ["drive", "drives"]

    def test_folding_has_the_forms(self, shown: Any) -> None:
        """An answer has all lists; Neovim closes only the outer folds."""
        outer = [fold for fold in shown["folding"] if fold[0] in (4, 9)]
        assert outer == [[4, 7], [9, 13]]

    def test_signature_and_completion(self, shown: Any) -> None:
        assert "(at ?thing ?place)" in shown["signature"]
        assert shown["completion"] == ["tour"]

    def test_formatting_of_file_range_and_line(self, shown: Any) -> None:
        assert shown["formatting"]["file"] == RAPS
        assert shown["formatting"]["range"] == RAPS.replace("(t1 (go", "(t1  (go")
        assert shown["typing"] == 8

    def test_inlay_hints_show_inferred_kinds(self, shown: Any) -> None:
        assert shown["inlay_hints"] == ": symbol"

    def test_lenses_count_callers_and_run_tests(self, shown: Any) -> None:
        found = shown["code_lenses"]
        assert found["raps"] == ["2 callers", "0 callers"]
        assert found["tests"] == ["run test"]
        assert found["result"].startswith("test `drives`: passed")

    def test_declarations_and_handlers_in_python(self, shown: Any) -> None:
        assert shown["python"]["handler"] == ["robot.py", 4]
        assert shown["python"]["declaration"] == ["world.rap", 2]

    def test_test_files_and_configuration_are_checked(self, shown: Any) -> None:
        assert "unknown RAP `goo`" in shown["test_files"]
        assert "unknown key `check`" in shown["configuration"]

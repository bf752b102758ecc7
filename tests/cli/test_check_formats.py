"""The formats of `rapc check` for other programs, read as those programs read them."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from rapc.analysis import registry

from .command import rapc

TWO = """\
(define-rap (go ?place)
  (succeed (at ?plase))
  (method (task-net (t1 (walk ?place)))))
"""
"""Two errors, undeclared-predicate and unknown-rap, and a misspelt variable."""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with a library that has findings in one of two files."""
    (tmp_path / "lib").mkdir()
    (tmp_path / "lib" / "a b%,:c.rap").write_text(TWO)
    (tmp_path / "lib" / "sound.rap").write_text("(define-rap (wait))\n")
    return tmp_path


def _output(folder: Path, form: str) -> str:
    done = rapc("check", "lib", "--output-format", form, cwd=folder)
    assert (done.returncode, done.stderr) == (1, "")
    return done.stdout


def _xml(text: str) -> ElementTree.Element:
    return ElementTree.fromstring(text)  # noqa: S314  # written by rapc


def _rows(folder: Path) -> list[dict[str, Any]]:
    found = json.loads(_output(folder, "json"))
    assert isinstance(found, list)
    assert len(found) >= 2
    return found


def test_json_lines_hold_the_same_objects_as_json(folder: Path) -> None:
    lines = _output(folder, "json-lines").splitlines()
    assert [json.loads(line) for line in lines] == _rows(folder)


def test_grouped_names_each_file_once(folder: Path) -> None:
    lines = _output(folder, "grouped").splitlines()
    assert lines[0] == "lib/a b%,:c.rap:"
    assert sum(line.startswith("lib/") for line in lines) == 1
    row = _rows(folder)[0]
    place = f"{row['location']['row']}:{row['location']['column']}"
    title = f"{row['severity']}[{row['code']} {row['name']}]"
    assert lines[1] == f"  {place}: {title}: {row['message']}"


def test_sarif_has_every_rule_and_each_finding_at_its_place(folder: Path) -> None:
    log = json.loads(_output(folder, "sarif"))
    assert log["version"] == "2.1.0"
    (run,) = log["runs"]
    assert run["columnKind"] == "unicodeCodePoints"
    rules = run["tool"]["driver"]["rules"]
    assert [rule["id"] for rule in rules] == [r.code for r in registry.rules().values()]
    rows = _rows(folder)
    assert len(run["results"]) == len(rows)
    for result, row in zip(run["results"], rows, strict=True):
        assert rules[result["ruleIndex"]]["id"] == result["ruleId"] == row["code"]
        place = result["locations"][0]["physicalLocation"]
        assert place["artifactLocation"]["uri"] == "lib/a%20b%25%2C%3Ac.rap"
        start, end = row["location"], row["end_location"]
        assert place["region"] == {
            "startLine": start["row"],
            "startColumn": start["column"],
            "endLine": end["row"],
            "endColumn": end["column"],
        }
        assert result["message"]["text"].startswith(row["message"])
    prints = [r["partialFingerprints"]["rapc/v1"] for r in run["results"]]
    assert len(set(prints)) == len(prints)


def test_sarif_fingerprints_outlast_lines_put_in_above(folder: Path) -> None:
    def prints() -> list[str]:
        (run,) = json.loads(_output(folder, "sarif"))["runs"]
        return [r["partialFingerprints"]["rapc/v1"] for r in run["results"]]

    before = prints()
    file = folder / "lib" / "a b%,:c.rap"
    file.write_text(f"; one\n; two\n(define-rap (other))\n{TWO}")
    assert prints() == before


def test_github_commands_are_escaped(folder: Path) -> None:
    lines = _output(folder, "github").splitlines()
    rows = _rows(folder)
    assert len(lines) == len(rows)
    for line, row in zip(lines, rows, strict=True):
        found = re.fullmatch(r"::(error|warning|notice) (.*?)::(.*)", line)
        assert found is not None
        keys = dict(part.split("=", 1) for part in found[2].split(","))
        assert keys["file"] == "lib/a b%25%2C%3Ac.rap"
        assert int(keys["line"]) == row["location"]["row"]
        assert int(keys["col"]) == row["location"]["column"]
        assert keys["title"] == f"{row['code']} {row['name']}"
        assert found[3].startswith(row["message"].replace("%", "%25"))


def test_junit_has_a_suite_for_each_file(folder: Path) -> None:
    top = _xml(_output(folder, "junit"))
    rows = _rows(folder)
    assert top.attrib["failures"] == str(len(rows))
    suites = {s.attrib["name"]: s for s in top}
    assert set(suites) == {"lib/a b%,:c.rap", "lib/sound.rap"}
    sound = suites["lib/sound.rap"]
    assert [c.attrib["name"] for c in sound] == ["no findings"]
    failures = top.findall(".//failure")
    assert [f.attrib["message"] for f in failures] == [r["message"] for r in rows]


@pytest.mark.parametrize("form", ["sarif", "github", "junit", "json-lines", "grouped"])
def test_a_sound_library_leaves_every_format_well_formed(
    form: str, tmp_path: Path
) -> None:
    (tmp_path / "sound.rap").write_text("(define-rap (wait))\n")
    done = rapc("check", "sound.rap", "--output-format", form, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    if form == "sarif":
        assert json.loads(done.stdout)["runs"][0]["results"] == []
    elif form == "junit":
        assert _xml(done.stdout).attrib["failures"] == "0"
    elif form == "grouped":
        assert done.stdout == "checked 1 file, 1 RAP: no findings\n"
    else:
        assert done.stdout == ""


def test_output_goes_to_a_file_and_the_summary_to_the_terminal(folder: Path) -> None:
    wanted = _output(folder, "concise").splitlines(keepends=True)
    done = rapc(
        *("check", "lib", "--output-format", "concise", "--output-file", "out.txt"),
        cwd=folder,
    )
    assert (done.returncode, done.stdout) == (1, wanted[-1])
    assert (folder / "out.txt").read_text() == "".join(wanted[:-1])


@pytest.mark.parametrize("option", ["--output-file", "--write-baseline"])
def test_an_input_is_not_written_over(option: str, folder: Path) -> None:
    file = folder / "lib" / "a b%,:c.rap"
    done = rapc("check", "lib", option, str(file), cwd=folder)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == f"error: {option}: `{file}` is a source file of the library\n"
    assert file.read_text() == TWO


def test_output_does_not_overwrite_configuration_or_baseline(folder: Path) -> None:
    (folder / "rapc.toml").write_text("")
    assert rapc("check", "lib", "--write-baseline", "known", cwd=folder).returncode == 0
    settled = ("--config", "rapc.toml", "--baseline", "known")
    for option, file, others in (
        ("--output-file", "rapc.toml", settled),
        ("--output-file", "known", settled),
        ("--write-baseline", "rapc.toml", settled[:2]),
    ):
        before = (folder / file).read_text()
        done = rapc("check", "lib", *others, option, file, cwd=folder)
        assert done.returncode == 2
        assert done.stderr == f"error: {option}: `{file}` configures the report\n"
        assert (folder / file).read_text() == before


def test_statistics_count_the_findings_of_each_rule(folder: Path) -> None:
    rows = _rows(folder)
    done = rapc("check", "lib", "--statistics", cwd=folder)
    counted = re.findall(r"^ *(\d+)  (RAP\d+) ", done.stdout, re.MULTILINE)
    assert {code: int(n) for n, code in counted} == {
        row["code"]: sum(r["code"] == row["code"] for r in rows) for row in rows
    }
    done = rapc("check", "lib", "--statistics", "--output-format", "json", cwd=folder)
    assert sum(row["count"] for row in json.loads(done.stdout)) == len(rows)
    done = rapc("check", "lib", "--statistics", "--output-format", "sarif", cwd=folder)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == (
        "error: --statistics requires the output format full or json\n"
    )

"""`rapc check` as a user meets it: output, exit statuses, selection, options."""

from __future__ import annotations

import json
from pathlib import Path

import click
import pytest

from rapc.analysis.registry import rules
from rapc.cli.check import check
from rapc.cli.check_options import Options

from .command import rapc

CLEAN = "(define-rap (wait))\n"
ERROR = "(define-rap (go) (method (task-net (t1 (wait)))))\n"
WARNING = "; rapc: ignore[unknown-rap] nothing to ignore\n(define-rap (wait))\n"
INFO = """\
(declare-memory-property open (?door ?is) unknown)
(define-rap (pass ?door) (succeed (open ?door)))
"""


@pytest.fixture
def program(tmp_path: Path) -> Path:
    """A file to write a program to."""
    return tmp_path / "program.rap"


def test_clean_library_is_one_line(tmp_path: Path) -> None:
    (tmp_path / "one.rap").write_text(CLEAN)
    (tmp_path / "two.rap").write_text("(define-rap (go) (method (task-net)))")
    done = rapc("check", ".", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout == "checked 2 files, 2 RAPs: no findings\n"


@pytest.mark.parametrize("args", [("-q", "check"), ("check", "-q")])
def test_quiet_prints_findings_alone(
    args: tuple[str, ...], program: Path, tmp_path: Path
) -> None:
    program.write_text(CLEAN)
    assert rapc(*args, "program.rap", cwd=tmp_path).stdout == ""
    program.write_text(ERROR)
    done = rapc(*args, "program.rap", "--output-format", "concise", cwd=tmp_path)
    assert done.stdout == (
        "program.rap:1:41: error[RAP013 unknown-rap]: unknown RAP `wait`\n"
    )


@pytest.mark.parametrize(
    ("text", "args", "status"),
    [
        (ERROR, (), 1),
        (WARNING, (), 1),
        (INFO, (), 0),
        (ERROR, ("--exit-zero",), 0),
        (ERROR, ("--fail-level", "error"), 1),
        (WARNING, ("--fail-level", "error"), 0),
        (WARNING, ("--fail-level", "info"), 1),
        (INFO, ("--fail-level", "info"), 1),
    ],
)
def test_exit_status_follows_severity(
    text: str, args: tuple[str, ...], status: int, program: Path
) -> None:
    program.write_text(text)
    done = rapc("check", str(program), *args)
    assert done.returncode == status
    assert "no findings" not in done.stdout


@pytest.mark.parametrize(
    ("args", "found"),
    [
        ((), ["unknown-rap", "undeclared-predicate"]),
        (("--select", "unknown-rap"), ["unknown-rap"]),
        (("--select", "rap013"), ["unknown-rap"]),
        (("--select", "RAP013,RAP015"), ["unknown-rap", "undeclared-predicate"]),
        (("--ignore", "unknown-rap"), ["undeclared-predicate"]),
        (("--ignore", "RAP013", "--ignore", "RAP015"), []),
        (("--select", "RAP013", "--ignore", "RAP013"), []),
        (
            ("--select", "RAP013", "--extend-select", "undeclared-predicate"),
            ["unknown-rap", "undeclared-predicate"],
        ),
    ],
)
def test_rules_are_selected_by_code_and_name(
    args: tuple[str, ...], found: list[str], program: Path
) -> None:
    program.write_text(
        "(define-rap (stop))"
        "(define-rap (go) (method (task-net (t1 (wait) ((ready) for t2)) (t2 (stop)))))"
    )
    done = rapc("check", str(program), "--output-format", "json", *args)
    assert [one["name"] for one in json.loads(done.stdout)] == found
    assert done.returncode == (1 if found else 0)


def test_select_all_reports_opt_in_rules(program: Path) -> None:
    program.write_text(rules()["joined-by-unknown"].page.example)
    check = ("check", str(program), "--output-format", "json")
    assert "joined-by-unknown" not in rapc(*check).stdout
    found = json.loads(rapc(*check, "--select", "ALL").stdout)
    assert "joined-by-unknown" in [one["name"] for one in found]
    done = rapc(*check, "--select", "all", "--per-file-ignores", "program.rap:ALL")
    assert json.loads(done.stdout) == []


def test_json_of_nothing_is_an_empty_list(program: Path) -> None:
    program.write_text(CLEAN)
    done = rapc("check", str(program), "--output-format", "json")
    assert (done.returncode, done.stdout) == (0, "[]\n")


def test_standard_input_is_read(tmp_path: Path) -> None:
    (tmp_path / "waiting.rap").write_text(CLEAN)
    text = f'(require "waiting")\n{ERROR}'
    done = rapc("check", "-", cwd=tmp_path, stdin=text)
    assert done.stdout == "checked 2 files, 2 RAPs: no findings\n"
    done = rapc("check", "-", "--output-format", "concise", stdin="(define-rup (a))")
    assert done.returncode == 1
    assert done.stdout.startswith("<stdin>:1:2: error[")


def test_tests_in_folders_are_checked_too(tmp_path: Path) -> None:
    (tmp_path / "waiting.test.rap").write_text("(nonsense)\n(define-rap (a))")
    named = rapc("check", "waiting.test.rap", cwd=tmp_path)
    assert named.returncode == 1
    assert named.stdout.endswith("checked 1 file, 1 RAP: 1 error\n")
    assert rapc("check", ".", cwd=tmp_path).stdout == named.stdout
    (tmp_path / "waiting.rap").write_text(CLEAN)
    done = rapc("check", ".", cwd=tmp_path)
    assert done.returncode == 1
    assert done.stdout.endswith("checked 2 files, 2 RAPs: 1 error\n")


def test_colour_is_asked_for_or_not(program: Path) -> None:
    program.write_text(ERROR)
    assert "\x1b[" not in rapc("check", str(program)).stdout
    assert "\x1b[" in rapc("check", "--color", "always", str(program)).stdout
    assert "\x1b[" in rapc("--color", "always", "check", str(program)).stdout
    colourless = rapc("check", "--color", "never", str(program)).stdout
    assert "\x1b[" not in colourless
    assert "error[RAP013 unknown-rap]" in colourless


def test_verbose_tells_on_standard_error(program: Path) -> None:
    program.write_text(CLEAN)
    done = rapc("check", "-v", str(program))
    assert done.stderr.startswith(f"read {program}\nran ")
    assert done.stdout == "checked 1 file, 1 RAP: no findings\n"


def test_unknown_rule_is_a_usage_error(program: Path) -> None:
    program.write_text(CLEAN)
    done = rapc("check", str(program), "--select", "unbound-varable")
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == (
        "error: unknown rule `unbound-varable`; did you mean `unbound-variable`?\n"
    )


@pytest.mark.parametrize("name", ["gitlab", "text", "FULL"])
def test_other_output_formats_are_refused(name: str, program: Path) -> None:
    program.write_text(ERROR)
    done = rapc("check", str(program), "--output-format", name)
    assert (done.returncode, done.stdout) == (2, "")
    assert len(done.stderr.splitlines()) == 1


@pytest.mark.parametrize("option", ["--wach", "--cache", "--fixes"])
def test_unknown_options_are_refused(option: str, program: Path) -> None:
    program.write_text(ERROR)
    done = rapc("check", str(program), option)
    assert (done.returncode, done.stdout) == (2, "")
    assert f"unknown option `{option}`" in done.stderr


def test_each_option_of_check_is_a_field_of_one_table() -> None:
    made = {param.name for param in check.params if isinstance(param, click.Option)}
    common = {"color", "quiet", "verbose"}
    assert made - common == {*Options.__struct_fields__} - {"paths", "texts"}

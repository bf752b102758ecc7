"""The configuration of `rapc check`, and baselines: where found, what refused."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from .command import rapc

TWO = "(define-rap (go) (succeed (at home)) (method (task-net (t1 (walk)))))\n"
"""An undeclared predicate and an unknown RAP."""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A project with a library in a folder of its own."""
    (tmp_path / "lib").mkdir()
    (tmp_path / "lib" / "go.rap").write_text(TWO)
    return tmp_path


def _found(folder: Path, *args: str) -> list[str]:
    done = rapc("check", "lib", "--output-format", "json", *args, cwd=folder)
    assert done.stderr == ""
    return [f"{row['name']} {row['severity']}" for row in json.loads(done.stdout)]


BOTH = ["undeclared-predicate error", "unknown-rap error"]


def test_without_configuration_everything_is_reported(folder: Path) -> None:
    assert _found(folder) == BOTH


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("rapc.toml", 'ignore = ["RAP013"]'),
        ("pyproject.toml", '[tool.rapc]\nignore = ["unknown-rap"]'),
        ("lib/rapc.toml", 'select = ["undeclared-predicate"]'),
        ("rapc.toml", '[per-file-ignores]\n"lib/*.rap" = ["unknown-rap"]'),
        ("lib/rapc.toml", '[per-file-ignores]\n"go.rap" = ["unknown-rap"]'),
    ],
)
def test_the_nearest_configuration_counts(name: str, text: str, folder: Path) -> None:
    (folder / name).write_text(text)
    assert _found(folder) == BOTH[:1]
    assert _found(folder, "--isolated") == BOTH


def test_one_folder_up_does_not_count_beside_a_nearer_one(folder: Path) -> None:
    (folder / "rapc.toml").write_text('ignore = ["unknown-rap"]')
    (folder / "lib" / "rapc.toml").write_text("")
    assert _found(folder) == BOTH
    (folder / "lib" / "rapc.toml").unlink()
    (folder / "lib" / "pyproject.toml").write_text("[project]\nname = 'x'")
    assert _found(folder) == BOTH[:1]


def test_options_count_more_than_the_configuration(folder: Path) -> None:
    (folder / "rapc.toml").write_text('ignore = ["unknown-rap"]')
    assert _found(folder, "--extend-select", "RAP013") == BOTH
    assert _found(folder, "--select", "RAP013") == BOTH[1:]
    assert _found(folder, "--ignore", "undeclared-predicate") == []


def test_severities_can_be_changed_and_decide_the_exit_status(folder: Path) -> None:
    (folder / "rapc.toml").write_text(
        '[severity]\nRAP013 = "info"\nundeclared-predicate = "warning"\n'
    )
    assert _found(folder) == ["undeclared-predicate warning", "unknown-rap info"]
    assert rapc("check", "lib", cwd=folder).returncode == 1
    (folder / "rapc.toml").write_text(
        'fail-level = "error"\noutput-format = "concise"\n'
        '[severity]\nRAP013 = "info"\nundeclared-predicate = "warning"\n'
    )
    done = rapc("check", "lib", cwd=folder)
    assert done.returncode == 0
    assert done.stdout.startswith("lib/go.rap:1:28: warning[")


def test_a_configuration_can_be_named(folder: Path) -> None:
    (folder / "other.toml").write_text('ignore = ["unknown-rap"]')
    assert _found(folder, "--config", "other.toml") == BOTH[:1]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (
            'ignor = ["x"]',
            "unknown key `ignor`\n  did you mean `ignore`?",
        ),
        ("ignore = 3", "`ignore`: expected a list, got a whole number"),
        ("ignore = [3]", "`ignore 1`: expected text, got a whole number"),
        ('fail-level = "grave"', "`fail-level`: there is no value `grave` here"),
        ('select = "RAP013"', "`select`: expected a list, got text"),
        ("ignore = [", None),
        ('output-format = "pdf"', "unknown output format `pdf`"),
    ],
)
def test_a_bad_configuration_is_refused(
    text: str, said: str | None, folder: Path
) -> None:
    file = folder / "rapc.toml"
    file.write_text(text)
    done = rapc("check", "lib", cwd=folder)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith(f"error: `{file}`: {said or ''}")


def test_an_unknown_rule_in_a_configuration_is_refused(folder: Path) -> None:
    (folder / "rapc.toml").write_text('ignore = ["unknown-rup"]')
    done = rapc("check", "lib", cwd=folder)
    assert (done.returncode, done.stdout) == (2, "")
    assert "unknown rule `unknown-rup`; did you mean `unknown-rap`?" in done.stderr


def test_baseline_hides_known_findings(folder: Path) -> None:
    done = rapc("check", "lib", "--write-baseline", "known.json", cwd=folder)
    assert (done.returncode, done.stdout) == (0, "wrote 2 findings to known.json\n")
    done = rapc("check", "lib", "--baseline", "known.json", cwd=folder)
    assert done.returncode == 0
    assert done.stdout == (
        "checked 1 file, 1 RAP: no findings; 2 hidden by known.json\n"
    )
    file = folder / "lib" / "go.rap"
    file.write_text(f"; moved\n\n{TWO}(define-rap (new) (succeed (up)))\n")
    new = _found(folder, "--baseline", "known.json")
    assert new == ["undeclared-predicate error"]
    file.write_text("(define-rap (go))\n")
    done = rapc("check", "lib", "--baseline", "known.json", cwd=folder)
    assert done.stdout.endswith(
        "2 findings of known.json are fixed: write the baseline again\n"
    )


def test_a_baseline_is_seen_from_its_own_folder(folder: Path) -> None:
    rapc("check", "lib", "--write-baseline", "known.json", cwd=folder)
    (folder / "rapc.toml").write_text('baseline = "known.json"')
    done = rapc("check", ".", cwd=folder / "lib")
    assert (done.returncode, done.stderr) == (0, "")
    assert "no findings; 2 hidden by" in done.stdout


@pytest.mark.parametrize("text", ["", "[]", '{"rapc-baseline": 9, "findings": []}'])
def test_invalid_baseline_is_refused(text: str, folder: Path) -> None:
    (folder / "known.json").write_text(text)
    done = rapc("check", "lib", "--baseline", "known.json", cwd=folder)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("error: `known.json` is ")
    assert "`object`" not in done.stderr


# --- the cache of earlier versions ----------------------------------------------------


@pytest.mark.parametrize("options", [(), ("--no-cache",)])
def test_cache_options_have_no_effect(folder: Path, options: tuple[str, ...]) -> None:
    large = "".join(f"(define-rap (r{n}) (succeed (p {n:060})))\n" for n in range(600))
    (folder / "lib" / "go.rap").write_text(large)
    plain = rapc("check", "lib", cwd=folder)
    (folder / "rapc.toml").write_text('cache-dir = ".rapc_cache"')
    before = sorted(folder.rglob("*"))
    done = rapc("check", "lib", *options, cwd=folder, XDG_CACHE_HOME=str(folder))
    assert (done.stdout, done.returncode) == (plain.stdout, 1)
    assert sorted(folder.rglob("*")) == before

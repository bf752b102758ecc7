"""`rapc new`: the project of the first tutorial, and names that are refused."""

from __future__ import annotations

import shlex
from pathlib import Path

import pytest

from rapc.cli.new import FILES
from tests.docs.pages import blocks, page
from tests.planning.logistics import DOMAIN, PROBLEM

from .command import rapc


def test_new_project_passes_its_checks_and_tests(tmp_path: Path) -> None:
    made = rapc("new", "my-robot", cwd=tmp_path)
    assert made.returncode == 0
    assert made.stdout.startswith("created my-robot: ")
    folder = tmp_path / "my-robot"
    found = {str(p.relative_to(folder)) for p in folder.rglob("*") if p.is_file()}
    assert found == {*FILES.values()}
    checked = rapc("check", ".", cwd=folder)
    assert checked.stdout == "checked 3 files, 4 RAPs: no findings\n"
    assert rapc("fmt", "--check", ".", cwd=folder).returncode == 0
    kept = rapc("worlds", "home:HomeWorld", "--test", "home.rap", cwd=folder)
    assert "7 checks passed" in kept.stdout
    tested = rapc("test", ".", "--seeds", "3", cwd=folder)
    assert tested.stdout.endswith("2 tests, each under 3 seeds: 2 passed\n")


def test_new_project_has_the_files_of_the_tutorial(tmp_path: Path) -> None:
    rapc("new", "robot", cwd=tmp_path)
    shown: dict[str, str] = {}
    for block in blocks(page("tutorials/first-robot")):
        name = block.name.removesuffix(" (continued)")
        before = f"{shown[name].rstrip()}\n\n" if name != block.name else ""
        shown[name] = before + block.text
    for name in ("home.py", "home.rap", "fetch.rap", "fetch.test.rap"):
        made = (tmp_path / "robot" / name).read_text(encoding="utf-8")
        assert made.split() == shown[name].split()


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("taken", "error: `taken` already exists\n"),
        ("", "error: invalid name ``: expected letters, digits, `-`, `_` and `.`\n"),
        (
            "a/b",
            "error: invalid name `a/b`: expected letters, digits, `-`, `_` and `.`\n",
        ),
        (
            "..",
            "error: invalid name `..`: expected letters, digits, `-`, `_` and `.`\n",
        ),
    ],
)
def test_new_refuses_a_name(name: str, said: str, tmp_path: Path) -> None:
    (tmp_path / "taken").write_text("mine")
    made = rapc("new", name, cwd=tmp_path)
    assert (made.returncode, made.stderr) == (2, said)
    assert [path.name for path in tmp_path.iterdir()] == ["taken"]
    assert (tmp_path / "taken").read_text() == "mine"


def test_new_leaves_nothing_if_the_system_refuses_the_folder(tmp_path: Path) -> None:
    made = rapc("new", "x" * 300, cwd=tmp_path)
    assert made.returncode == 2
    assert made.stderr.startswith("error: cannot create `xxx")
    assert list(tmp_path.iterdir()) == []


def test_domain_becomes_a_library_and_its_goal_a_command(tmp_path: Path) -> None:
    (tmp_path / "d.pddl").write_text(DOMAIN)
    (tmp_path / "p.pddl").write_text(PROBLEM)
    options = ("--pddl", "d.pddl", "--problem", "p.pddl")
    made = rapc("new", "moves.rap", *options, cwd=tmp_path)
    assert made.returncode == 0
    created, printed = made.stdout.splitlines()
    assert created == "created moves.rap"
    name, *arguments = shlex.split(printed.partition(": ")[2])
    assert name == "rapc"
    planned = rapc(*arguments, "--format", "steps", cwd=tmp_path)
    assert planned.returncode == 0
    assert "(fly a1 ap2 ap1)" in planned.stdout
    assert rapc("check", "moves.rap", cwd=tmp_path).returncode == 0


def test_domain_that_cannot_be_read_makes_no_file(tmp_path: Path) -> None:
    (tmp_path / "d.pddl").write_text("(define (domain d)\n (:derived (p)))")
    for options, said in (
        (("m.rap", "--pddl", "d.pddl"), "d.pddl:2:3: unsupported section `:derived`"),
        (("m.rap", "--pddl", "e.pddl"), "cannot read `e.pddl`"),
        (("m", "--pddl", "d.pddl"), "NAME: expected the name of a RAP file"),
        (("m.rap", "--problem", "d.pddl"), "--problem requires --pddl"),
    ):
        made = rapc("new", *options, cwd=tmp_path)
        assert made.returncode == 2
        assert said in made.stderr
    assert not (tmp_path / "m.rap").exists()

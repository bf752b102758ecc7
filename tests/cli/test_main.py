"""The command as a whole: help, slips of the pen, faults, interrupts, closed pipes."""

from __future__ import annotations

import errno
import os
import re
import signal
import subprocess
import sys
import tomllib
from collections.abc import Sequence
from pathlib import Path

import pytest

from rapc.cli import main
from tests.docs.pages import page

from .command import COMMAND, rapc

FOREIGN = ("lark", "networkx", "rich", "prompt_toolkit", "pebble", "matplotlib")
RUNNING = ("host", "compiler", "experiments", "repl", "runtime", "testing", "worlds")
CHECKOUT = Path(__file__).parents[2]
CHECKING = ("analysis", "ir", "loader", "parser", "render")
FOR_FEW = ("importlib.metadata", "difflib", "shutil")
SELDOM = (
    *("testing.faults", "worlds.scripted"),
    "analysis.checks.protections",
)


def test_help_lists_the_commands_with_examples() -> None:
    done = rapc("--help")
    assert done.returncode == 0
    assert rapc("-h").stdout == done.stdout
    for command in ("check", "rule", "run", "worlds"):
        assert f"\n  {command} " in done.stdout
    assert "Examples:\n    rapc check" in done.stdout


@pytest.mark.parametrize("command", ["check", "rule"])
def test_each_command_has_help_with_examples(command: str) -> None:
    done = rapc(command, "-h")
    assert done.returncode == 0
    assert f"Examples:\n    rapc {command}" in done.stdout


def _imported(code: str, *args: str) -> set[str]:
    """The modules that a process has when it ends, after running some code."""
    tell = "import atexit, sys; atexit.register(lambda: print(*sys.modules))"
    done = subprocess.run(
        [sys.executable, "-c", f"{tell}\n{code}", *args],
        capture_output=True,
        text=True,
        check=True,
    )
    return set(done.stdout.splitlines()[-1].split())


def _of_rapc(rooms: Sequence[str]) -> set[str]:
    return {f"rapc.{room}" for room in rooms}


@pytest.mark.parametrize("option", ["--help", "--version"])
def test_help_imports_nothing_heavy(option: str) -> None:
    found = _imported("from rapc.cli.main import main; main()", option)
    assert "rapc.cli.main" in found
    assert found.isdisjoint((*FOREIGN, "msgspec", *_of_rapc((*CHECKING, *RUNNING))))


def test_check_of_a_valid_file_imports_no_runtime_or_printer(
    tmp_path: Path,
) -> None:
    file = tmp_path / "wait.rap"
    file.write_text("(define-rap (wait))\n")
    found = _imported("from rapc.cli.main import main; main()", "check", str(file))
    assert "rapc.analysis.driver" in found
    assert found.isdisjoint((*FOREIGN, *_of_rapc((*RUNNING, "render"))))


def test_run_imports_no_rarely_used_modules(tmp_path: Path) -> None:
    file = tmp_path / "wait.rap"
    file.write_text('(require "truck") (define-rap (wait) (succeed (= 1 1)))\n')
    words = ("run", str(file), "--world", "truck", "--task", "(wait)", "--quiet")
    found = _imported("from rapc.cli.main import main; main()", *words)
    assert {"rapc.runtime.interpreter", "rapc.worlds.truck.world"} <= found
    assert found.isdisjoint((*FOREIGN, *FOR_FEW, *_of_rapc(SELDOM)))


def test_importing_rapc_imports_nothing_else_of_it() -> None:
    found = _imported("import rapc")
    assert {name for name in found if name.startswith("rapc.")} <= {
        "rapc.base",
        "rapc.base.version",
    }
    assert found.isdisjoint((*FOREIGN, "click", "msgspec"))


def test_the_package_is_run_as_a_module() -> None:
    ran = [sys.executable, "-m", "rapc", "--version"]
    done = subprocess.run(ran, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (0, rapc("--version").stdout)


def test_version_is_told() -> None:
    done = rapc("--version")
    assert done.returncode == 0
    assert done.stdout.startswith("rapc 0.")


@pytest.mark.parametrize(
    ("args", "said"),
    [
        (("chek",), "unknown command `chek`; did you mean `check`?"),
        (("frobnicate",), "unknown command `frobnicate`"),
        (
            ("check", "--selct", "x", "."),
            "unknown option `--selct`; did you mean `--select`?",
        ),
        (
            ("--colour", "always"),
            "unknown option `--colour`; did you mean `--color`?",
        ),
        (
            ("check", "--fail-level", "fatal", "."),
            "--fail-level: `fatal` is not one of `error`, `warning`, `info`",
        ),
        (("test", "--seeds", "0", "."), "--seeds: 0 is not in the range"),
        (("graph",), "missing PATH"),
        (("bug", "x.rap"), "missing -o / --output"),
        (("worlds", "truck", "lake"), "unexpected argument `lake`"),
    ],
)
def test_slips_get_one_line_and_one_suggestion(
    args: tuple[str, ...], said: str
) -> None:
    done = rapc(*args)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith(f"error: {said}")
    assert done.stderr.count("\n") == 1


def _fault(*_: object, **__: object) -> None:
    raise RuntimeError("two\nlines")


def test_internal_fault_is_one_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.setattr("rapc.cli.check.check_files", _fault)
    monkeypatch.delenv("RAPC_DEBUG", raising=False)
    with pytest.raises(SystemExit) as ended:
        main.main(["check", str(tmp_path)])
    said = capsys.readouterr()
    assert ended.value.code == 2
    assert said.out == ""
    assert said.err.count("\n") == 1
    assert "RuntimeError: two lines" in said.err
    assert "report" in said.err


def test_debug_shows_the_traceback(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.setattr("rapc.cli.check.check_files", _fault)
    monkeypatch.setenv("RAPC_DEBUG", "1")
    with pytest.raises(SystemExit) as ended:
        main.main(["check", str(tmp_path)])
    assert ended.value.code == 2
    assert "Traceback" in capsys.readouterr().err


def _interrupt(*_: object, **__: object) -> None:
    raise KeyboardInterrupt


def test_interrupt_ends_without_a_word(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.setattr("rapc.cli.check.check_files", _interrupt)
    with pytest.raises(SystemExit) as ended:
        main.main(["check", str(tmp_path)])
    assert ended.value.code == 130
    assert capsys.readouterr().err.strip() == ""


def test_closed_pipe_is_no_fault(tmp_path: Path) -> None:
    raps = [f"(define-rap (go-{n}) (succeed (x{n})))" for n in range(3000)]
    (tmp_path / "much.rap").write_text("\n".join(raps))
    with subprocess.Popen(
        [COMMAND, "check", str(tmp_path)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        assert process.stdout.readline().startswith("error[")
        process.stdout.close()
        assert process.stderr.read() == ""


def test_odd_file_names_can_be_printed(tmp_path: Path) -> None:
    (tmp_path / "a\udcff\x1b.rap").write_text("(define-rup (a))")
    for output_format in ("full", "concise", "json"):
        done = rapc("check", ".", "--output-format", output_format, cwd=tmp_path)
        assert (done.returncode, done.stderr) == (1, "")
        assert "\x1b" not in done.stdout


def test_without_a_command_the_help_is_shown() -> None:
    done = rapc()
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("Usage: rapc [OPTIONS] COMMAND [ARGS]...\n")
    assert re.search(r"\n  check +Check RAP libraries\.\n", done.stderr)


def _full(*_: object, **__: object) -> None:
    raise OSError(errno.ENOSPC, "No space left on device")


def test_full_disk_is_no_fault_of_rapc(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.setattr("rapc.cli.main._drop", lambda stream: None)
    monkeypatch.setattr("rapc.console.findings.write_lines", _full)
    (tmp_path / "odd.rap").write_text("(define-rup (a))")
    with pytest.raises(SystemExit) as ended:
        main.main(["check", str(tmp_path)])
    assert ended.value.code == 2
    said = "error: cannot write the output: no space left on device\n"
    assert capsys.readouterr().err == said


# --- Ctrl-C at every moment of a command ----------------------------------------------

SENT = "import os, signal; os.kill(os.getpid(), signal.SIGINT)"
"""Sends what Ctrl-C sends."""


def _begun(
    code: str, *args: str, cwd: Path | None = None
) -> subprocess.CompletedProcess[str]:
    """Run some code and then `rapc`, as the script does that is installed."""
    scripts = tomllib.loads((CHECKOUT / "pyproject.toml").read_text())["project"]
    module, _, function = scripts["scripts"]["rapc"].partition(":")
    begin = f"from {module} import {function} as main; main()"
    return subprocess.run(
        [sys.executable, "-c", f"{code}\n{begin}", *args],
        cwd=cwd,
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.parametrize("met", ["enum", "typing", "contextlib", "click"])
def test_interrupt_while_the_command_starts_ends_without_a_word(
    met: str, tmp_path: Path
) -> None:
    """A module that is met first on the way sends what Ctrl-C sends."""
    (tmp_path / f"{met}.py").write_text(f"{SENT}\n")
    done = _begun("", "--help", cwd=tmp_path)
    assert (done.returncode, done.stdout, done.stderr) == (-signal.SIGINT, "", "")


def test_interrupt_before_errors_are_looked_after_ends_without_a_word() -> None:
    code = (
        f"import rapc.cli.main as m\ndef sent(): {SENT}\nm._escape_unprintable = sent"
    )
    done = _begun(code, "--version")
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "")


def test_interrupt_in_a_callback_ends_without_a_word() -> None:
    """Python drops an exception there, for example at the end of each import."""
    code = f"""
import rapc.cli.main, threading, weakref
class Thing: pass
def call(reference): {SENT}
def wait():
    thing = Thing()
    reference = weakref.ref(thing, call)
    del thing
    threading.Event().wait(60)
rapc.cli.main._escape_unprintable = wait
"""
    done = _begun(code, "--version")
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "")


def test_interrupt_while_python_takes_itself_down_ends_without_a_word() -> None:
    code = f"import atexit\n@atexit.register\ndef sent(): {SENT}"
    done = _begun(code, "--version")
    assert (done.returncode, done.stderr) == (-signal.SIGINT, "")
    assert done.stdout.startswith("rapc 0.")


def test_shell_completion_of_the_manual_works_in_bash(tmp_path: Path) -> None:
    (tmp_path / "robot.rap").write_text("")
    (line,) = re.findall(r"^\| bash .*`(eval .*)` \|$", page("reference/cli"), re.M)
    script = f"""
        {line}
        COMP_WORDS=(rapc "$1" "$2") COMP_CWORD=$3 COMPREPLY=()
        compopt() {{ echo files; }}
        _rapc_completion rapc
        printf '%s\\n' "${{COMPREPLY[@]}}"
    """
    path = f"{Path(sys.executable).parent}:{os.environ['PATH']}"
    for one, two, at, expected in (
        ("ch", "", "1", "check\n"),
        ("check", "--sel", "2", "--select\n"),
        ("check", "rob", "2", "files\n\n"),
    ):
        done = subprocess.run(
            ["bash", "-c", script, "bash", one, two, at],
            cwd=tmp_path,
            env={**os.environ, "PATH": path},
            capture_output=True,
            text=True,
            check=False,
        )
        assert (done.stdout, done.stderr) == (expected, "")

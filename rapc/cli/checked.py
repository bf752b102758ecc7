"""A library for the commands that run one: read, checked and compiled."""

from __future__ import annotations

from rapc.api import CheckError, compile_loaded, read_artifact
from rapc.base.gc_paused import gc_paused
from rapc.cli.common import USAGE, fail, print_findings, read_paths, say
from rapc.compiler.program import Program
from rapc.errors import LoadError, SavedError


def load_checked(path: str) -> Program:
    """Load, check and compile a library for a command that runs it, or read a compiled.

    A finding of severity error is printed and ends the command with status 2; others
    do not stop it.
    """
    try:
        with gc_paused():
            artifact = read_artifact(path)
            if artifact is None:
                return compile_loaded(read_paths([path]), path)
            say(f"read {path}")
            return artifact.library
    except (SavedError, LoadError) as error:
        fail(str(error))
    except CheckError as error:
        print_findings(error.report, "full")
        raise SystemExit(USAGE) from None

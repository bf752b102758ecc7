"""From paths to a library in executable form, for programs that run RAPs.

Command-line users get findings printed (`rapc.cli.common`); programs get an exception
that carries them.
"""

from __future__ import annotations

from pathlib import Path

from rapc.analysis.driver import Finding, check
from rapc.compiler.plans import CompiledLibrary
from rapc.diagnostics import Severity


class CheckError(Exception):
    """A library with findings of severity error; `findings` are these."""

    def __init__(self, findings: tuple[Finding, ...]) -> None:
        first = findings[0].diagnostic
        more = f", and {len(findings) - 1} more" if len(findings) > 1 else ""
        super().__init__(f"{first.span.file}: {first.message}{more}")
        self.findings = findings


def compile_library(*paths: str | Path) -> CompiledLibrary:
    """Load, check and compile files and folders as one library.

    Raises:
        LoadError: for what cannot be read.
        CheckError: if anything of severity error is found.
    """
    report = check(*paths)
    errors = tuple(f for f in report.findings if f.severity is Severity.ERROR)
    if errors:
        raise CheckError(errors)
    return CompiledLibrary(report.library, str(paths[0]) if paths else "library")

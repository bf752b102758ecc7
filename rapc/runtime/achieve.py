"""RAPs for goals that no RAP has, added to a library [T 4.10.1]."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import count

from msgspec.structs import replace

from rapc.base.source import SourceFile
from rapc.compiler.program import Program
from rapc.errors import ArgumentError, PlanError
from rapc.ir import nodes
from rapc.ir.printer import format_node
from rapc.language.atoms import kind
from rapc.library.library import Library
from rapc.parser.parse import parse, parse_formula
from rapc.runtime.host_query import check_formula


def achieving(program: Program, goal: str, use: Sequence[str] = ()) -> nodes.DefineRap:
    """Return a RAP `achieve-N` that has a goal and is planned for.

    Args:
        program: the library.
        goal: the formula of `succeed`.
        use: the names of the RAPs that a plan may use; empty for all with `effects`.

    Raises:
        TextError: for a text that is no formula, or with undeclared names.
        PlanError: for a RAP in `use` that is no operator.
    """
    if not isinstance(goal, str):
        raise ArgumentError(f"`goal` is {kind(goal)}", "a formula as text")
    formula = parse_formula(goal)
    check_formula(formula, program.signatures)
    raps = program.library.raps
    for one in use:
        if one not in raps:
            raise PlanError(f"unknown RAP `{one}`")
        if not raps[one].effects:
            raise PlanError(f"a plan cannot use `{one}`: it has no `effects`")
    name = next(new for at in count(1) if (new := f"achieve-{at}") not in raps)
    names = "".join(f" {one}" for one in use)
    text = f"(define-rap ({name}) (succeed {format_node(formula)}) (plan{names}))"
    (rap,) = parse(SourceFile(f"<{name}>", text)).forms
    assert isinstance(rap, nodes.DefineRap)
    return rap


def with_rap(program: Program, rap: nodes.DefineRap) -> Program:
    """Return a library with one more RAP."""
    library: Library = program.library
    source = SourceFile(rap.span.file, format_node(rap))
    more = replace(
        library,
        raps={**library.raps, rap.name: rap},
        forms=(*library.forms, rap) if library.forms else (),
        files={**library.files, source.name: source},
    )
    return Program(more, program.name)

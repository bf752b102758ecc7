"""RAP016, RAP017 and RAP106: facts with the wrong number of arguments, or one left out.

[L 2.25]: a property pattern one argument short means the value `true`, in queries,
assertions and notations; erasing takes a prefix.
"""

from __future__ import annotations

from collections.abc import Iterator

from rapc.analysis.check import Pass, check
from rapc.analysis.facts.index import INDEX, NameUse
from rapc.analysis.facts.names import declared_at, wrong_arity
from rapc.analysis.facts.usage import CENSUS, TRUTH, Place
from rapc.base.diagnostics import (
    Applicability,
    Diagnostic,
    Edit,
    Fix,
    Label,
    Rule,
    Severity,
)
from rapc.base.source import Span
from rapc.library.signature import Signature
from rapc.library.signatures import Use

ARITY = Rule(
    code="RAP016",
    name="wrong-fact-arity",
    severity=Severity.ERROR,
    summary="a fact or test has another number of arguments than was declared",
    why="""A fact with too many or too few arguments matches nothing in memory; a
function called so fails. Erasing takes a prefix, which may be shorter but not longer
than the facts it is to erase.""",
    source="T A.1",
    example="""\
(declare-memory-proposition road (?from ?to))
(define-rap (drive ?from ?to)
  (preconditions (road ?from ?to paved)))
""",
    better="""\
(declare-memory-proposition road (?from ?to))
(define-rap (drive ?from ?to)
  (preconditions (road ?from ?to)))
""",
)

IMPLIED = Rule(
    code="RAP017",
    name="implied-true",
    severity=Severity.INFO,
    summary="a property is used without its value, which then means `true`",
    why="""`(class ?x box)` for `(class ?x box true)` is read as it was meant, but a
reader cannot see whether the value was left out on purpose, and a property whose value
is not true or false never holds so.""",
    fix="safe: writes the value `true`",
    ignore="where all of a library leaves out the value of its yes-or-no properties",
    source="T A.1",
    example="""\
(declare-memory-property open (?door ?is) unknown)
(define-rap (pass ?door)
  (preconditions (open ?door)))
""",
    better="""\
(declare-memory-property open (?door ?is) unknown)
(define-rap (pass ?door)
  (preconditions (open ?door true)))
""",
)


MISSING = Rule(
    code="RAP106",
    name="missing-value",
    severity=Severity.WARNING,
    summary="a property is used without its value, and its value is never `true`",
    why="""A property one argument short means the value `true` [L 2.25]. Where its kind
has no such value, or the library gives it others and never this one, the fact is never
found: the value was forgotten.""",
    ignore="where a world asserts `true` and the library does not say so",
    source="T A.1",
    example="""\
(declare-memory-property door (?door ?state) unknown)
(declare-primitive push (?door) (okay) :on (okay (door ?door open)))
(declare-primitive drive (?door) (okay))
(define-rap (pass ?door)
  (method (context (door ?door)) (primitive (drive ?door)))
  (method (context (door ?door shut)) (primitive (push ?door))))
""",
    better="""\
(declare-memory-property door (?door ?state) unknown)
(declare-primitive push (?door) (okay) :on (okay (door ?door open)))
(declare-primitive drive (?door) (okay))
(define-rap (pass ?door)
  (method (context (door ?door open)) (primitive (drive ?door)))
  (method (context (door ?door shut)) (primitive (push ?door))))
""",
)

_FACTS: tuple[Use, ...] = ("test", "believed", "asserted", "erased")


@check(ARITY, IMPLIED, MISSING)
def wrong_fact_arity(run: Pass) -> Iterator[Diagnostic]:
    """Find facts and tests with too many or too few arguments."""
    yield from wrong_arity(run, ARITY, _FACTS)
    properties = {
        name: signature
        for name, signature in run.signatures.relations.items()
        if signature.is_property and signature.most is not None
    }
    for used in run.result(INDEX).uses():
        declared = properties.get(used.name)
        if declared is None or used.count + 1 != declared.most or not used.count:
            continue
        if used.use in _FACTS and used.use != "erased":
            if _never_true(run, declared):
                yield _missing(run, used, declared)
            else:
                yield _implied(run, used, declared)


def _never_true(run: Pass, declared: Signature) -> bool:
    """Whether nothing in the library lets a property have the value `true`."""
    args = declared.args or ()
    kind = args[-1].kind if args else None
    if kind is not None and not run.signatures.kinds.holds(kind, "true"):
        return True
    place = Place("predicate", declared.name, (declared.most or 1) - 1)
    there = run.result(CENSUS).at(place)
    values = {one.written for one in there if one.count == declared.most}
    values.discard("unknown")
    return bool(values) and values.isdisjoint(TRUTH)


def _missing(run: Pass, used: NameUse, declared: Signature) -> Diagnostic:
    label = Label(declared_at(run, declared), f"declared here as `{declared.written}`")
    return MISSING.at(
        used.span,
        f"the value of `{used.name}` is left out, and `true` is none of its values",
        labels=(label,),
        help="write the value that was meant, or a variable for any",
    )


def _implied(run: Pass, used: NameUse, declared: Signature) -> Diagnostic:
    end = used.node.args[-1].span.end
    edit = Edit(Span(used.span.file, end, end), " true")
    label = Label(declared_at(run, declared), f"declared here as `{declared.written}`")
    return IMPLIED.at(
        used.span,
        f"the value of `{used.name}` is left out and means `true`",
        labels=(label,),
        fix=Fix(Applicability.SAFE, "write the value", (edit,)),
    )

"""What of a saved run stands in the way of other declarations, each in a line.

Declarations are built into a run's memory. Where nothing is kept of what they declare
they may change while the run goes on; else what is kept must be as the new ones say.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from rapc.base.names import plural
from rapc.base.values import Fact, format_list
from rapc.compiler.program import Program
from rapc.library.signature import Signature
from rapc.runtime.saving.format import RunRecord


def obstacles(record: RunRecord, before: Program, after: Program) -> Iterator[str]:
    """Yield why a run cannot go on with other declarations, a line for each reason.

    Args:
        record: the run.
        before: the library that it runs.
        after: the library with the other declarations.
    """
    for name, facts in record.memory.facts:
        old = before.signatures.relations[str(name)]
        new = after.signatures.relations.get(str(name))
        yield from _of_facts(old, new, [fact for fact, _ in facts], after)
    state = record.state
    asked = [("is under way", fact) for _, (_, fact) in state.pending]
    yield from _declared_otherwise(
        asked, before.library.primitives, after.library.primitives
    )
    tables = state.activations
    activations = [one for _, one in (*tables.on, *tables.off)]
    on = [("is on", skill) for one in activations for skill in one.skills]
    yield from _declared_otherwise(on, before.library.skills, after.library.skills)
    known = {item.kind for item in (*record.memory.items, *record.memory.empty)}
    old_classes, new_classes = before.library.indistinct, after.library.indistinct
    for kind in sorted(known):
        if old_classes.get(kind) != new_classes.get(kind):
            yield f"items of class `{kind}` are known: what tells them apart must stay"


def _of_facts(
    old: Signature, new: Signature | None, facts: list[Fact], after: Program
) -> Iterator[str]:
    """Yield why facts that memory holds cannot stay."""
    held = f"memory holds {plural(len(facts), 'fact')} of `{old.name}`"
    away = f"`:erase ({old.name})` takes them away"
    if new is None:
        yield f"{held}, which is declared no more; {away}"
    elif (new.kind, new.most) != (old.kind, old.most):
        yield f"{held}, which is another {new.kind} now, `{new.written}`; {away}"
    else:
        for fact in facts:
            wrong = after.signatures.wrong_kind("asserted", old.name, fact[1:])
            if wrong is not None:
                yield f"memory holds {format_list(fact)}: {wrong}"
                return


def _declared_otherwise(
    uses: list[tuple[str, Fact]],
    before: Mapping[str, object],
    after: Mapping[str, object],
) -> Iterator[str]:
    """Yield what is under way by names that are declared otherwise."""
    for how, fact in uses:
        name = str(fact[0])
        if before.get(name) != after.get(name):
            yield f"{format_list(fact)} {how}: how `{name}` is declared must stay"

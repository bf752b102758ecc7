"""Activations ready to be switched on: skills, their events, and what is awaited.

A primitive of skills is an activation that may await events; the `skills` of a method
with a task-net are one that awaits nothing and lasts as long as the method [S 3].
"""

from __future__ import annotations

from rapc.compiler.compiler import Compiler, RequestPlan
from rapc.compiler.net_plan import WaitPlan
from rapc.ir import nodes


class UsesPlan:
    """What a skill uses, over the arguments of its declaration."""

    __slots__ = ("args", "things")

    def __init__(self, compiler: Compiler, name: str) -> None:
        declared = compiler.library.skills.get(name)
        #: The names of the declared arguments.
        self.args: tuple[str, ...] = ()
        #: The things, to be filled in with values for these.
        self.things: tuple[RequestPlan, ...] = ()
        if declared is not None:
            self.args = tuple([arg.variable.name for arg in declared.args])
            things = [compiler.assertion(one, "use") for one in declared.uses]
            self.things = tuple(things)


class ActivationPlan:
    """A set of skills that are to be on together."""

    __slots__ = ("background", "events", "skills", "uses", "waits")

    def __init__(
        self,
        compiler: Compiler,
        enabled: tuple[nodes.Skill, ...],
        waits: tuple[nodes.WaitFor, ...],
        background: bool,
    ) -> None:
        #: The skills to be filled in, in the order of the text.
        self.skills = tuple([compiler.assertion(one, "skill") for one in enabled])
        #: What each of them uses by its declaration, once that is filled in.
        self.uses = tuple([UsesPlan(compiler, one.name) for one in enabled])
        #: What ends the method: the first of these that matches a signal.
        self.waits = tuple(
            [WaitPlan(wait, compiler.place("wait-for", wait.span)) for wait in waits]
        )
        #: Whether it goes on beside the steps of its method: the `skills` of one.
        self.background = background
        #: The names of the events to be told: all that its skills may tell, for rules
        #: hear what nobody awaits, then what is awaited besides.
        self.events = _events(compiler, self.skills, self.waits)


def _events(
    compiler: Compiler, skills: tuple[RequestPlan, ...], waits: tuple[WaitPlan, ...]
) -> tuple[str, ...]:
    found: dict[str, None] = {}
    for skill in skills:
        declared = compiler.library.skills.get(skill.name)
        if declared is not None:
            found.update(dict.fromkeys(declared.events or ()))
    found.update(dict.fromkeys(wait.signal for wait in waits))
    return tuple(found)


def activation_of(compiler: Compiler, method: nodes.Method) -> ActivationPlan | None:
    """Return what a method switches on, or None if it switches nothing on."""
    body = method.body
    if isinstance(body, nodes.Skills):
        return ActivationPlan(compiler, body.enable, body.waits, background=False)
    if method.skills:
        return ActivationPlan(compiler, method.skills, (), background=True)
    return None

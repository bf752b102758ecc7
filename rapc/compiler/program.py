"""A checked library in executable form."""

from __future__ import annotations

from functools import cached_property

from msgspec.structs import replace

from rapc.compiler.compiler import Compiler
from rapc.compiler.rap_plan import MethodPlan, RapPlan
from rapc.compiler.rules import event_rules
from rapc.ir import nodes
from rapc.library.library import Library, digest
from rapc.library.saved_check import Verifier


class Program:
    """A checked library in executable form, for the interpreter.

    Args:
        library: linked, and without findings of severity error.
        name: the name of the library in traces.
    """

    def __init__(self, library: Library, name: str = "library") -> None:
        self.library = library
        self.name = name
        #: Also compiles methods of problem solvers during a run.
        self.compiler = Compiler(library)
        #: The declarations of the library.
        self.signatures = self.compiler.signatures
        #: The rules that belong to no RAP.
        self.event_rules = event_rules(self.compiler)
        #: Whether any RAP has a rule for signals.
        self.hears_events = any(rule.when == "event" for rule in library.memory_rules)
        self._plans: dict[str, RapPlan] = {}

    @cached_property
    def digest(self) -> str:
        """Return the digest of the texts of the library."""
        return digest(self.library)

    def rap(self, name: str) -> RapPlan | None:
        """Return the plan of a RAP, compiled at the first request."""
        plan = self._plans.get(name)
        if plan is None:
            node = self.library.raps.get(name)
            if node is None:
                return None
            plan = self._plans[name] = RapPlan(self.compiler, node)
        return plan

    def known_rap(self, name: str) -> RapPlan:
        """Return the plan of a RAP that a checked library must have.

        Raises:
            LookupError: if the RAP is missing.
        """
        plan = self.rap(name)
        if plan is None:
            raise LookupError(f"unknown RAP `{name}`")
        return plan

    def added_method(self, rap: RapPlan, node: nodes.Method, index: int) -> MethodPlan:
        """Return the plan of a method that is not in the text of the library.

        Raises:
            UnsoundError: for a method with names that the library does not declare.
        """
        Verifier(self.signatures).rap(replace(rap.node, methods=(node,)))
        return MethodPlan(self.compiler, rap.node, node, index)

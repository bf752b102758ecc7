"""A checked library in executable form."""

from __future__ import annotations

from msgspec.structs import replace

from rapc.compiler.compiler import Compiler
from rapc.compiler.rap_plan import MethodPlan, RapPlan
from rapc.compiler.rules import event_rules
from rapc.ir import nodes
from rapc.library.library import Library
from rapc.library.saved_check import Verifier


class Program:
    """A checked library in executable form: what the interpreter is given.

    Args:
        library: linked, and free of findings of severity error.
        name: what traces call it.
    """

    def __init__(self, library: Library, name: str = "library") -> None:
        self.library = library
        self.name = name
        #: For compiling what comes later, too: methods of problem solvers.
        self.compiler = Compiler(library)
        #: What the declarations say.
        self.signatures = self.compiler.signatures
        #: The rules of no RAP.
        self.event_rules = event_rules(self.compiler)
        #: Whether any RAP has a rule for signals.
        self.hears_events = any(rule.when == "event" for rule in library.memory_rules)
        self._plans: dict[str, RapPlan] = {}

    def rap(self, name: str) -> RapPlan | None:
        """The plan of a RAP, compiled the first time it is asked for."""
        plan = self._plans.get(name)
        if plan is None:
            node = self.library.raps.get(name)
            if node is None:
                return None
            plan = self._plans[name] = RapPlan(self.compiler, node)
        return plan

    def known_rap(self, name: str) -> RapPlan:
        """The plan of a RAP that a checked library cannot lack.

        Raises:
            LookupError: if it does.
        """
        plan = self.rap(name)
        if plan is None:
            raise LookupError(f"no RAP is called `{name}`")
        return plan

    def added_method(self, rap: RapPlan, node: nodes.Method, index: int) -> MethodPlan:
        """Return the plan of a method that no text of the library has.

        Raises:
            UnsoundError: for a method with names that the library does not declare so.
        """
        Verifier(self.signatures).rap(replace(rap.node, methods=(node,)))
        return MethodPlan(self.compiler, rap.node, node, index)

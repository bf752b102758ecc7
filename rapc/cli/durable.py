"""The options of `rapc run` for journals: a run that goes on after a crash."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import click

from rapc.base.offers import AFTER_CRASH
from rapc.base.outputs import TRACE
from rapc.base.values import Fact, format_list
from rapc.base.visible import visible
from rapc.cli.common import load_checked, refuse_output
from rapc.cli.options import Opt, TypedPath, WholeNumber, fail, say_error
from rapc.cli.run_options import prepared
from rapc.runtime.interpreter import Interpreter

if TYPE_CHECKING:
    from rapc.durable.folder import Options
    from rapc.durable.journal import Report
    from rapc.durable.runs import DurableRun
    from rapc.runtime.events.recorder import Listener
    from rapc.view.control import Control
    from rapc.world import Time, World

UNDECIDED = 3
"""The exit status for requests under way that the user must decide on."""

_MOST_MEGABYTES = 1_000_000


class JournalOptions:
    """The options of a journal."""

    journal: Annotated[
        str | None,
        Opt(
            type=TypedPath(file_okay=False),
            metavar="FOLDER",
            help="Write a journal, with which the run can be resumed.",
        ),
    ] = None
    resume: Annotated[
        str | None,
        Opt(
            type=TypedPath(file_okay=False),
            metavar="FOLDER",
            help="Resume the run of a journal; without PATH and --world.",
        ),
    ] = None
    take_up: Annotated[
        bool, Opt(help="With --resume: go on with a library that has changed.")
    ] = False
    sync: Annotated[
        str | None,
        Opt(
            type=click.Choice(["always", "requests", "off"]),
            help="When the journal waits for the disk [default: requests].",
        ),
    ] = None
    journal_limit: Annotated[
        int | None,
        Opt(
            type=WholeNumber(_MOST_MEGABYTES),
            metavar="MEGABYTES",
            help="Size above which old parts are removed [default: 256].",
        ),
    ] = None
    after_crash: Annotated[
        tuple[str, ...],
        Opt(
            metavar="PRIMITIVE=repeat|fail|ask",
            help="What to do with a request under way (repeatable).",
        ),
    ] = ()


def treatments(given: Sequence[str]) -> dict[str, str]:
    """Return the values of `--after-crash` by primitive; an error ends the command."""
    found = {}
    for text in given:
        name, _, treatment = text.rpartition("=")
        if not name or treatment not in AFTER_CRASH:
            fail(
                f"--after-crash: expected PRIMITIVE=repeat, fail or ask, not `{text}`",
                "`*` names every primitive",
            )
        found[name] = treatment
    return found


def options_from(given: Mapping[str, Any], first: Options | None = None) -> Options:
    """Return the options of a journal; those of the command line replace `first`."""
    from rapc.durable.folder import Options

    first = first or Options()
    return Options(
        given["sync"] or first.sync,
        given["journal_limit"] or first.limit,
        {**first.after_crash, **treatments(given["after_crash"])},
    )


class Course:
    """The course of a run from its beginning to its end.

    Args:
        run: the run; it has not begun.
        until: its time limit.
    """

    def __init__(self, run: Interpreter, until: Time | None) -> None:
        self.first, self.until = run, until
        #: The reports on the run, whose state is part of a snapshot.
        self.reports: Sequence[Report] = ()
        #: The control of the run by the readers of its page.
        self.control: Control | None = None

    @property
    def run(self) -> Interpreter:
        """Return the run."""
        return self.first

    def begin(self) -> None:
        """Begin the run."""
        self.run.start(None if self.control is None else self.until)

    def go(self) -> None:
        """Run to the end."""
        if self.control is None:
            self.run.run(until=self.until)
        else:
            self.control.go(self.run)

    def cancel(self) -> None:
        """End the run early."""
        self.run.end("cancelled")

    def close(self) -> None:
        """Close the files of the run."""


class Begun(Course):
    """A run with a new journal.

    Args:
        run: the run; it has not begun.
        given: the options of `JournalOptions`.
        until: the time limit of the run.
        trace: the file of its trace.
    """

    def __init__(
        self,
        run: Interpreter,
        given: Mapping[str, Any],
        until: Time | None,
        trace: str | None,
    ) -> None:
        super().__init__(run, until)
        self._given, self._trace = given, trace
        self._durable: DurableRun | None = None

    @property
    def run(self) -> Interpreter:
        """Return the run."""
        return self.first if self._durable is None else self._durable.run

    def begin(self) -> None:
        """Begin the run and its journal."""
        from rapc.durable.runs import begin

        self._durable = begin(
            Path(self._given["journal"]),
            self.first,
            options_from(self._given),
            until=self.until,
            trace=None if self._trace is None else Path(self._trace),
            reports=self.reports,
        )

    def go(self) -> None:
        """Run to the end."""
        assert self._durable is not None
        if self.control is None:
            self._durable.go()
        else:
            self.control.go(self.run, self._durable)

    def cancel(self) -> None:
        """End the run early; its journal does not have this end."""
        self.run.keep_answers().store = None
        super().cancel()

    def close(self) -> None:
        """Close the files of the run."""
        if self._durable is not None:
            self._durable.close()


class Resumed(Begun):
    """A run of a journal.

    Args:
        given: the options of `JournalOptions`.
    """

    def __init__(self, given: Mapping[str, Any]) -> None:
        from rapc.durable.folder import read_meta
        from rapc.durable.runs import Resumption, enclosed, planner_for

        folder = Path(given["resume"])
        self._meta = read_meta(folder)
        spec = self._meta.spec
        loaded = load_checked(spec.library)
        self._resumption = Resumption(folder, loaded, take_up=given["take_up"])
        world = spec.world_class or spec.world
        made = prepared(
            self._resumption.program,
            spec,
            world,
            enclosed(self._meta),
            planner=planner_for(self._meta),
        )
        super().__init__(made, given, spec.until, self._meta.trace or None)
        #: Receives the events in place of those before the snapshot of the journal.
        self.hear_past: Listener | None = None

    @property
    def unknown(self) -> int:
        """The cycle up to which the events of the run are not repeated."""
        snapshot = self._resumption.stored.snapshot
        return 0 if snapshot is None else snapshot.cycle

    def begin(self) -> None:
        """Leave the beginning to `go`, which may take some time."""

    def go(self) -> None:
        """Bring the run to the end of its journal, then run to the end."""
        self._durable = self._resumption.resume(
            self.first,
            options_from(self._given, self._meta.options),
            _decide,
            trace=None if self._trace is None else Path(self._trace),
            reports=self.reports,
            hear_past=self.hear_past,
        )
        super().go()


def refuse_trace(trace: str, files: Iterable[str], world: World) -> None:
    """End the command if the file of a trace is one that the run has read.

    Args:
        trace: the file to write.
        files: the files of the library.
        world: the world of the run, which may be a module of the user.
    """
    module = getattr(sys.modules.get(type(world).__module__), "__file__", None)
    inputs = (
        (files, "is a source file of the library"),
        ([module], "is the source file of the world"),
    )
    refuse_output("--trace", trace, TRACE, *inputs)


def _decide(request: Fact) -> str:
    """Ask the user on a terminal what to do with a request; else end the command."""
    shown = visible(format_list(request))
    if not (sys.stdin.isatty() and sys.stderr.isatty()):
        say_error(
            f"cannot resume: {shown} was under way, and its outcome is unknown",
            f"use --after-crash {request[0]}=repeat or --after-crash {request[0]}=fail",
        )
        raise SystemExit(UNDECIDED)
    asked = f"{shown} was under way, and its outcome is unknown"
    choices = click.Choice(["repeat", "fail"])
    return str(click.prompt(asked, type=choices, err=True))

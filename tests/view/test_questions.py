"""Ten questions about runs of four worlds, each answered on the page in three actions.

The runs are the five faults of the first trial of the debugger (see
docs/research/debugging.md), a fault in the laboratory, and a run of the truck. An
action is a click, a key, or a text typed into the search with the key that goes to the
first thing found.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

import pytest
from click.testing import CliRunner
from playwright.sync_api import Browser

from bench.browser import browser, chromium
from rapc.cli.main import cli
from tests.debug.planted import FAULTS, LIBRARIES, WORLDS

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(chromium() is None, reason="Chromium is not installed"),
    pytest.mark.xdist_group("browser"),
]


class Question(NamedTuple):
    """A question about a run, the actions, and what the page then shows."""

    question: str
    #: The name of a fault, or `truck`.
    run: str
    #: Each a key, a text to search `/TEXT`, or the selector of a button.
    actions: tuple[str, ...]
    #: Texts by the panel that shows them.
    answer: Mapping[str, tuple[str, ...]]


QUESTIONS = (
    Question(
        "Why did the run end with an empty battery?",
        "charges-too-late",
        (),
        {
            "#verdict": ("the battery is empty, 8 along the corridor",),
            "#symptoms": ("charging.rap:8: [2] (stay-charged), woken by (low) at 108",),
            "#why": ("woken at 108 by (low)", "?level 14"),
        },
    ),
    Question(
        "Why do three orders never end?",
        "drives-off-while-loading",
        ("#symptoms button:has-text('orders.rap:37')",),
        {
            "#symptoms": ("`from-a-store` of `fetch` does not claim wheels",),
            "#source .place": ("method from-a-store",),
        },
    ),
    Question(
        "Which decision differs first from the run of the sound library?",
        "never-fully-charged",
        (),
        {
            "#comparison": (
                "before: (stay-until-charged) [20] was selected at 116",
                "blocked until (or (charged) (not (robot-at base))) since 76",
            ),
            "#where": ("time 116 ",),
        },
    ),
    Question(
        "For what did the robot wait at 125 in the slow run?",
        "never-fully-charged",
        ("#runs button:has-text('after')", "/125"),
        {
            "#why": ("waits for (or (charged) (not (robot-at base)))",),
            "#memory": ("(battery 100)",),
        },
    ),
    Question(
        "Who had the wheels at 100?",
        "never-fully-charged",
        ("/100",),
        {
            "#claims": (
                "wheels [2] (stay-charged)",
                "wheels, taken by [2] [15] (bring medicine ward-3)",
            )
        },
    ),
    Question(
        "When did belief part from truth, and by which rule?",
        "heading-not-turned",
        ("Home", "b"),
        {
            "#where": ("time 20.2 ",),
            "#beliefs": (
                "(current-space robot west-hall)",
                "by rule for (:at-landmark 3.17 13.98 -3.088) moving.rap:25",
                "truth: (current-space robot north-hall)",
                "until 97.1",
            ),
            "#symptoms": ("travel.rap:95",),
        },
    ),
    Question(
        "Why did an order fail, and since when was the fact behind it there?",
        "sold-out-for-ever",
        (),
        {
            "#why": (
                "(deliver meals ward-4) [8]",
                "methods that were excluded: 1",
                "context of method `from-a-store` orders.rap:39",
                "(sold-out kitchen meals), 800 old asserted at 631",
            )
        },
    ),
    Question(
        "What woke the task that failed?",
        "acknowledged-too-early",
        (),
        {"#why": ("(answer-stop) [2]", "woken at 327 by (stop pressed)")},
    ),
    Question(
        "Which request used an arm at 205, and who waited for the instrument?",
        "acknowledged-too-early",
        ("/205",),
        {
            "#claims": (
                "(arm right), used [245] (have-arm-at right instrument)",
                "instrument, taken, held by [234] (have-measured s6) [232]",
            )
        },
    ),
    Question(
        "Which method was chosen last for the reserve of fuel?",
        "truck",
        ("/stow-fuel", "#why button:has-text('succeeded at')"),
        {"#why": ("Methods tried: 2", "2.5 stow: okay")},
    ),
)


def _arguments(name: str, folder: Path) -> tuple[str, ...]:
    """Return the arguments of `rapc view` for a run."""
    if name == "truck":
        truck = (str(LIBRARIES["truck"]), "--world", "truck", "--agenda", "nine-orders")
        return (*truck, "--seed", "6000", "--until", "60")
    fault = next(one for one in FAULTS if one.name == name)
    fault.plant(folder / name)
    world = WORLDS.get(fault.library, fault.library)
    until = "100" if fault.library == "hallway" else "2000"
    spec = ("--world", world, "--agenda", fault.agenda, "--seed", str(fault.seed))
    if name == "never-fully-charged":
        sound = str(LIBRARIES[fault.library])
        return (sound, *spec, "--compare", str(folder / name))
    return (str(folder / name), *spec, "--until", until)


@pytest.fixture(scope="module")
def pages(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("questions")
    found = {}
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(LIBRARIES["laboratory"])
        for name in {one.run for one in QUESTIONS}:
            found[name] = folder / f"{name}.html"
            arguments = ("view", *_arguments(name, folder), "-o", str(found[name]))
            done = CliRunner().invoke(cli, arguments)
            assert done.exit_code == 0, done.output
    return found


@pytest.fixture(scope="module")
def opened() -> Iterator[Browser]:
    with browser() as found:
        yield found


def test_ten_questions_are_about_four_worlds() -> None:
    worlds = {one.name: one.library for one in FAULTS} | {"truck": "truck"}
    assert len(QUESTIONS) == 10
    assert len({worlds[one.run] for one in QUESTIONS}) == 4
    assert {one.name for one in FAULTS[-5:]} <= {one.run for one in QUESTIONS}


@pytest.mark.parametrize("asked", QUESTIONS, ids=lambda one: one.question)
def test_page_answers_within_three_actions(
    asked: Question, opened: Browser, pages: dict[str, Path]
) -> None:
    assert len(asked.actions) <= 3
    page = opened.new_page(viewport={"width": 1500, "height": 950})
    page.goto(pages[asked.run].as_uri())
    page.wait_for_selector("html[data-ready]", state="attached")
    for action in asked.actions:
        if action.startswith("/"):
            page.fill("#search", action[1:])
            page.press("#search", "Enter")
        elif action.startswith("#"):
            page.click(action)
        else:
            page.keyboard.press(action)
    for panel, texts in asked.answer.items():
        shown = " ".join(page.inner_text(panel).split())
        for text in texts:
            assert text in shown, f"{panel}: {shown}"
    assert "[object" not in page.inner_text("#main")
    page.close()

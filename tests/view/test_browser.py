"""The page in a browser: what it opens at, keys, links, dropped and hostile traces."""

from __future__ import annotations

import json
import random
import shutil
import string
from collections.abc import Iterator
from io import StringIO
from pathlib import Path
from threading import Thread
from typing import Any

import pytest
from playwright.sync_api import Browser, Page

from bench.browser import browser, chromium
from rapc import load
from rapc.runtime.events.trace import JsonTrace
from rapc.view.control import Control
from rapc.view.live import Live
from rapc.view.page import live_page
from rapc.view.page import page as page_text
from tests.cli.command import rapc

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(chromium() is None, reason="Chromium is not installed"),
    pytest.mark.xdist_group("browser"),
]

TRUCK = ("stdlib/truck", "--world", "truck", "--agenda", "nine-orders")
FAILING = ("--set", "truck.shuffle-interval=15", "--seed", "6000")
COURIER = ("examples/courier", "--world", "courier", "--agenda", "shift")


@pytest.fixture(scope="module")
def opened() -> Iterator[Browser]:
    with browser() as found:
        yield found


@pytest.fixture(scope="module")
def pages(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Return the pages of some runs, by name; and a page without a run."""
    folder = tmp_path_factory.mktemp("pages")
    files = {
        name: folder / f"{name}.html" for name in ("truck", "courier", "both", "none")
    }
    trace = folder / "courier.jsonl"
    run = ("run", *COURIER, "--seed", "1", "-q", "--trace", str(trace))
    assert rapc(*run).returncode == 0
    slow = folder / "slow"
    slow.mkdir()
    for file in Path(COURIER[0]).glob("*.rap"):
        text = file.read_text().replace("(>= ?level 90)", "(> ?level 100)")
        (slow / file.name).write_text(text)
    for name, args in (
        ("truck", (*TRUCK, *FAILING)),
        ("courier", (str(trace),)),
        ("both", (str(trace), "--compare", str(slow))),
    ):
        done = rapc("view", *args, "-o", str(files[name]))
        assert done.returncode == 0, done.stderr
    files["none"].write_text(page_text(), encoding="utf-8")
    return {**files, "trace": trace}


class Shown:
    """A page in a window, with all that it requests, reports and opens."""

    def __init__(self, opened: Browser, file: Path, *, link: str = "", **more: Any):
        self.page: Page = opened.new_page(**more)
        self.faults: list[str] = []
        self.page.on("pageerror", lambda one: self.faults.append(str(one)))
        self.page.on("dialog", lambda one: self.faults.append(one.message))
        self.page.on("console", lambda one: self.faults.append(one.text))
        address = file.resolve().as_uri()
        self.page.on("request", lambda one: self._request(one.url, address))
        self.page.goto(address + link)
        self.wait("html[data-ready]")

    def _request(self, url: str, own: str) -> None:
        if url.partition("#")[0] != own:
            self.faults.append(f"request of {url}")

    def wait(self, selector: str) -> None:
        self.page.wait_for_selector(selector, state="attached")

    def text(self, selector: str) -> str:
        return self.page.inner_text(selector)

    @property
    def moment(self) -> int:
        return int(self.page.get_attribute("html", "data-moment") or "-1")

    def press(self, *keys: str) -> None:
        for key in keys:
            self.page.keyboard.press(key)

    def close(self) -> None:
        self.page.close()
        assert self.faults == []


def test_page_opens_at_the_first_failed_task_with_its_cause(
    opened: Browser, pages: dict[str, Path]
) -> None:
    shown = Shown(opened, pages["truck"], viewport={"width": 1500, "height": 950})
    verdict = shown.text("#verdict")
    assert verdict.startswith("done at time 6519.26 · 9 succeeded · 1 failed: ")
    assert "(fill-order yellow 4 factory-3)" in verdict
    selected = shown.text('#tasks [aria-selected="true"]')
    assert "(fill-order yellow 4 factory-3) [143]" in selected
    assert "failed, futile-loop, eye-cant-find" in shown.text("#why")
    assert "first cause" in shown.text("#why .first").lower()
    assert "(define-rap (fill-order" in shown.text("#source")
    assert shown.page.locator("#source .place").count() == 1
    assert "task-failed" in shown.text("#events .now")
    shown.close()


def test_keys_move_in_the_run(opened: Browser, pages: dict[str, Path]) -> None:
    shown = Shown(opened, pages["truck"], viewport={"width": 1500, "height": 950})
    start = shown.moment
    shown.press("ArrowLeft")
    assert shown.moment < start
    shown.press("ArrowRight")
    end = shown.moment
    assert end >= start
    shown.press("Shift+ArrowRight")
    assert shown.moment == end + 1
    shown.press("Home")
    assert shown.moment == 0
    shown.press("n")
    first = shown.moment
    assert "task-failed" in shown.text("#events .now")
    shown.press("n", "N")
    assert shown.moment == first
    shown.press("b")
    assert "wrong since" in shown.text("#beliefs")
    shown.press("/")
    shown.page.keyboard.type("arm-grasp-p")
    assert shown.page.locator("#found li").count() > 10
    shown.press("ArrowDown", "Enter")
    assert "arm-grasp-p" in shown.text('#tasks [aria-selected="true"]')
    shown.press("?")
    assert shown.page.locator("#help[open]").count() == 1
    shown.press("Escape")
    shown.close()


def test_every_control_is_reached_and_used_with_the_keyboard(
    opened: Browser, pages: dict[str, Path]
) -> None:
    shown = Shown(opened, pages["courier"], viewport={"width": 1500, "height": 950})
    shown.press("Home", "ArrowRight", "ArrowRight")
    reached = set()
    for _ in range(60):
        shown.press("Tab")
        reached.add(
            shown.page.evaluate(
                """() => {
                  const one = document.activeElement;
                  const panel = one.closest('[id]');
                  return panel ? panel.id : one.tagName;
                }"""
            )
        )
    expected = {"search", "theme", "help-button", "timeline", "tasks", "filter", "own"}
    assert expected <= reached
    shown.page.focus("#tasks [data-key]")
    shown.press("ArrowDown", "ArrowDown", "Enter")
    assert "(deliver medicine ward-3)" in shown.text('#tasks [aria-selected="true"]')
    unnamed = shown.page.evaluate(
        """() => [...document.querySelectorAll('button, input, [tabindex]')]
          .filter((one) => !(one.textContent.trim() || one.ariaLabel
            || one.getAttribute('aria-labelledby') || one.labels?.length))
          .map((one) => one.outerHTML)"""
    )
    assert unnamed == []
    misplaced = shown.page.evaluate(
        """() => [
          ...document.querySelectorAll('[role=option]:not([role=listbox] *)'),
          ...document.querySelectorAll('[role=treeitem]:not([role=tree] *)'),
          ...document.querySelectorAll('[role=button][aria-selected]'),
          ...document.querySelectorAll('th:empty'),
        ].map((one) => one.outerHTML)"""
    )
    assert misplaced == []
    shown.close()


def test_next_change_of_the_selected_fact(
    opened: Browser, pages: dict[str, Path]
) -> None:
    shown = Shown(opened, pages["courier"], viewport={"width": 1500, "height": 950})
    shown.press("Home")
    shown.press("/")
    shown.page.keyboard.type("(robot-at base)")
    shown.page.wait_for_selector("#found li")
    shown.page.click("#found li:has-text('fact')")
    assert "(robot-at base): " in shown.text("#memory h3 >> nth=0")
    before = shown.moment
    shown.press("c")
    assert shown.moment > before
    assert "(robot-at base)" in shown.text("#events .now")
    shown.close()


def test_link_leads_to_moment_and_task(opened: Browser, pages: dict[str, Path]) -> None:
    link = "#n=127&task=16"
    shown = Shown(opened, pages["courier"], link=link)
    assert shown.moment == 127
    assert "[16]" in shown.text('#tasks [aria-selected="true"]')
    assert "suspended by [2] for wheels" in shown.text("#why")
    shown.page.wait_for_timeout(300)
    assert shown.page.evaluate("location.hash") == link
    shown.page.evaluate("location.hash = 'n=20'")
    shown.wait('html[data-moment="20"]')
    shown.close()


def test_plan_is_shown_with_its_links(opened: Browser, tmp_path: Path) -> None:
    folder = tmp_path / "courier"
    shutil.copytree(COURIER[0], folder)
    goal = "(and (delivered medicine ward-3) (delivered meals ward-4) (docked))"
    (folder / "round.rap").write_text(f"(define-rap (round) (succeed {goal}) (plan))")
    file = tmp_path / "round.html"
    run = ("--world", "courier", "--task", "(round)", "-o", str(file))
    assert rapc("view", str(folder), *run).returncode == 0
    shown = Shown(opened, file, link="#n=150&task=1")
    rows = shown.page.locator("#why .plan li").all_inner_texts()
    assert len(rows) == 6
    assert "t1 (fetch medicine ward-3)" in rows[0]
    assert "for t3: (on-tray medicine ward-3)" in rows[0]
    assert rows[-1].endswith("for the goal: (docked)")
    signs = shown.page.locator("#why .plan .sign").evaluate_all(
        "all => all.map((one) => one.title)"
    )
    assert signs[0] == "succeeded"
    assert signs[-1] == "has not been selected"
    shown.page.click("#why .plan button:has-text('(fetch medicine ward-3)')")
    assert "for step t1 of (round)" in shown.text("#why")
    assert "for t3: (on-tray medicine ward-3)" in shown.text("#why")
    shown.close()


@pytest.mark.parametrize(
    "link", ["#n=-5", "#n=1e99", "#n=x&task=y", "#run=7&n=2", "#%"]
)
def test_odd_links_show_some_moment(
    opened: Browser, pages: dict[str, Path], link: str
) -> None:
    shown = Shown(opened, pages["courier"], link=link)
    assert 0 <= shown.moment < 1234
    shown.close()


def test_two_runs_are_shown_at_the_same_time(
    opened: Browser, pages: dict[str, Path]
) -> None:
    shown = Shown(opened, pages["both"], viewport={"width": 1500, "height": 950})
    assert "first different decision, in cycle 24" in shown.text("#comparison")
    assert shown.page.locator(".lanes").count() == 2
    assert "time 116 " in shown.text("#where")
    shown.page.click("#runs button:has-text('after')")
    assert "time 76 " in shown.text("#where") or "time 116 " in shown.text("#where")
    assert shown.page.locator("#comparison table tr").count() > 3
    shown.close()


@pytest.mark.parametrize("width", [1500, 1024, 390])
@pytest.mark.parametrize("name", ["truck", "both", "none"])
def test_nothing_is_wider_than_the_window(
    opened: Browser, pages: dict[str, Path], width: int, name: str
) -> None:
    shown = Shown(opened, pages[name], viewport={"width": width, "height": 844})
    assert shown.page.evaluate("document.documentElement.scrollWidth") <= width
    shown.close()


def test_theme_is_switched(opened: Browser, pages: dict[str, Path]) -> None:
    shown = Shown(opened, pages["courier"], color_scheme="dark")
    ground = "getComputedStyle(document.body).backgroundColor"
    dark = shown.page.evaluate(ground)
    shown.page.click("#theme")
    light = shown.page.evaluate(ground)
    assert dark != light
    shown.page.click("#theme")
    assert shown.page.evaluate(ground) == dark
    shown.close()


def test_dropped_trace_is_shown(
    opened: Browser, pages: dict[str, Path], tmp_path: Path
) -> None:
    shown = Shown(opened, pages["none"])
    wrong = tmp_path / "wrong.jsonl"
    wrong.write_text("no trace\n")
    shown.page.set_input_files("#file", wrong)
    shown.page.wait_for_function("() => document.getElementById('wrong').textContent")
    assert "not a trace from the start of a run" in shown.text("#wrong")
    shown.page.set_input_files("#file", pages["trace"])
    shown.wait("html[data-events]")
    assert shown.text("#verdict").startswith("done at time 831 · 3 succeeded")
    shown.close()


# --- traces of strangers --------------------------------------------------------------

HOSTILE = (
    "<script>window.harm = 1</script>",
    "</script><script>window.harm = 1</script>",
    "<img src=x onerror='window.harm = 1'>",
    "<svg onload=window.harm=1>",
    "<iframe srcdoc='<script>parent.harm=1</script>'></iframe>",
    "<link rel=stylesheet href=http://127.0.0.1/x.css>",
    "<style>* { display: none }</style>",
    "javascript:window.harm=1",
    "\"><b onmouseover='window.harm=1'>",
    "${window.harm=1}",
    "{{constructor.constructor('window.harm=1')()}}",
    "__proto__",
    "constructor",
    "toString",
    "\u202e\u2066evil\u2069",
    "\x00\x01\x1b[31mred\x07\x7f",
    "\u2028\u2029\r\n",
    "\ud800 alone",
    "é́́" * 50,
    "x" * 2_000,
    "<b>" * 300,
    "&lt;b&gt;&amp;&#60;",
    "-->]]>*/",
    "(((((",
    ")))))",
)


def _inert(text: str) -> str:
    """Return a text with the same structure as RAP text, and nothing else special."""
    kept = string.ascii_letters + string.digits + '()"\\'
    return "".join(one if one in kept or one.isspace() else "x" for one in text)


def _filled(value: Any, put: Any, chance: random.Random, keys: bool) -> Any:
    """Return a value of an event with text put into its strings, at random."""
    if isinstance(value, str):
        return put(value) if chance.random() < 0.7 else value
    if isinstance(value, list):
        return [_filled(one, put, chance, keys) for one in value]
    if isinstance(value, dict):
        return {
            put(key) if keys and key.startswith("?") else key: _filled(
                one, put, chance, keys
            )
            for key, one in value.items()
        }
    return value


def hostile_trace(lines: list[dict[str, Any]], seed: int, *, inert: bool) -> str:
    """Return a trace with one hostile text in many places, or with an inert text."""
    chance = random.Random(seed)
    text = HOSTILE[seed % len(HOSTILE)]
    if inert:
        text = _inert(text)
    whole = chance.random() < 0.3
    made = []
    for at, line in enumerate(lines):
        own = ("event", "n", "cycle", "time")
        rest = {key: one for key, one in line.items() if key not in own}
        rest = _filled(rest, lambda one: text if whole else one + text, chance, True)
        event = line["event"]
        if at and chance.random() < 0.02:
            event += text
        made.append(
            json.dumps({"event": event, **{k: line[k] for k in own[1:]}, **rest})
        )
    return "\n".join(made) + "\n"


COUNTS = """() => {
  const counts = {};
  for (const one of document.querySelectorAll('body *'))
    counts[one.tagName] = (counts[one.tagName] || 0) + 1;
  return counts;
}"""


def _excerpt(args: tuple[str, ...], folder: Path) -> list[dict[str, Any]]:
    """Return some events of a run: the creations of tasks, and the last part."""
    file = folder / "run.jsonl"
    rapc("run", *args, "-q", "--trace", str(file))
    lines = [json.loads(line) for line in file.read_text().splitlines()]
    whole = [
        one
        for at, one in enumerate(lines)
        if not at or one["event"] == "task-created" or at > len(lines) - 350
    ]
    return [{**one, "n": at} for at, one in enumerate(whole)]


@pytest.mark.parametrize("count", [20, pytest.param(200, marks=pytest.mark.nightly)])
def test_hostile_traces_change_nothing_but_text(
    opened: Browser, pages: dict[str, Path], tmp_path: Path, count: int
) -> None:
    runs = (
        _excerpt((*TRUCK, *FAILING, "--until", "172"), tmp_path),
        _excerpt((*COURIER, "--seed", "1"), tmp_path),
    )
    kinds = {one["event"] for lines in runs for one in lines}
    assert {"task-failed", "method-suspended", "task-blocked", "fact-erased"} <= kinds
    file = tmp_path / "trace.jsonl"
    shown = Shown(opened, pages["none"])
    for seed in range(count):
        counts = []
        for inert in (False, True):
            text = hostile_trace(runs[seed % 2], seed, inert=inert)
            file.write_text(text)
            shown.page.evaluate("delete document.documentElement.dataset.events")
            shown.page.set_input_files("#file", file)
            shown.wait("html[data-events], #wrong:not(:empty)")
            assert shown.page.text_content("#wrong") == "", (seed, inert)
            shown.press("n", "ArrowLeft", "ArrowRight", "/")
            shown.page.fill("#search", "(")
            counts.append(shown.page.evaluate(COUNTS))
            shown.press("Escape")
        assert counts[0] == counts[1], HOSTILE[seed % len(HOSTILE)][:80]
    assert shown.page.evaluate("window.harm") is None
    shown.close()


def test_page_follows_a_run_that_goes_on(
    opened: Browser, pages: dict[str, Path]
) -> None:
    lines = pages["trace"].read_text().splitlines(keepends=True)
    run = load(COURIER[0]).start("courier")
    live = Live(live_page(run, "courier"))
    faults: list[str] = []

    def join() -> Page:
        page = opened.new_page()
        page.on("pageerror", lambda one: faults.append(str(one)))
        page.goto(live.address)
        return page

    def reach(page: Page, count: int) -> None:
        page.wait_for_selector(f'html[data-events="{count}"]', state="attached")

    early, late = None, None
    for at, line in enumerate(lines):
        live.feed.write(line)
        if at == 99:
            early = join()
            reach(early, 100)
            assert early.get_attribute("html", "data-moment") == "99"
        elif at in (500, 2_000):
            assert early is not None
            reach(early, at + 1)
    live.feed.end()
    late = join()
    shown = []
    for page in (early, late):
        assert page is not None
        reach(page, len(lines))
        page.press("body", "End")
        assert page.get_attribute("html", "data-moment") == str(len(lines) - 1)
        parts = ("#verdict", ".lanes .names", "#tasks", "#memory", "#events", "#where")
        shown.append([page.inner_text(part) for part in parts])
        page.close()
    live.close()
    assert shown[0][0].startswith("done at time ")
    assert shown[0] == shown[1]
    assert faults == []


def test_timeline_of_a_run_that_goes_on_grows_in_a_part_of_the_time(
    opened: Browser, pages: dict[str, Path]
) -> None:
    lines = pages["trace"].read_text().splitlines(keepends=True)
    ends = [at for at, one in enumerate(lines) if '"task-succeeded"' in one]
    end = next(at for at in ends if '"goal":"(deliver medicine ward-3)"' in lines[at])
    live = Live(live_page(load(COURIER[0]).start("courier"), "courier"))
    for line in lines[:end]:
        live.feed.write(line)
    page = opened.new_page()
    page.goto(live.address)
    page.wait_for_selector(f'html[data-events="{end}"]', state="attached")
    page.click(".names button:has-text('(deliver medicine ward-3)')")
    page.keyboard.press("+")
    page.wait_for_timeout(100)
    pixels = "document.querySelector('.lanes canvas').toDataURL()"
    before = page.evaluate(pixels)
    live.feed.write(lines[end])
    live.feed.end()
    page.wait_for_selector(f'html[data-events="{end + 1}"]', state="attached")
    assert page.evaluate(pixels) != before
    pressed = page.locator(".names button[aria-pressed=true]")
    assert pressed.inner_text().endswith("(deliver medicine ward-3)")
    page.close()
    live.close()


class Steered:
    """The page of a paused run of the truck in a window, with its trace."""

    def __init__(self, opened: Browser) -> None:
        text = self.text = StringIO()
        tasks = ["(rock-order red 1)"]
        listeners = [JsonTrace(text)]
        library = load("examples/rock-order.rap")
        run = library.start("truck", tasks=tasks, seed=7, listeners=listeners)
        self.run, self.control = run, Control(paused=True)
        page = live_page(run, "rock-order", self.control.commands())
        self.live = Live(page, control=self.control)
        for line in text.getvalue().splitlines(keepends=True):
            self.live.feed.write(line)
        run.listen(JsonTrace(self.live.feed))
        Thread(target=self._go, daemon=True).start()
        self.page = opened.new_page(viewport={"width": 1500, "height": 950})
        self.faults: list[str] = []
        self.page.on("pageerror", lambda one: self.faults.append(str(one)))
        self.page.goto(self.live.address)
        self.wait('#control[data-state="paused"]')
        self.wait("html[data-ready]")

    def _go(self) -> None:
        self.control.go(self.run)
        self.live.feed.end()

    def wait(self, selector: str) -> None:
        self.page.wait_for_selector(selector, state="attached")

    def do(self, name: str, text: str) -> str:
        """Fill in the form and send it; return the answer."""
        self.page.evaluate("document.querySelector('#answer').textContent = ''")
        self.page.select_option("#command", name)
        self.page.fill("#argument", text)
        self.page.press("#argument", "Enter")
        self.wait("#answer:not(:empty)")
        return self.page.inner_text("#answer")

    def close(self) -> None:
        self.page.close()
        self.live.close()
        assert self.faults == []


def test_page_pauses_steps_and_continues_a_run(opened: Browser) -> None:
    shown = Steered(opened)
    assert shown.page.inner_text("#status") == "paused at cycle 0, time 0"
    assert "under way" in shown.page.inner_text("#verdict")
    shown.page.click("#step")
    shown.wait('#status:text-is("paused at cycle 1, time 0")')
    shown.page.keyboard.press("s")
    shown.wait('#status:text-is("paused at cycle 2, time 0")')
    assert shown.do("continue", "100").startswith("cycle 2, time 0")
    shown.wait('#control[data-state="paused"]:has(#status:text("time 1"))')
    shown.page.keyboard.press("Escape")
    shown.page.keyboard.press("p")
    shown.wait('#control[data-state="ended"]')
    for name in ("pause", "step", "command", "argument", "perform"):
        assert shown.page.is_disabled(f"#{name}")
    shown.wait('#verdict:text("done at time")')
    shown.close()


def test_page_changes_a_run(opened: Browser) -> None:
    shown = Steered(opened)
    assert shown.do("submit", "(rock-order red 1) :priority 2") == (
        "[2] (rock-order red 1) :priority 2"
    )
    assert shown.page.input_value("#argument") == ""
    said = shown.do("assert", "(truck-status ready)")
    assert said == "asserted (truck-status ready)"
    said = shown.do("force", "(arm-grasp ? ?) arm-dropped 2")
    assert said == "forced (arm-grasp ? ?) arm-dropped 2 times"
    shown.wait(".lanes .goal >> nth=1")
    shown.page.click("#pause")
    shown.wait('#verdict:text("done at time")')
    text = shown.text.getvalue()
    assert '"fact":"(truck-status ready)","by":"user"' in text
    assert text.count('"result":"arm-dropped"') >= 2
    assert "2 succeeded" in shown.page.inner_text("#verdict")
    shown.close()


def test_failed_task_is_named_after_the_number_of_failures(opened: Browser) -> None:
    shown = Steered(opened)
    shown.do("submit", "(rock-order red 1)")
    shown.wait(".lanes .goal >> nth=1")
    shown.page.click("#tasks [data-key='2']")
    assert shown.do("fail", "") == "failed task [2]"
    shown.wait("#verdict .failed")
    verdict = shown.page.inner_text("#verdict")
    assert "1 failed: (rock-order red 1) (interference) · 1 unfinished" in verdict
    shown.page.click("#verdict button")
    assert "failed, interference · " in shown.page.inner_text("#why")
    shown.close()


def test_page_shows_why_an_input_is_refused(opened: Browser) -> None:
    shown = Steered(opened)
    before = shown.text.getvalue()
    for name, text, said in (
        ("submit", "(nothing", "the list of `nothing` is not closed: (nothing"),
        ("submit", "(rock-ordr red 1)", "unknown RAP `rock-ordr`; did you mean"),
        ("assert", "(x)", "unknown predicate `x`"),
        ("submit", "<img src=x onerror=alert(1)>", "expected"),
    ):
        assert shown.do(name, text).startswith(said)
        assert shown.page.locator("#answer.failed").count() == 1
        assert shown.page.input_value("#argument") == text
    assert shown.text.getvalue() == before
    assert shown.do("submit", "(rock-order red 1)").startswith("[2]")
    assert shown.page.locator("#answer.failed").count() == 0
    shown.close()

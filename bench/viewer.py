"""The page of a long run in headless Chromium: its size, opening and redraws.

    python -m bench.viewer [--times 1 10] [--pictures FOLDER]

The run is nine orders of the truck with `shuffle-interval=15`, seed 6000; ten times the
run has further orders. With --pictures, pictures of the page are written to a folder:
three widths, light and dark.
"""

from __future__ import annotations

import argparse
import statistics
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

import msgspec
from click.testing import CliRunner
from playwright.sync_api import Browser, Page

from bench.browser import browser
from rapc.cli.main import cli

_ORDERS = (("red", "factory-1"), ("yellow", "factory-3"), ("blue", "factory-2"))
_MORE = 105
"""The number of further orders, for ten times the events."""

_MOMENTS = 60
"""The number of random moments to go to."""

SIZES = ((1500, 950), (1024, 900), (390, 844))
"""The sizes of windows in pictures."""


class Figures(msgspec.Struct, frozen=True):
    """The figures of one page; times in milliseconds."""

    events: int
    megabytes: float
    #: From the navigation to the page with all panels.
    ready: float
    #: The redraw of all panels at a random moment: the median and the longest.
    redraw: float
    longest: float
    #: The requests of the page besides its own file.
    requests: tuple[str, ...]


def orders(times: int) -> Iterator[str]:
    """Yield the arguments of the command line for the run, or for ten times the run."""
    yield from ("stdlib/truck", "--world", "truck", "--agenda", "nine-orders")
    yield from ("--set", "truck.shuffle-interval=15", "--seed", "6000")
    for at in range(_MORE if times > 1 else 0):
        color, factory = _ORDERS[at % len(_ORDERS)]
        yield "--task"
        yield f"(fill-order {color} 4 {factory}) :priority 2 :at {660 + at * 600}"


def write_page(arguments: Sequence[str], file: Path) -> None:
    """Write the page of a run."""
    done = CliRunner().invoke(cli, ["view", *arguments, "-o", str(file)])
    assert done.exit_code == 0, done.output


def opened(chromium: Browser, file: Path, width: int, height: int, scheme: str) -> Page:
    """Open a page and wait until it shows the run."""
    options = {"width": width, "height": height}
    page = chromium.new_page(viewport=options, color_scheme=scheme)  # type: ignore[arg-type]
    page.goto(file.resolve().as_uri())
    page.wait_for_selector("html[data-ready]", state="attached", timeout=60_000)
    return page


def measured(chromium: Browser, file: Path) -> Figures:
    """Measure a page."""
    requests: list[str] = []
    page = chromium.new_page(viewport={"width": 1500, "height": 950})
    page.on("request", lambda one: requests.append(one.url))
    page.goto(file.resolve().as_uri())
    page.wait_for_selector("html[data-ready]", state="attached", timeout=60_000)
    ready = float(page.get_attribute("html", "data-ready") or "nan")
    where = page.text_content("#where") or ""
    events = int(page.get_attribute("html", "data-events") or "0")
    assert where
    times: list[float] = []
    for at in range(_MOMENTS):
        moment = (at * 7919 * 104_729) % events
        # The page redraws in the handler of the change of its address.
        page.evaluate(f"location.hash = 'n={moment}'")
        page.wait_for_selector(f'html[data-moment="{moment}"]', state="attached")
        times.append(float(page.get_attribute("html", "data-redraw") or "nan"))
    page.close()
    return Figures(
        events,
        file.stat().st_size / 1e6,
        ready,
        statistics.median(times),
        max(times),
        tuple(one for one in requests if one != file.resolve().as_uri()),
    )


def main() -> None:
    """Measure the pages, and take pictures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--times", nargs="+", type=int, default=[1, 10])
    parser.add_argument("--pictures", type=Path)
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder, browser() as chromium:
        for times in args.times:
            file = Path(folder) / f"{times}.html"
            write_page([*orders(times)], file)
            print(f"{times}:", measured(chromium, file))
        if args.pictures:
            args.pictures.mkdir(parents=True, exist_ok=True)
            for width, height in SIZES:
                for scheme in ("light", "dark"):
                    page = opened(chromium, file, width, height, scheme)
                    shot = args.pictures / f"{width}-{scheme}.png"
                    page.screenshot(path=shot, full_page=width < SIZES[0][0])
                    page.close()


if __name__ == "__main__":
    main()

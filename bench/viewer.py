"""The page of a long run in headless Chromium: its size, opening and redraws.

    python -m bench.viewer [--times 1 10] [--pictures FOLDER]

The run is nine orders of the truck with `shuffle-interval=15`, seed 6000; ten times the
run has further orders and a truck that needs no fuel. Each moment is visited several
times, and its shortest redraw counts: a redraw that other processes disturb says
nothing about the page. The first redraw is part of the time until the page is ready.
With --pictures, pictures of the page are written to a folder instead, three widths,
light and dark: those of the manual with `--pictures docs/figures`.
"""

from __future__ import annotations

import argparse
import statistics
import tempfile
from collections.abc import Iterator, Sequence
from io import BytesIO
from pathlib import Path

import msgspec
from click.testing import CliRunner
from PIL import Image
from playwright.sync_api import Browser, Page

from bench.browser import browser
from rapc.cli.main import cli

_ORDERS = (("red", "factory-1"), ("yellow", "factory-3"), ("blue", "factory-2"))
_MORE = 110
"""The number of further orders, for ten times the events."""

_MOMENTS = 60
"""The number of random moments to go to."""

_VISITS = 5
"""The number of visits to each moment."""

_VISIT = """async (moment) => {
  const root = document.documentElement;
  const changed = new Promise((done) =>
    addEventListener("hashchange", done, { once: true }));
  location.hash = `n=${moment}`;
  await changed; // the page has redrawn in its own handler of this event
  const redraws = [Number(root.dataset.redraw)];
  for (const row of [...document.querySelectorAll("#tasks [data-key]")].slice(-1)) {
    row.click();
    redraws.push(Number(root.dataset.redraw));
  }
  if (Number(root.dataset.moment) !== moment) throw new Error("another moment");
  return redraws;
}"""
"""Go to a moment, then select its last task; return the duration of each redraw."""

_SIZES = ((1500, 950), (1024, 900), (390, 844))
"""The sizes of windows in pictures."""

_LONGEST = 2060
"""The height of a picture of a page that is higher than its window."""


class Figures(msgspec.Struct, frozen=True):
    """The figures of one page; times in milliseconds."""

    events: int
    megabytes: float
    #: From the navigation to the page with all panels.
    ready: float
    #: The redraw of all panels at a random moment, without and with a task selected:
    #: the median and the longest of the shortest redraws of each.
    redraw: float
    longest: float
    #: The requests of the page besides its own file.
    requests: tuple[str, ...]


def orders(times: int) -> Iterator[str]:
    """Yield the arguments of the command line for the run, or for ten times the run."""
    yield from ("stdlib/truck", "--world", "truck", "--agenda", "nine-orders")
    yield from ("--set", "truck.shuffle-interval=15", "--seed", "6000")
    if times > 1:
        yield from ("--set", "truck.fuel-use=0")
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
    events = int(page.get_attribute("html", "data-events") or "0")
    redraws: dict[tuple[int, int], list[float]] = {}
    for _ in range(_VISITS):
        for at in range(_MOMENTS):
            moment = (at * 7919 * 104_729) % events
            for step, time in enumerate(page.evaluate(_VISIT, moment)):
                redraws.setdefault((moment, step), []).append(time)
    times = [min(several) for several in redraws.values()]
    page.close()
    return Figures(
        events,
        file.stat().st_size / 1e6,
        ready,
        statistics.median(times),
        max(times),
        tuple(one for one in requests if one != file.resolve().as_uri()),
    )


def best(chromium: Browser, file: Path, openings: int = 3) -> Figures:
    """Return the shortest times of several openings of a page."""
    all_ = [measured(chromium, file) for _ in range(openings)]
    return msgspec.structs.replace(
        all_[0],
        ready=min(one.ready for one in all_),
        redraw=min(one.redraw for one in all_),
        longest=min(one.longest for one in all_),
        requests=tuple(url for one in all_ for url in one.requests),
    )


def write_pictures(chromium: Browser, file: Path, folder: Path) -> None:
    """Write a picture of a page for each size of windows and each scheme of colours."""
    for width, height in _SIZES:
        for scheme in ("light", "dark"):
            page = opened(chromium, file, width, height, scheme)
            page.wait_for_timeout(300)
            whole = page.screenshot(full_page=True)
            page.close()
            picture = Image.open(BytesIO(whole)).convert("RGB")
            shown = picture.crop((0, 0, width, min(picture.height, _LONGEST)))
            small = shown.quantize(256, Image.Quantize.FASTOCTREE)
            small.save(folder / f"view-{width}-{scheme}.png", optimize=True)


def main() -> None:
    """Measure the pages, or take pictures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--times", nargs="+", type=int, default=[1, 10])
    parser.add_argument("--pictures", type=Path)
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder, browser() as chromium:
        for times in [1] if args.pictures else args.times:
            file = Path(folder) / f"{times}.html"
            write_page([*orders(times)], file)
            if args.pictures:
                write_pictures(chromium, file, args.pictures)
            else:
                print(f"{times} times:", best(chromium, file))


if __name__ == "__main__":
    main()

"""Take pictures of the main pages of the site with headless Chromium.

    python docs/pictures.py FOLDER [PAGE...]

`docs/build.py` builds the site before. Each page is shown light and dark, 1280 and 390
pixels wide. The server forbids requests to other hosts (Content Security Policy), and
the script reports pages that try one.
"""

from __future__ import annotations

import argparse
import functools
import http.server
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Literal, get_args

from playwright.sync_api import Browser, ViewportSize

sys.path.insert(0, str(Path(__file__).parents[1]))

from bench.browser import browser

SITE = Path(__file__).parents[1] / "site"

PAGES = (
    "",
    "tutorials/first-robot",
    "how-to/behaviour-trees",
    "explanation/how-raps-work",
    "language/8-things",
    "reference/cli",
    "reference/rules",
    "reference/rules/unbound-variable",
    "reference/python-api",
    "libraries/hallway",
)
"""The main pages, by address."""

WIDTHS = (1280, 390)
HEIGHT = 1600
Scheme = Literal["light", "dark"]
SCHEMES: tuple[Scheme, ...] = get_args(Scheme)

POLICY = "default-src 'self' data: blob: 'unsafe-inline' 'wasm-unsafe-eval'"
"""The policy that the server sends: no request to another host."""


class _Server(http.server.SimpleHTTPRequestHandler):
    """A server of files with a policy; it reports nothing."""

    def end_headers(self) -> None:
        """Send the policy with the headers."""
        self.send_header("Content-Security-Policy", POLICY)
        super().end_headers()

    def log_message(self, format: str, *args: object) -> None:
        """Report nothing."""


@contextmanager
def served() -> Iterator[str]:
    """Serve the site on a free port of this machine; yield its address."""
    handler = functools.partial(_Server, directory=str(SITE))
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler)
    thread = threading.Thread(target=server.serve_forever, daemon=True)
    thread.start()
    try:
        yield f"http://127.0.0.1:{server.server_port}/"
    finally:
        server.shutdown()
        server.server_close()


def picture(
    chromium: Browser, address: str, file: Path, width: int, scheme: Scheme
) -> list[str]:
    """Take a picture of a page; return the requests that the policy refused."""
    size: ViewportSize = {"width": width, "height": HEIGHT}
    page = chromium.new_page(viewport=size, color_scheme=scheme)
    said: list[str] = []
    page.on("console", lambda message: said.append(message.text))
    page.goto(address, wait_until="networkidle")
    page.screenshot(path=file)
    page.close()
    return [one for one in said if "Content Security Policy" in one]


def main() -> int:
    """Take all pictures; return 1 if a page requested another host."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("pages", nargs="*", default=PAGES)
    args = parser.parse_args()
    args.folder.mkdir(parents=True, exist_ok=True)
    foreign: set[str] = set()
    with served() as address, browser() as chromium:
        for page in args.pages:
            if not (SITE / page / "index.html").exists():
                print(f"missing page: {page}")
                continue
            for width in WIDTHS:
                for scheme in SCHEMES:
                    name = page.replace("/", "-") or "index"
                    file = args.folder / f"{name}-{width}-{scheme}.png"
                    foreign |= {
                        *picture(chromium, f"{address}{page}", file, width, scheme)
                    }
                    print(file)
    for one in sorted(foreign):
        print(f"error: {one}", file=sys.stderr)
    return int(bool(foreign))


if __name__ == "__main__":
    sys.exit(main())

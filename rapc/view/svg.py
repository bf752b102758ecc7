"""Pictures of worlds as SVG files."""

from __future__ import annotations

import re
from collections.abc import Iterator
from html import escape
from pathlib import Path

from rapc.base.visible import visible
from rapc.view.scene import Scene, Shape

_STYLE = Path(__file__).parent / "page" / "map.css"

_COLOUR = re.compile(r"(--map-[a-z]+): light-dark\((#[0-9a-f]+), #[0-9a-f]+\);")


def svg(scene: Scene, title: str) -> str:
    """Return a scene as the text of an SVG file with light colours."""
    size = f"{scene.width:g} {scene.height:g}"
    return "".join(
        (
            '<?xml version="1.0" encoding="UTF-8"?>\n',
            f'<svg xmlns="http://www.w3.org/2000/svg" class="map" viewBox="0 0 {size}" '
            f'width="{scene.width:g}" height="{scene.height:g}">\n',
            f"<title>{_safe(title)}</title>\n<style>{_style()}</style>\n",
            '<rect width="100%" height="100%" fill="#ffffff"/>\n',
            *map(_element, scene.shapes),
            "</svg>\n",
        )
    )


def _style() -> str:
    """Return the style of drawings with light colours; many readers know no others."""
    text = _STYLE.read_text(encoding="utf-8")
    head, _, rules = text.partition("}\n")
    colours = dict(_COLOUR.findall(head))
    return re.sub(r"var\((--map-[a-z]+)\)", lambda m: colours[m[1]], rules)


def _element(shape: Shape) -> str:
    tag, attributes, text = shape
    inside = _safe(text) if tag == "text" else f"<title>{_safe(text)}</title>"
    written = "".join(_attributes(attributes))
    return f"<{tag}{written}>{inside if text else ''}</{tag}>\n"


def _attributes(attributes: dict[str, object]) -> Iterator[str]:
    for name, value in attributes.items():
        text = f"{value:g}" if isinstance(value, float) else str(value)
        yield f' {name}="{_safe(text)}"'


def _safe(text: str) -> str:
    return escape(visible(text))

"""What is done after a wheel is built: compiled modules are taken out of the checkout.

mypyc puts them beside their sources. There Python would import them in place of these,
whatever is changed in the sources later.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class CustomBuildHook(BuildHookInterface[Any]):
    """Removes what mypyc has made; hatchling finds the class by this name."""

    def finalize(
        self, version: str, build_data: dict[str, Any], artifact_path: str
    ) -> None:
        """Remove the compiled modules that the wheel at `artifact_path` now holds."""
        if build_data["pure_python"]:
            return
        root = Path(self.root)
        for suffix in ("so", "pyd"):
            for made in (*root.glob(f"rapc/**/*.{suffix}"), *root.glob(f"*.{suffix}")):
                made.unlink()

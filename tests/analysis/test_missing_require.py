"""The fix of `missing-require`: each file can be checked alone afterwards."""

from __future__ import annotations

from pathlib import Path

import pytest

from rapc.analysis.check_files import check_files
from rapc.analysis.fixes import mend

SEVERAL = Path(__file__).parent / "several"


@pytest.mark.parametrize("library", ["house", "garden"])
def test_fixed_files_stand_alone(library: str, tmp_path: Path) -> None:
    for file in (SEVERAL / library).iterdir():
        (tmp_path / file.name).write_text(file.read_text("utf-8"), encoding="utf-8")
    whole = [str(tmp_path)]
    mended = mend(lambda texts: check_files(whole, None, texts), bool, unsafe=True)
    assert mended.fixed == 2
    assert mended.report.findings == ()
    for file in tmp_path.iterdir():
        assert check_files([str(file)], None, mended.texts).findings == ()

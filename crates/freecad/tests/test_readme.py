"""The code of README.md does what it says."""

from __future__ import annotations

import os
from pathlib import Path

import FreeCAD
import pytest
from conftest import HERE

from wireloom_freecad import objects

README = (HERE.parent / "README.md").read_text(encoding="utf-8")


def test_the_example_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    (code,) = [part.split("```")[0] for part in README.split("```python")[1:]]
    monkeypatch.chdir(tmp_path)
    try:
        exec(compile(code, "README.md", "exec"), {"__name__": "readme"})
    finally:
        FreeCAD.closeDocument("Example")
    assert capsys.readouterr().out.split() == ["converged", "pass"]
    assert os.path.getsize(tmp_path / "cable.step") > 1000


def test_every_kind_is_in_the_table() -> None:
    rows = [line.split("|")[1].strip() for line in README.splitlines() if line.startswith("| ")]
    assert set(objects.PROPERTIES) <= set(rows)

"""The notebooks of the gallery run, cell by cell."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

FOLDER = Path(__file__).resolve().parents[1] / "notebooks"
BOOKS = sorted(FOLDER.glob("*.ipynb"))


def test_there_are_six() -> None:
    assert len(BOOKS) == 6


@pytest.mark.parametrize("book", BOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs(book: Path) -> None:
    for needed in ("duckdb", "matplotlib"):
        pytest.importorskip(needed, reason=f"{needed} is not installed, which notebooks use: pip install {needed}")
    cells = json.loads(book.read_text(encoding="utf-8"))["cells"]
    code = [cell for cell in cells if cell["cell_type"] == "code"]
    assert code and not any(cell["outputs"] for cell in code), "outputs are not kept in the repository"
    # Each cell by its own name, so that an error says which it was.
    steps = [f"exec(compile({''.join(cell['source'])!r}, 'cell {k}', 'exec'))" for k, cell in enumerate(code, 1)]
    program = "\n".join(["import matplotlib; matplotlib.use('Agg')", *steps])
    out = subprocess.run([sys.executable, "-c", program], cwd=FOLDER, capture_output=True, text=True, timeout=300)
    assert out.returncode == 0, out.stderr

"""The live widget of a session: alone, and in JupyterLab in a browser."""

import json
import os
import shutil
import socket
import subprocess
import sys
import time
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import wireloom

pytest.importorskip("anywidget", reason="anywidget is not installed: pip install anywidget")


@pytest.fixture
def session() -> Iterator[wireloom.Session]:
    with wireloom.Session(wireloom.loads(wireloom.EXAMPLE)) as session:
        yield session


def test_a_motion_of_the_page_moves_the_session(session: wireloom.Session, monkeypatch: pytest.MonkeyPatch) -> None:
    widget = session.widget()
    sent: list[tuple[dict[str, Any], list[bytes]]] = []
    monkeypatch.setattr(widget, "send", lambda message, buffers=None: sent.append((message, buffers or [])))
    before = np.frombuffer(widget.positions).reshape(-1, 3)
    assert np.array_equal(before, session.state.branches["cable"].position)
    assert {own["name"] for own in widget.shape["constraints"]} == {"plug-A", "plug-B"}
    widget._heard(widget, {"move": "plug-B", "position": [0.8, 0.1, 0.0]}, [])
    message, [positions] = sent.pop()
    assert message["step"]["status"] == "converged" and message["step"]["last"] == "plug-B"
    assert np.array_equal(np.frombuffer(positions).reshape(-1, 3), session.state.branches["cable"].position)
    assert np.allclose(session.state.constraints["plug-B"].position, [0.8, 0.1, 0.0], atol=1e-9)
    assert widget.positions == positions
    # What is not possible is said, and changes nothing.
    for wrong in ({"move": "plug-X", "position": [0, 0, 0]}, {"move": "plug-B", "position": [0, None]}):
        widget._heard(widget, wrong, [])
        assert sent.pop()[0].keys() == {"refused"}
    widget._heard(widget, "nonsense", [])
    assert not sent and np.allclose(session.state.constraints["plug-B"].position, [0.8, 0.1, 0.0], atol=1e-9)
    session.undo()
    widget.refresh()
    assert np.array_equal(np.frombuffer(widget.positions).reshape(-1, 3), before)


CELLS = [
    "import wireloom\nsession = wireloom.Session(wireloom.loads(wireloom.EXAMPLE))\nwidget = session.widget()\nwidget",
    "print('plug', *session.state.constraints['plug-B'].position)",
]


@pytest.fixture
def lab(tmp_path: Path) -> Iterator[str]:
    """The address of a JupyterLab that serves a notebook with these cells."""
    pytest.importorskip("jupyterlab", reason="JupyterLab is not installed: pip install jupyterlab")
    cells = [
        {"cell_type": "code", "id": f"c{k}", "metadata": {}, "source": own, "execution_count": None, "outputs": []}
        for k, own in enumerate(CELLS)
    ]
    kernel = {"kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"}}
    book = {"cells": cells, "metadata": kernel, "nbformat": 4, "nbformat_minor": 5}
    (tmp_path / "live.ipynb").write_text(json.dumps(book))
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    command = [sys.executable, "-m", "jupyterlab", "--no-browser", f"--port={port}", "--IdentityProvider.token=", "--allow-root"]
    own = {name: str(tmp_path / name) for name in ("JUPYTER_CONFIG_DIR", "JUPYTER_DATA_DIR", "JUPYTER_RUNTIME_DIR")}
    log = tmp_path / "lab.log"
    with log.open("wb") as said:
        server = subprocess.Popen(command, cwd=tmp_path, env=os.environ | own, stdout=said, stderr=said)
    address = f"http://127.0.0.1:{port}"
    try:
        for _ in range(120):
            try:
                urllib.request.urlopen(f"{address}/api", timeout=5).close()
                break
            except OSError:
                assert server.poll() is None, "JupyterLab has ended"
                time.sleep(0.5)
        else:
            pytest.fail("JupyterLab does not answer")
        yield f"{address}/lab/tree/live.ipynb"
    finally:
        server.terminate()
        server.wait(30)
        # pytest shows it where the test fails.
        print(log.read_text(errors="replace"))


def test_a_plug_is_dragged_in_jupyterlab(lab: str) -> None:
    chromium = shutil.which("chromium")
    if chromium is None:
        pytest.skip("there is no chromium to open the notebook in")
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed: pip install playwright")
    with playwright.sync_playwright() as play:
        browser = play.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        page = browser.new_page(viewport={"width": 1200, "height": 900})
        page.set_default_timeout(120_000)
        page.on("console", lambda message: print("console:", message.text))
        page.on("pageerror", lambda error: print("page:", error))
        page.goto(lab)

        def run(cell: int) -> None:
            # While the kernel starts, JupyterLab may drop the key.
            page.locator(".jp-Notebook-ExecutionIndicator[data-status=idle]").wait_for(state="attached")
            prompt = page.locator(".jp-CodeCell .jp-InputPrompt").nth(cell)
            for _ in range(4):
                page.locator(".jp-CodeCell .cm-content").nth(cell).click()
                page.keyboard.press("Shift+Enter")
                page.wait_for_timeout(1_000)
                if prompt.inner_text() != "[ ]:":
                    break
            playwright.expect(prompt).to_have_text(f"[{cell + 1}]:", timeout=120_000)

        run(0)
        canvas = page.locator("canvas[data-places]")
        canvas.wait_for()
        canvas.scroll_into_view_if_needed()
        places = {name: (x, y) for name, x, y, _ in json.loads(canvas.get_attribute("data-places") or "[]")}
        box = canvas.bounding_box()
        assert box is not None and set(places) == {"plug-A", "plug-B"}
        x, y = box["x"] + places["plug-B"][0], box["y"] + places["plug-B"][1]
        page.mouse.move(x, y)
        page.mouse.down()
        page.mouse.move(x - 30, y - 20, steps=5)
        page.mouse.up()
        page.wait_for_function("Number(document.querySelector('canvas[data-moves]').dataset.moves) > 0")
        picture = os.environ.get("WIRELOOM_WIDGET_PICTURE")
        if picture is not None:
            page.screenshot(path=picture)
        run(1)
        output = page.locator(".jp-OutputArea-output pre", has_text="plug")
        output.wait_for()
        moved = np.array([float(number) for number in output.inner_text().split()[1:]])
        browser.close()
    # It was at (0.7, 0, 0): the drag is to the left and upwards.
    assert moved[2] > 0.005 and moved[0] < 0.695

"""The workbench in FreeCAD's user interface, on a display without a screen."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from pathlib import Path
from typing import Any

import FreeCAD
import pytest
import wireloom
from conftest import HERE

#: Preferences: no page at the start, which needs a browser.
PREFERENCES = """<?xml version="1.0" encoding="UTF-8" standalone="no" ?>
<FCParameters>
  <FCParamGroup Name="Root"><FCParamGroup Name="BaseApp"><FCParamGroup Name="Preferences">
    <FCParamGroup Name="General"><FCText Name="AutoloadModule">PartWorkbench</FCText></FCParamGroup>
    <FCParamGroup Name="Mod"><FCParamGroup Name="Start">
      <FCBool Name="ShowOnStartup" Value="0"/>
    </FCParamGroup></FCParamGroup>
  </FCParamGroup></FCParamGroup></FCParamGroup>
</FCParameters>
"""
PROGRAMS = ("freecad", "xvfb-run", "xauth")
MISSING = [program for program in PROGRAMS if not shutil.which(program)]


def home(folder: Path) -> Path:
    """A user's folder of FreeCAD with the workbench and the package beside it, as the README installs them."""
    mod = folder / "Mod" / "Wireloom"
    mod.mkdir(parents=True)
    for name in ("Init.py", "InitGui.py", "package.xml", "wireloom_freecad"):
        (mod / name).symlink_to(HERE.parent / name)
    (mod / "wireloom").symlink_to(Path(wireloom.__file__).parent)
    (folder / "user.cfg").write_text(PREFERENCES)
    return folder


def environment(folder: Path, out: Path) -> dict[str, str]:
    """Variables of a FreeCAD that knows nothing of the user's own."""
    own = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    return own | {
        "FREECAD_USER_HOME": str(folder),
        "WIRELOOM_GUI_OUT": str(out),
        "WIRELOOM_GUI_TESTS": str(HERE),
        "QTWEBENGINE_DISABLE_SANDBOX": "1",
        "PYTHONDONTWRITEBYTECODE": "1",
    }


@pytest.mark.skipif(bool(MISSING), reason=f"no {', no '.join(MISSING)}: the user interface cannot be started")
def test_the_workbench_in_the_user_interface(tmp_path: Path) -> None:
    out = tmp_path / "out"
    out.mkdir()
    folder = home(tmp_path / "home")
    arguments = ["freecad", "-u", str(folder / "user.cfg"), str(HERE / "gui_script.py")]
    screen = ["xvfb-run", "-a", "-s", "-screen 0 1800x1000x24"]
    done = subprocess.run(
        screen + arguments, env=environment(folder, out), capture_output=True, text=True, timeout=240, check=False
    )
    assert (out / "found.json").is_file(), done.stdout + done.stderr
    found: dict[str, Any] = json.loads((out / "found.json").read_text())
    assert "error" not in found, found["error"]
    assert found["workbench"] == "WireloomWorkbench"
    assert found["missing commands"] == [] and found["missing icons"] == []
    assert found["harness"] == ["converged", "pass", ""] and found["mode"] == "Bend radius"
    assert found["drags"] >= 2 and found["while dragged"] == ["moved by hand: recompute", "none"]
    assert found["dragged to"] == pytest.approx([0.32, 0.06, 0.02], abs=1e-6)
    assert found["made by a command"] == ["section"]
    assert found["marks"] == len(found["violations"]) >= 1 and found["icon"] == "harness_not_good.svg"
    blue, amber = colours(out / "scene.png")
    assert blue > 200 and amber > 50, "tubes in the colours of their bend radius"
    if os.environ.get("WIRELOOM_PICTURE") == "write":
        shutil.copyfile(out / "window.png", HERE.parent / "workbench.png")


def colours(path: Path) -> tuple[int, int]:
    """Number of blue and of amber points of a picture."""
    script = "import sys, json; from PySide2.QtGui import QImage; i = QImage(sys.argv[1]);" + (
        "p = [i.pixelColor(x, y) for x in range(0, i.width(), 2) for y in range(0, i.height(), 2)];"
        "print(sum(c.blue() > c.red() + 40 for c in p), sum(c.red() > c.blue() + 60 for c in p))"
    )
    done = subprocess.run(["/usr/bin/python3", "-c", script, str(path)], capture_output=True, text=True, check=True)
    blue, amber = map(int, done.stdout.split())
    return blue, amber


@pytest.mark.skipif(not shutil.which("freecadcmd"), reason="no freecadcmd")
def test_the_program_without_a_user_interface_opens_scenarios(tmp_path: Path) -> None:
    folder = home(tmp_path / "home")
    script = tmp_path / "script.py"
    scenario = HERE.parents[2] / "scenarios/first.toml"
    script.write_text(
        "import FreeCAD, os\n"
        "module = FreeCAD.getImportType('toml')[0]\n"
        f"document = __import__(module, fromlist=['open']).open({str(scenario)!r})\n"
        "harness = document.getObject('WireloomHarness')\n"
        "ways = FreeCAD.getImportType('kbl') + FreeCAD.getExportType('toml') + FreeCAD.getExportType('html')\n"
        f"open({str(tmp_path / 'out')!r}, 'w').write(' '.join([harness.Status, harness.Verdict, *ways]))\n"
        "os._exit(0)\n"
    )
    done = subprocess.run(
        ["freecadcmd", str(script)],
        env=environment(folder, tmp_path),
        capture_output=True,
        text=True,
        timeout=240,
        check=False,
    )
    assert (tmp_path / "out").is_file(), done.stdout + done.stderr
    said = (tmp_path / "out").read_text().split()
    assert said[:2] == ["converged", "pass"]
    assert set(said[2:]) >= {"wireloom_freecad.importing", "wireloom_freecad.exporting"}


def test_the_addon_manager_reads_the_package() -> None:
    found = FreeCAD.Metadata(str(HERE.parent / "package.xml"))
    assert found.Name == "Wireloom" and found.Version == "0.1.0"
    assert sorted(own["name"] for own in found.License) == ["Apache-2.0", "MIT"]
    (bench,) = found.Content["workbench"]
    assert bench.Classname == "WireloomWorkbench"
    assert (HERE.parent / bench.Icon).is_file()

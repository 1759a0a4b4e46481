"""Runs and their results."""

import gc
import json
import os
import re
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

import wireloom
from wireloom import _wireloom

from conftest import SCENARIOS


def without_times(data: bytes) -> bytes:
    """A result without the seconds that it took."""
    text, count = re.subn(rb'"seconds":[-0-9.e+]+', b'"seconds":0', data)
    assert count > 0
    return text


def test_the_result_is_that_of_the_command_line_byte_by_byte(
    first: wireloom.Scenario, program: str, tmp_path: Path
) -> None:
    subprocess.run([program, "run", "-q", SCENARIOS / "first.toml", "--out", tmp_path / "cli"], check=True)
    path = first.run().save(tmp_path / "python")
    assert path == str(tmp_path / "python" / "result.json")
    own, other = Path(path).read_bytes(), (tmp_path / "cli" / "result.json").read_bytes()
    assert without_times(own) == without_times(other)
    assert sorted(os.listdir(tmp_path / "python")) == ["picture.svg", "result.json"]


EVERYTHING = """
[output]
increments = true
fields = "arrow"
csv = true
vtk = true
gltf = true
report = true
clearance = true
swept = "10 mm"
"""


CARRIED = """
path = [[0, -0.5, 0], [0.9, -0.5, 0]]
drawn = [[0, 0, 0], [0.9, 0, 0]]
"""


def test_the_comparison_with_the_drawn_start_is_that_of_the_command_line(program: str, tmp_path: Path) -> None:
    text = (SCENARIOS / "mechanisms" / "robot.toml").read_text()
    cable, _ = text.split("[[mechanisms]]")
    ends = (("wall", "wall", 0.0), ("plug", "far", 0.8))
    plugs = "".join(
        f'[[constraints]]\nname = "{name}"\nkind = "connector"\nat = {{ end = "{end}" }}\n'
        f"position = [{x}, -0.5, 0]\ntangent = [1, 0, 0]\nup = [0, 0, 1]\n"
        for end, name, x in ends
    )
    moves = '[[steps]]\nname = "carry"\nincrements = 4\nmove = [{ constraint = "wall", position = [0, 0, 0] }, '
    path = tmp_path / "carried.toml"
    path.write_text(cable + CARRIED + plugs + moves + '{ constraint = "far", position = [0.8, 0, 0] }]\n')
    subprocess.run([program, "run", "-q", path, "--out", tmp_path / "cli"], check=True)
    own, other = Path(wireloom.load(path).run().save(tmp_path / "python")), tmp_path / "cli" / "result.json"
    assert "drawn_start" in json.loads(own.read_text())
    assert without_times(own.read_bytes()) == without_times(other.read_bytes())


def test_all_files_are_those_of_the_command_line_byte_by_byte(program: str, tmp_path: Path) -> None:
    text = (SCENARIOS / "assembly" / "door.toml").read_text()
    assert "[output]" not in text
    path = tmp_path / "door.toml"
    path.write_text(text + EVERYTHING)
    subprocess.run([program, "run", "-q", path, "--out", tmp_path / "cli"], check=True)
    wireloom.load(path).run().save(tmp_path / "python")
    files = lambda folder: {  # noqa: E731
        str(own.relative_to(folder)): own.read_bytes() for own in folder.rglob("*") if own.is_file()
    }
    own, other = files(tmp_path / "python"), files(tmp_path / "cli")
    other = {name: data for name, data in other.items() if not name.startswith(".wireloom")}
    assert sorted(own) == sorted(other)
    for kind in ("result.json", "fields.arrow", "picture.svg", "report.html", "harness.pvd", "harness.glb", "swept.glb"):
        assert kind in own
    assert sum(name.startswith("vtk/") for name in own) > 10 and sum(name.startswith("csv/") for name in own) > 3
    # Reports say when they were written and how long the run took, results the latter.
    for name in own.keys() - {"report.html", "result.json"}:
        assert own[name] == other[name], name
    assert without_times(own["result.json"]) == without_times(other["result.json"])
    lines = [data["report.html"].decode().split("<") for data in (own, other)]
    changed = [pair for pair in zip(*lines, strict=True) if pair[0] != pair[1]]
    assert len(changed) < 20, changed


def test_values_are_those_of_the_file(run: wireloom.Run, tmp_path: Path) -> None:
    data = json.loads(Path(run.save(tmp_path)).read_text())
    assert (run.scenario, run.status, run.verdict) == (data["scenario"], data["status"], data["verdict"])
    assert len(run.steps) == len(data["steps"]) == 40
    for step, own in zip(run.steps, data["steps"], strict=True):
        assert (step.name, step.increment, step.status, step.stable) == (
            own["name"],
            own["increment"],
            own["status"],
            own["stable"],
        )
        assert step.energy == own["energy"]
        assert list(step.branches) == list(own["branches"])
        for name, branch in step.branches.items():
            there = own["branches"][name]
            for key in ("s", "position", "d1", "d3", "force", "moment"):
                assert getattr(branch, key).tolist() == there[key], (name, key)
            radius = [np.inf if r is None else r for r in there["bend_radius"]]
            assert branch.bend_radius.tolist() == radius
            assert np.allclose(np.cross(branch.d3, branch.d1), branch.d2, atol=1e-12)
            assert (branch.twist_turns, branch.diameter) == (there["twist_turns"], there["diameter"])
            error = there["error"]
            assert branch.order == error.pop("order") == 4
            assert branch.error == error
        for name, constraint in step.constraints.items():
            there = own["constraints"][name]
            assert constraint.force.tolist() == there["force"] and constraint.moment.tolist() == there["moment"]
            assert constraint.position.tolist() == there["position"] and constraint.kind == there["kind"]
        assert step.joints["J"].position.tolist() == own["joints"]["J"]["position"]
        assert step.min_bend_radius == own["min_bend_radius"]
    assert [(r.name, r.verdict, r.worst, r.limit, r.margin, r.error) for r in run.requirements] == [
        (r["name"], r["verdict"], r["worst"], r["limit"], r["margin"], r["error"]) for r in data["requirements"]
    ]
    assert [(e.kind, e.first.step, e.value, e.message) for e in run.events] == [
        (e["kind"], e["first"]["step"], e["value"], e["message"]) for e in data["events"]
    ]


def test_a_cable_with_friction_keeps_a_set(tmp_path: Path) -> None:
    scenario = wireloom.loads(wireloom.EXAMPLE)
    elastic = scenario.run().steps[-1].branches["cable"]
    assert elastic.set is None and elastic.dissipated is None
    scenario["sections.cable.friction"] = {"bending": [{"stiffness": 0.01, "moment": 0.001}]}
    run = scenario.run()
    branch = run.steps[-1].branches["cable"]
    own = json.loads(Path(run.save(tmp_path)).read_text())["steps"][-1]["branches"]["cable"]["friction"]
    assert branch.set is not None and branch.set.shape == branch.position.shape
    assert branch.set.tolist() == own["set"]
    assert branch.dissipated == (own["dissipated"], own["dissipated_in_all"]) and own["dissipated_in_all"] > 0


def test_a_branch_whose_section_changes_has_parts(tmp_path: Path) -> None:
    scenario = wireloom.loads(wireloom.EXAMPLE)
    plain = scenario.run().steps[-1].branches["cable"]
    assert plain.sections == ()
    assert plain.diameters.tolist() == [0.006] * len(plain)
    tube = {**scenario["sections.cable"], "diameter": "12 mm", "min_bend_radius": "90 mm", "bending_stiffness": 0.03}
    scenario["sections.tube"] = tube
    scenario["branches.cable.sections"] = [{"section": "tube", "from": 0.3, "to": 0.6}]
    run = scenario.run()
    cable = run.steps[-1].branches["cable"]
    assert [(part.section, part.start, part.end) for part in cable.sections] == [
        ("cable", 0.0, pytest.approx(0.3)),
        ("tube", pytest.approx(0.3), pytest.approx(0.6)),
        ("cable", pytest.approx(0.6), pytest.approx(1.0)),
    ]
    # The thin cable bends more tightly than the tube that it meets.
    inside = (cable.s > 0.3 + 1e-9) & (cable.s < 0.6 - 1e-9)
    assert cable.diameters.tolist() == np.where(inside, 0.012, 0.006).tolist()
    assert cable.bend_radius_limits.tolist() == np.where(inside, 0.09, 0.04).tolist()
    again = wireloom.Run.open(run.save(tmp_path)).steps[-1].branches["cable"]
    assert again.sections == cable.sections and again.diameter == cable.diameter == 0.012


def test_events_have_places() -> None:
    scenario = wireloom.loads(wireloom.EXAMPLE)
    scenario["sections.cable.min_bend_radius"] = "400 mm"
    run = scenario.run()
    assert run.verdict == "fail"
    (event,) = [event for event in run.events if event.place.branch == "cable"]
    assert event.value is not None and event.value < 0.4 == event.limit
    assert event.place.s is not None and 0 <= event.place.s <= 1 + 1e-12
    failed = [line.name for line in run.requirements if line.verdict == "fail"]
    assert failed


def test_arrays_are_views_of_the_result(run: wireloom.Run) -> None:
    handle = run._handle
    for key in ("s", "position", "force", "moment", "bend_radius"):
        first, second = (
            np.asarray(getattr(dict(handle.step(39).branches())["trunk"], key)()).ctypes.data for _ in range(2)
        )
        array = getattr(run.steps[-1].branches["trunk"], key)
        # Two handles lead to the same memory, so nothing was copied on the way.
        assert array.ctypes.data == first == second
        assert array.dtype == np.float64 and array.flags.c_contiguous and not array.flags.owndata
        assert not array.flags.writeable
        with pytest.raises(ValueError):
            array[0] = 1
        with pytest.raises(ValueError):
            array.flags.writeable = True
    branch = run.steps[-1].branches["trunk"]
    assert branch.d1.ctypes.data == branch.d1.ctypes.data and branch.d1.shape == branch.position.shape


def test_numbers_of_parts_cannot_be_written(run: wireloom.Run) -> None:
    end = run.steps[-1]
    constraint, joint = next(iter(end.constraints.values())), next(iter(end.joints.values()))
    of_constraint = (constraint.position, constraint.orientation, constraint.force, constraint.moment)
    for array in (*of_constraint, joint.position, joint.orientation):
        with pytest.raises(ValueError):
            array[0] = 1


def test_arrays_outlive_their_run() -> None:
    run = wireloom.loads(wireloom.EXAMPLE).run()
    arrays = [getattr(run.steps[0].branches["cable"], key) for key in ("position", "d3", "bend_radius")]
    copies = [array.copy() for array in arrays]
    del run
    gc.collect()
    for _ in range(5):
        wireloom.loads(wireloom.EXAMPLE).run()
    for array, copy in zip(arrays, copies, strict=True):
        assert np.array_equal(array, copy)


def test_a_folder_is_opened(first: wireloom.Scenario, tmp_path: Path) -> None:
    run = first.run()
    path = Path(run.save(tmp_path))
    for again in (wireloom.Run.open(tmp_path), wireloom.Run.open(path)):
        assert (again.status, again.verdict, again.requirements) == (run.status, run.verdict, run.requirements)
        for step, own in zip(run.steps, again.steps, strict=True):
            assert np.array_equal(own.branches["left"].position, step.branches["left"].position)
            assert np.allclose(own.branches["left"].d2, step.branches["left"].d2, atol=1e-12)
        assert Path(again.save(tmp_path / "copy")).read_bytes() == path.read_bytes()
        assert "<svg" in again.picture()
        assert again._repr_html_().startswith("<pre>")
        with pytest.raises(ValueError, match="no page"):
            again.page()
    with pytest.raises(FileNotFoundError):
        wireloom.Run.open(tmp_path / "missing")
    path.write_bytes(path.read_bytes()[:5000])
    with pytest.raises(wireloom.ResultError, match="result.json"):
        wireloom.Run.open(tmp_path)


def test_equilibria_are_read_when_they_are_asked_for(first: wireloom.Scenario, tmp_path: Path) -> None:
    first["output.increments"] = True
    first["output.fields"] = "arrow"
    run = first.run()
    path = Path(run.save(tmp_path))
    arrow = tmp_path / "fields.arrow"
    assert path.stat().st_size < arrow.stat().st_size
    again = wireloom.Run.open(tmp_path)
    assert len(again.steps) == len(run.steps) == 40 and again.steps[-1] is again.steps[39]
    for step, own in zip(run.steps, again.steps, strict=True):
        for name, branch in step.branches.items():
            for key in ("s", "position", "force", "moment", "bend_radius"):
                assert np.array_equal(getattr(branch, key), getattr(own.branches[name], key))
            # Frames of results are of unit length to 1e-9; what is read is made orthonormal, as from result.json alone.
            assert np.allclose(branch.d1, own.branches[name].d1, rtol=0, atol=1e-8)
    assert [step.increment for step in again.steps[1:4]] == [2, 3, 4]
    with pytest.raises(IndexError, match="there is no step 40: the run has 40"):
        again.steps[40]
    # What is saved is opened again.
    again.save(tmp_path / "copy")
    for name in ("result.json", "fields.arrow"):
        assert (tmp_path / "copy" / name).read_bytes() == (tmp_path / name).read_bytes()
    # The last equilibrium is damaged: the others are read.
    data = arrow.read_bytes()
    moved = np.ascontiguousarray(run.steps[-1].branches["left"].moment).tobytes()
    at = data.rindex(moved)
    arrow.write_bytes(data[:at] + b"\x00" * 8 + data[at + 8 :])
    broken = wireloom.Run.open(tmp_path)
    assert broken.status == "converged" and len(broken.steps[0].branches) == 3
    with pytest.raises(wireloom.ResultError, match="equilibrium 40 is not the one of result.json, or it is damaged"):
        broken.steps[-1]
    arrow.write_bytes(data[:1000])
    with pytest.raises(wireloom.ResultError, match="fields.arrow"):
        wireloom.Run.open(tmp_path)
    arrow.unlink()
    with pytest.raises(FileNotFoundError, match="fields.arrow"):
        wireloom.Run.open(tmp_path)


def test_pyvista_takes_an_equilibrium(run: wireloom.Run) -> None:
    pytest.importorskip("pyvista", reason="PyVista is not installed, which is large: pip install pyvista")
    mesh = run.to_pyvista()
    branches = run.steps[-1].branches
    assert mesh.n_cells == 3 and mesh.n_points == sum(len(branch) for branch in branches.values())
    assert np.array_equal(mesh.points[: len(branches["trunk"])], branches["trunk"].position)
    assert list(mesh.field_data["branches"]) == list(branches)
    lengths = mesh.compute_cell_sizes().cell_data["Length"]
    assert np.allclose(lengths, [branch.s[-1] for branch in branches.values()], rtol=1e-3)


def test_a_folder_that_cannot_be_written_is_an_os_error(run: wireloom.Run, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(OSError):
        run.save(tmp_path / "file")
    assert (tmp_path / "file").read_text() == ""


def test_the_function_sees_every_increment_and_may_stop(first: wireloom.Scenario) -> None:
    seen = []

    def look(step: wireloom.Step) -> bool:
        assert threading.current_thread() is threading.main_thread()
        seen.append((step.name, step.increment, step.branches["trunk"].position[-1].tolist()))
        return len(seen) < 5

    run = first.run(on_increment=look)
    assert [increment for _, increment, _ in seen] == [1, 2, 3, 4, 5]
    assert run.status == "interrupted" and run.verdict == "unresolved"
    assert run.steps[-1].increment == 5
    assert run.steps[-1].branches["trunk"].position[-1].tolist() == seen[-1][2]


def test_an_exception_of_the_function_ends_the_run(first: wireloom.Scenario) -> None:
    calls = []

    def fail(step: wireloom.Step) -> None:
        calls.append(step.increment)
        raise ZeroDivisionError("mine")

    with pytest.raises(ZeroDivisionError, match="mine"):
        first.run(on_increment=fail)
    assert calls == [1]


def test_progress_is_a_line(first: wireloom.Scenario, capsys: pytest.CaptureFixture[str]) -> None:
    first.run(progress=True)
    out, err = capsys.readouterr()
    assert out == "" and "step 2 of 2, plug C: increment 20 of 20" in err and err.count("\n") == 1
    first.run()
    assert capsys.readouterr() == ("", "")


def test_other_threads_go_on_during_a_run(first: wireloom.Scenario) -> None:
    for branch in ("trunk", "left", "right"):
        first[f"branches.{branch}.max_segment"] = "1 mm"
    ticks: list[float] = []
    done = threading.Event()

    def tick() -> None:
        while not done.wait(0.005):
            ticks.append(time.perf_counter())

    thread = threading.Thread(target=tick)
    thread.start()
    start = time.perf_counter()
    first.run()
    end = time.perf_counter()
    done.set()
    thread.join()
    during = [at for at in ticks if start < at < end]
    # A run that kept the GIL would leave none.
    assert len(during) > 0.1 * (end - start) / 0.005 > 2


INTERRUPTED = """
import os, signal, threading, time
import wireloom
s = wireloom.load({path!r})
for branch in ("trunk", "left", "right"):
    s[f"branches.{{branch}}.max_segment"] = "0.25 mm"
for step in (0, 1):
    s[f"steps.{{step}}.increments"] = 2000
s["output.increments"] = True
sent = []
def interrupt():
    time.sleep(1.5)
    sent.append(time.perf_counter())
    os.kill(os.getpid(), signal.SIGINT)
threading.Thread(target=interrupt).start()
try:
    s.run()
except wireloom.Interrupted as stop:
    print(time.perf_counter() - sent[0], stop.run.status, len(stop.run.steps), stop.run.verdict)
"""


def test_ctrl_c_stops_and_keeps_what_is_computed() -> None:
    code = INTERRUPTED.format(path=str(SCENARIOS / "first.toml"))
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120, check=True)
    seconds, status, steps, verdict = out.stdout.split()
    # 0.2 s where nothing else runs.
    assert float(seconds) < 1.0
    assert (status, verdict) == ("interrupted", "unresolved") and int(steps) > 0


def test_a_panic_is_an_internal_error() -> None:
    for in_thread in (False, True):
        with pytest.raises(wireloom.InternalError, match="a panic for tests"):
            _wireloom.panic_for_tests(in_thread)


def test_a_run_shows_itself_in_a_notebook(run: wireloom.Run) -> None:
    frame = run._repr_html_()
    assert frame.startswith("<iframe srcdoc=") and "sandbox" in frame
    page = run.page()
    assert page.startswith("<!") and 'id="replay">"' in page
    assert "<svg" in run.picture() and run.picture(0) != run.picture(-1)
    with pytest.raises(IndexError):
        run.picture(40)


def test_a_run_is_plotted(run: wireloom.Run) -> None:
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    ax = run.plot()
    lines = [line.get_label() for line in ax.get_lines()]
    assert lines == ["trunk", "left", "right"]


def test_a_run_is_curves_of_usd(run: wireloom.Run, tmp_path: Path) -> None:
    Usd = pytest.importorskip("pxr.Usd")
    UsdGeom = pytest.importorskip("pxr.UsdGeom")
    for ending in ("usda", "usdc", "usd"):
        path = tmp_path / f"run.{ending}"
        run.to_usd(path)
        stage = Usd.Stage.Open(str(path))
        assert UsdGeom.GetStageUpAxis(stage) == "Z" and UsdGeom.GetStageMetersPerUnit(stage) == 1.0
        assert stage.GetEndTimeCode() == len(run.steps) - 1
        harness = stage.GetDefaultPrim()
        assert harness.GetDisplayName() == run.scenario
        assert [own.GetName() for own in harness.GetChildren()] == ["trunk", "left", "right"]
        for time, step in enumerate(run.steps):
            for name, branch in step.branches.items():
                curves = UsdGeom.BasisCurves(stage.GetPrimAtPath(f"/harness/{name}"))
                points = np.array(curves.GetPointsAttr().Get(time))
                assert list(curves.GetCurveVertexCountsAttr().Get(time)) == [len(branch)]
                assert np.abs(points - branch.position).max() < 1e-7
                assert np.array(curves.GetWidthsAttr().Get(time)) == pytest.approx(branch.diameters, rel=1e-6)
    with pytest.raises(wireloom.RequestError, match="does not end with one of .usd, .usda, .usdc"):
        run.to_usd(tmp_path / "run.glb")
    with pytest.raises(OSError, match="cannot write"):
        run.to_usd(tmp_path / "no folder" / "x" / "\0.usda")


def test_events_and_requirements_are_tables_of_arrow(run: wireloom.Run) -> None:
    duckdb = pytest.importorskip("duckdb")
    scenario = wireloom.loads(wireloom.EXAMPLE)
    scenario["sections.cable.min_bend_radius"] = "400 mm"
    failed = scenario.run()
    for requirements in (run.requirements, failed.requirements):
        rows = duckdb.sql("select name, unit, worst, margin, step, increment, branch, s from requirements").fetchall()
        assert rows == [
            (
                own.name,
                own.unit,
                own.worst,
                own.margin,
                own.at and own.at.step,
                own.at and own.at.increment,
                own.place.branch,
                own.place.s,
            )
            for own in requirements
        ]
    events = failed.events
    assert len(events) > 0
    rows = duckdb.sql('select kind, worst_step, worst_increment, value, "limit", message from events').fetchall()
    assert rows == [
        (own.kind, own.worst.step, own.worst.increment, own.value, own.limit, own.message) for own in events
    ]
    assert run.events[:0] == () and list(events) == [events[k] for k in range(len(events))]

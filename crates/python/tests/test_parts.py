"""Constraints and joint models written in Python."""

import gc
import pickle
import sys
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import wireloom
from wireloom import parts

Array = Any


class Tether(parts.Constraint, kind="tether"):
    """Pulls a place of a cable to its target."""

    stiffness = parts.Number("N/m", minimum=0.0)

    def energy(self, at: parts.View) -> float:
        return 0.5 * self.stiffness * float(np.sum((at.position[0] - at.target_position[0]) ** 2))


class KnownTether(Tether, kind="known-tether"):
    """The same, with its gradient."""

    def gradient(self, at: parts.View) -> tuple[object, object]:
        force = self.stiffness * (at.position[0] - at.target_position[0])
        return [[force, np.zeros(3)]], np.zeros((0, 3))


class Straps(parts.Joint, kind="straps"):
    """Springs between all pairs of arms: the angles between them, relative to those at rest."""

    stiffness = parts.Number("N m/rad", default=0.5, minimum=0.0)

    def setup(self) -> None:
        self.first, self.second = np.triu_indices(len(self.arms), 1)
        rest = np.array([arm.rest for arm in self.arms])
        self.at_rest = np.einsum("pji,pjk->pik", rest[self.first], rest[self.second])

    def energy(self, frames: Array) -> float:
        turned = np.einsum("pji,pjk->pik", frames[self.first], frames[self.second]) - self.at_rest
        return 0.25 * self.stiffness * float(np.sum(turned**2))


class SoftHub(parts.Joint, kind="soft-hub", hub=True):
    """Springs between the arms and their hub, which is the last frame."""

    def setup(self) -> None:
        if any(arm.spring_torsion is None for arm in self.arms):
            raise ValueError("an arm has no torsion_stiffness")
        self.at_rest = np.array([arm.rest for arm in self.arms])
        self.stiffness = np.array([arm.spring_torsion for arm in self.arms])

    def energy(self, frames: Array) -> float:
        turned = np.einsum("pij,pik->pjk", frames[-1] @ self.at_rest, frames[:-1]) - np.eye(3)
        return 0.25 * float(np.sum(self.stiffness[:, None, None] * turned**2))


class TapedHub(SoftHub, kind="taped-hub", hub=True):
    """Beside these springs, an element of friction between each arm and the hub."""

    element, limit = 0.2, 0.05

    def memory(self) -> list[float]:
        return [0.0] * (3 * len(self.arms))

    def stretched(self, frames: Array) -> Array:
        """Turn of each arm beyond what has slipped."""
        turned = np.einsum("pij,pik->pjk", frames[-1] @ self.at_rest, frames[:-1])
        turns = 0.5 * np.stack([turned[:, j, i] - turned[:, i, j] for i, j in ((1, 2), (2, 0), (0, 1))], axis=1)
        return turns - self.remembered.reshape(-1, 3)

    def energy(self, frames: Array) -> float:
        d = np.linalg.norm(self.stretched(frames), axis=1)
        own = np.where(d > self.limit, self.limit * d - 0.5 * self.limit**2, 0.5 * d**2)
        return super().energy(frames) + self.element * float(np.sum(own))

    def commit(self, frames: Array) -> list[float]:
        stretched = self.stretched(frames)
        d = np.linalg.norm(stretched, axis=1, keepdims=True)
        # Above round-off, so that a second call changes nothing.
        slips = np.where(d > self.limit * (1 + 1e-10), 1 - self.limit / np.maximum(d, self.limit), 0.0)
        return list(self.remembered + (slips * stretched).ravel())


HAND = """
[[constraints]]
name = "pull"
kind = "{kind}"
at = {{ branch = "cable", s = "500 mm" }}
position = [0.4, 0.0, 0.3]
stiffness = "20 N/m"
"""


def pulled(kind: str, *own: parts.Part) -> wireloom.Scenario:
    return wireloom.loads(wireloom.EXAMPLE + HAND.format(kind=kind), parts=own)


@pytest.mark.parametrize("kind", ["tether", "known-tether"])
def test_a_tether_pulls_as_a_springy_hand_does(kind: str) -> None:
    reference = wireloom.loads(wireloom.EXAMPLE + HAND.format(kind="handle")).run()
    run = pulled(kind, Tether, KnownTether).run()
    assert (reference.status, run.status) == ("converged", "converged")
    of = lambda run: run.steps[-1].branches["cable"].position  # noqa: E731
    assert np.allclose(of(run), of(reference), rtol=0, atol=1e-7)
    force = run.steps[-1].constraints["pull"].force
    assert np.allclose(force, reference.steps[-1].constraints["pull"].force, rtol=0, atol=1e-5)
    assert np.linalg.norm(force) > 0.1


def test_a_run_says_what_is_computed_in_python() -> None:
    notes = pulled("tether", Tether).run().notes
    assert 'constraint "pull": it is computed in Python, which is slow; its derivatives are taken numerically' in notes
    known = pulled("known-tether", KnownTether).run().notes
    assert 'constraint "pull": it is computed in Python, which is slow' in known


def test_results_name_the_source(tmp_path: Any) -> None:
    import json

    pulled("tether", Tether).run().save(tmp_path)
    (plugin,) = json.loads((tmp_path / "result.json").read_text())["plugins"]
    assert plugin["name"].endswith("test_parts.Tether") and plugin["file"] == __file__ and len(plugin["hash"]) == 64


def test_a_joint_holds_the_arms(first: wireloom.Scenario) -> None:
    angles = []
    for stiffness in (0.02, 20.0):
        own = wireloom.loads(first.text, parts=[Straps])
        own["joints"] = [{"name": "J", "model": "straps", "stiffness": stiffness, "arms": first["joints.0.arms"]}]
        run = own.run()
        assert run.status == "converged"
        left, right = (run.steps[-1].branches[name].d3[0] for name in ("left", "right"))
        angles.append(float(np.arccos(left @ right)))
    run = first.run()
    left, right = (run.steps[0].branches[name].d3[0] for name in ("left", "right"))
    assert abs(angles[0] - angles[1]) > 1e-3, angles


def test_sound_parts_keep_their_contract() -> None:
    assert parts.check(Tether, stiffness=20.0) == []
    assert parts.check(KnownTether, stiffness=20.0) == []
    assert parts.check(Straps) == []


def test_a_wrong_gradient_is_found_by_the_check_and_by_a_run() -> None:
    class Doubled(KnownTether, kind="doubled"):
        """Its gradient is twice what it should be."""

        def gradient(self, at: parts.View) -> tuple[object, object]:
            stations, span = super().gradient(at)
            return 2 * np.asarray(stations), span

    (found,) = parts.check(Doubled, stiffness=20.0)
    assert found.startswith("gradient is the derivative of the energy:")
    run = pulled("doubled", Doubled).run()
    assert run.status == "failed" and run.verdict != "pass" and "pull" in (run.fault or "")


def test_a_hub_whose_arms_give_way_is_nearly_the_built_in_one() -> None:
    assert parts.check(SoftHub) == []
    shapes = []
    path = Path(__file__).parents[3] / "scenarios/branches/y_rigid_body.toml"
    for model in ["compliant-hub", "soft-hub"]:
        scenario = wireloom.load(path, parts=[SoftHub])
        scenario["joints.J.bending_stiffness"] = 5.0
        scenario["joints.J.torsion_stiffness"] = 5.0
        scenario["joints.J.model"] = model
        run = scenario.run()
        assert run.status == "converged"
        shapes.append(run.steps[-1].branches["left"].position)
    # 2 sin(φ/2) instead of φ.
    assert np.allclose(shapes[0], shapes[1], rtol=0, atol=1e-5)


def test_a_hub_remembers_what_its_arms_have_slipped() -> None:
    assert parts.check(TapedHub) == []
    text = (Path(__file__).parents[3] / "scenarios/analytic/arm_friction.toml").read_text()
    elastic = text[: text.index("[joints.arms.friction]")] + text[text.index("[[constraints]]") :]
    sets = []
    for model in [SoftHub, TapedHub]:
        own = elastic.replace("compliant-hub", model.kind).replace("1e-9", "1e-5")
        run = wireloom.loads(own, parts=[model]).run()
        assert run.status == "converged"
        sets.append(run.steps[1].branches["right"].position[-1, 2])
    assert abs(sets[0]) < 1e-4 < 1e-2 < abs(sets[1]), sets


def test_arms_of_the_built_in_hub_have_a_set() -> None:
    run = wireloom.load(Path(__file__).parents[3] / "scenarios/analytic/arm_friction.toml").run()
    hub = run.steps[1].joints["J"]
    assert list(hub.set) == list(hub.dissipated) == ["right"]
    assert np.allclose(hub.set["right"], [0, 0.118495821699, 0], rtol=0, atol=1e-7)
    assert hub.dissipated["right"][0] == 0 and abs(hub.dissipated["right"][1] - 0.00267723042805) < 1e-9


def test_a_joint_that_depends_on_the_world_is_found() -> None:
    class Upright(Straps, kind="upright"):
        """Wants to stand."""

        def energy(self, frames: Array) -> float:
            return float(1.0 - frames[0][2, 2])

    found = parts.check(Upright)
    assert any(line.startswith("a common rotation changes nothing:") for line in found)


def test_an_exception_ends_the_run_with_its_place_and_keeps_what_was_computed() -> None:
    class Breaks(Tether, kind="breaks"):
        """Fails in the second step."""

        def energy(self, at: parts.View) -> float:
            if at.target_position[0][2] > 0.31:
                raise RuntimeError("out of reach")
            return super().energy(at)

    scenario = pulled("breaks", Breaks)
    scenario["steps"] = [
        {"name": "rest", "increments": 1},
        {"name": "lift", "increments": 1, "move": [{"constraint": "pull", "position": [0.4, 0.0, 0.4]}]},
    ]
    run = scenario.run()
    assert run.status == "failed" and [step.name for step in run.steps][:1] == ["rest"]
    assert "RuntimeError: out of reach" in (run.fault or "") and "test_parts.py" in (run.fault or "")


@pytest.mark.parametrize("answer", [np.nan, np.inf, "one", None, [1.0, 2.0]])
def test_answers_that_are_no_energy_are_refused(answer: Any) -> None:
    class Odd(Tether, kind="odd"):
        """Gives something else."""

        def energy(self, at: parts.View) -> float:
            return answer  # type: ignore[no-any-return]

    with pytest.raises(wireloom.ScenarioError, match="fault of the kind \"odd\""):
        pulled("odd", Odd).run()


def test_a_gradient_of_another_shape_is_refused() -> None:
    class Short(KnownTether, kind="short"):
        """Leaves the moment out."""

        def gradient(self, at: parts.View) -> tuple[object, object]:
            return [self.stiffness * (at.position[0] - at.target_position[0])], np.zeros((0, 3))

    with pytest.raises(wireloom.ScenarioError, match=r"has shape \(1, 3\), expected \(1, 2, 3\)"):
        pulled("short", Short).run()


def test_memory_and_outputs_are_kept() -> None:
    class Ratchet(Tether, kind="ratchet"):
        """Remembers the largest stretch."""

        outputs = {"largest": "m"}

        def memory(self) -> list[float]:
            return [0.0]

        def stretch(self, at: parts.View) -> float:
            return float(np.linalg.norm(at.position[0] - at.target_position[0]))

        def commit(self, at: parts.View) -> list[float]:
            return [max(float(at.memory[0]), self.stretch(at))]

        def report(self, at: parts.View) -> dict[str, float]:
            return {"largest": max(float(at.memory[0]), self.stretch(at))}

    scenario = pulled("ratchet", Ratchet)
    move = lambda z: [{"constraint": "pull", "position": [0.4, 0.0, z]}]  # noqa: E731
    scenario["steps"] = [
        {"name": "away", "increments": 2, "move": move(0.6)},
        {"name": "back", "increments": 2, "move": move(0.0)},
    ]
    run = scenario.run()
    assert run.status == "converged"
    away, back = (step.constraints["pull"].outputs["largest"] for step in run.steps)
    assert away > 0.1 and back == away


def test_events_happen_where_report_gives_them_and_tension_is_that_of_the_results() -> None:
    class Fuse(Tether, kind="fuse"):
        """Remembers the largest tension, and tells where it is above 0.5 N."""

        outputs = {"now": "N", "largest": "N"}
        events = {"overloaded": ("the cable pulls too much", "N")}

        def memory(self) -> list[float]:
            return [0.0]

        def energy(self, at: parts.View) -> float:
            assert at.tension is None
            return super().energy(at)

        def tension(self, at: parts.View) -> float:
            assert at.tension is not None and at.tension.shape == (1, 2)
            return float(at.tension.max())

        def commit(self, at: parts.View) -> list[float]:
            return [max(float(at.memory[0]), self.tension(at))]

        def report(self, at: parts.View) -> dict[str, float]:
            now = self.tension(at)
            values = {"now": now, "largest": float(at.memory[0])}
            return {**values, "overloaded": now} if now > 0.5 else values

    scenario = pulled("fuse", Fuse)
    move = lambda z: [{"constraint": "pull", "position": [0.4, 0.0, z]}]  # noqa: E731
    scenario["steps"] = [
        {"name": "away", "increments": 2, "move": move(0.6)},
        {"name": "back", "increments": 2, "move": move(0.0)},
    ]
    run = scenario.run()
    assert run.status == "converged", run.events
    away, back = (step.constraints["pull"].outputs for step in run.steps)
    assert away["overloaded"] == away["now"] > 0.5 and "overloaded" not in back
    assert back["largest"] == away["now"]
    (event,) = [event for event in run.events if event.kind == "reported"]
    assert event.message.startswith("overloaded: the cable pulls too much, ") and event.value == away["now"]


def test_refusals_name_the_place() -> None:
    class Strict(Tether, kind="strict"):
        """Refuses soft springs."""

        def setup(self) -> None:
            if self.stiffness < 100.0:
                raise ValueError(f"too soft: {self.stiffness} N/m")

    (fault,) = pulled("strict", Strict).check()
    assert "too soft: 20.0 N/m" in fault.message and fault.line > 1
    with pytest.raises(wireloom.PartError, match="too soft"):
        parts.check(Strict, stiffness=1.0)
    soft = pulled("tether", Tether)
    soft["constraints.pull.stiffness"] = "20 kg"
    (fault,) = soft.check()
    assert "stiffness" in fault.message
    (fault,) = wireloom.loads(soft.text).check()
    assert "tether" in fault.message


def test_what_is_no_part_is_refused() -> None:
    with pytest.raises(TypeError, match="no part"):
        wireloom.loads(wireloom.EXAMPLE, parts=[dict])  # type: ignore[list-item]
    with pytest.raises(TypeError, match="has no kind"):
        wireloom.loads(wireloom.EXAMPLE, parts=[type("Nameless", (parts.Constraint,), {})])
    with pytest.raises(wireloom.RequestError, match="collar"):
        wireloom.loads(wireloom.EXAMPLE, parts=[type("Taken", (Tether,), {}, kind="collar")]).check()
    with pytest.raises(wireloom.RequestError, match="furlong"):
        odd = type("Odd", (parts.Constraint,), {"reach": parts.Number("furlong")}, kind="odd")
        wireloom.loads(wireloom.EXAMPLE, parts=[odd]).check()
    with pytest.raises(TypeError, match="stiffness"):
        parts.check(Tether)
    with pytest.raises(wireloom.RequestError, match="no value of the parameter stiffness"):
        parts.check(Tether, stiffness="20 N/m")
    with pytest.raises(wireloom.RequestError, match="no value of the parameter turns"):
        half = type("Half", (Tether,), {"turns": parts.Count(default=2.5)}, kind="half")
        wireloom.loads(wireloom.EXAMPLE, parts=[half]).check()
    with pytest.raises(TypeError, match="no parameter"):
        parts.check(Tether, stiffness=1.0, length=2.0)
    with pytest.raises(wireloom.RequestError, match="plugin"):
        wireloom.sweep(pulled("tether", Tether), into="nowhere")


def test_sessions_copies_and_pickles_have_the_parts() -> None:
    scenario = pulled("tether", Tether)
    assert pickle.loads(pickle.dumps(scenario)) == scenario == scenario.copy()
    with wireloom.Session(scenario) as session:
        before = session.state.constraints["pull"].force
        after = session.move("pull", position=[0.4, 0.0, 0.5]).constraints["pull"].force
        assert after[2] > before[2]
        assert session.scenario.run().status == "converged"


def test_threads_that_read_the_source_of_a_class_at_once_all_get_it() -> None:
    alone = Tether._origin()
    found: list[tuple[str, str, str]] = []

    def look(depth: int) -> None:
        # CPython mixes up how deep the calls of the threads are nested, so each thread nests them differently.
        if depth > 0:
            look(depth - 1)
        else:
            found.extend(Tether._origin() for _ in range(100))

    work = [threading.Thread(target=look, args=(10 * thread,)) for thread in range(4)]
    # A callback of the garbage collector is where a thread lets another one in while it parses.
    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-5)
    gc.callbacks.append(let_another_in := lambda *_: time.sleep(0.0))
    try:
        for thread in work:
            thread.start()
        for thread in work:
            thread.join(60)
    finally:
        gc.callbacks.remove(let_another_in)
        sys.setswitchinterval(interval)
    assert found == [alone] * 400


def test_runs_in_threads_do_not_wait_for_each_other_forever() -> None:
    found: list[str] = []
    work = [threading.Thread(target=lambda: found.append(pulled("tether", Tether).run().status)) for _ in range(4)]
    for thread in work:
        thread.start()
    for thread in work:
        thread.join(60)
    assert found == ["converged"] * 4

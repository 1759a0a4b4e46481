"""Derivatives, identification and optimisation."""

import _thread
import json
import math
import subprocess
import threading
from pathlib import Path

import numpy as np
import pytest
from conftest import SCENARIOS

import wireloom

STIFFNESS = "sections.cable.bending_stiffness"
LENGTH = "branches.cable.length"


def example() -> wireloom.Scenario:
    return wireloom.loads(wireloom.EXAMPLE)


def test_derivatives_are_those_of_differences_of_runs() -> None:
    s = example()
    s["minimiser"] = {"force_tolerance": 1e-11}
    found = s.sensitivities(["energy.total", "force.plug-B"], [STIFFNESS, "constraints.plug-B.position.0"])
    assert found.derivatives.shape == (2, 2) and found.sides.shape == (2, 2, 2) and not found.reasons
    assert found.parameters.tolist() == [0.01, 0.7] and not found.keeps_history

    def outputs(key: str, value: float) -> list[float]:
        other = s.copy()
        other[key] = value
        end = other.run().steps[-1]
        return [end.energy["total"], float(np.linalg.norm(end.constraints["plug-B"].force))]

    for key, value in zip(found.keys, found.parameters, strict=True):
        h = 1e-3 * value
        above, below = (np.array(outputs(key, value + side * h)) for side in (1, -1))
        assert [found[name, key] for name in found.outputs] == pytest.approx((above - below) / (2 * h), rel=1e-4)


def test_a_run_has_its_gradient(first: wireloom.Scenario) -> None:
    keys = ["branches.left.length", "sections.arm.linear_density"]
    gradient = first.run().grad("force.plug-B", keys, step="plug B")
    found = first.sensitivities(["force.plug-B"], keys, step="plug B")
    assert list(gradient) == keys and list(gradient.values()) == found.derivatives[0].tolist()


def test_where_there_is_no_derivative_there_is_a_reason(tmp_path: Path) -> None:
    s = wireloom.load(SCENARIOS / "contact/cable_on_plane.toml")
    s["constraints.plug-A.position.2"] = "10.1 mm"
    found = s.sensitivities(["energy.total"], ["obstacles.floor.point.2"])
    place = ("energy.total", "obstacles.floor.point.2")
    assert math.isnan(found[place]) and "contact changes" in found.reasons[place]
    assert np.isfinite(found.sides).sum() >= 1
    with pytest.raises(wireloom.NoAnswerError, match="contact changes"):
        s.run().grad(*place[:1], list(place[1:]))
    with pytest.raises(KeyError):
        found["energy.total", LENGTH]
    run = example().run()
    run.save(tmp_path)
    with pytest.raises(wireloom.RequestError, match="read from a file"):
        wireloom.Run.open(tmp_path).grad("energy.total", [LENGTH])


def test_tolerances_add_up() -> None:
    found = wireloom.load(SCENARIOS / "sweeps/y_tolerances.toml").sensitivities()
    assert found.outputs == ("trunk", "arm") and found.effects.shape == (2, 5) and not found.remarks
    assert found.deviations == pytest.approx(np.sqrt((found.effects**2).sum(axis=1)))
    assert found.deviations == pytest.approx([5.8e-3, 1.19e-3], rel=0.05)
    assert np.isnan(example().sensitivities(["energy.total"], [LENGTH]).deviations).all()


def test_questions_without_an_answer_are_refused() -> None:
    s = example()
    with pytest.raises(wireloom.RequestError, match="plug-X"):
        s.sensitivities(["force.plug-X"], [LENGTH])
    with pytest.raises(wireloom.RequestError, match="lenght"):
        s.sensitivities(["energy.total"], ["branches.cable.lenght"])
    with pytest.raises(TypeError, match="a list of names"):
        s.sensitivities("energy.total", [LENGTH])
    with pytest.raises(ValueError, match="either shapes or bending"):
        s.identify([STIFFNESS])
    with pytest.raises(ValueError, match="same length"):
        s.identify([STIFFNESS], shapes=[{"marker": ["A"], "x": [1.0, 2.0]}])
    with pytest.raises(TypeError, match="a list of tables"):
        s.identify([STIFFNESS], shapes={"marker": ["A"]})  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="no columns"):
        s.identify([STIFFNESS], shapes=[{}])
    with pytest.raises(TypeError, match="a pair"):
        s.identify([STIFFNESS], shapes=[{"marker": ["A"]}], priors={STIFFNESS: 0.01})  # type: ignore[dict-item]
    with pytest.raises(ValueError, match="finite"):
        s.identify([STIFFNESS], shapes=[{"marker": ["A"]}], bounds={STIFFNESS: (0.0, math.inf)})
    with pytest.raises(wireloom.RequestError, match="named twice"):
        s.sensitivities(["energy.total"], [LENGTH, LENGTH])
    with pytest.raises(wireloom.ScenarioError, match="table 0:1"):
        s.identify([STIFFNESS], shapes=[{"marker": ["A"], "w": [1.0]}])
    with pytest.raises(wireloom.RequestError, match=r"\[optimise\]"):
        s.optimise()
    s[LENGTH] = -1
    for ask in (s.sensitivities, s.optimise):
        with pytest.raises(wireloom.ScenarioError, match="length"):
            ask()


def test_a_stiffness_is_identified_from_columns(program: str, tmp_path: Path) -> None:
    s = wireloom.load(SCENARIOS / "measured/hanging.toml")
    points = SCENARIOS / "measured/hanging.csv"
    found = s.identify([STIFFNESS], shapes=[points], priors={STIFFNESS: ("0.01 N m^2", 0.05)}, noise=1e-3)
    own = found.estimates[STIFFNESS]
    assert (found.status, found.identifiable, own.identifiable) == ("converged", True, True)
    assert own.interval is not None and own.interval[0] < own.value < own.interval[1]
    assert found.scenario[STIFFNESS] == own.value and found.correlations.shape == (1, 1)
    # The same from columns, and by the command line.
    rows = [line.split(",") for line in points.read_text().splitlines() if not line.startswith("#")]
    columns = {name: [row[k] for row in rows[1:]] for k, name in enumerate(rows[0])}
    prior = {STIFFNESS: (0.01, 0.05)}
    assert s.identify([STIFFNESS], shapes=[columns], priors=prior, noise=1e-3).answer == found.answer
    command = [program, "identify", SCENARIOS / "measured/hanging.toml", "--shapes", points, "--fit", STIFFNESS]
    done = subprocess.run([*command, "--prior", f"{STIFFNESS}=0.01,0.05", "--noise", "1e-3", "--json"], capture_output=True)
    assert json.loads(done.stdout) == found.answer


def test_what_points_do_not_say_is_not_identifiable() -> None:
    points = {"configuration": ["equilibrium"], "marker": ["B"], "x": [0.7], "y": [0.0], "z": [math.nan]}
    found = example().identify([STIFFNESS], shapes=[points], noise=1e-3)
    own = found.estimates[STIFFNESS]
    assert not found.identifiable and own.value is None and own.reason


def shortest() -> wireloom.Scenario:
    return wireloom.load(SCENARIOS / "optimise/shortest_cable.toml")


def test_an_optimum_keeps_its_requirements() -> None:
    seen: list[object] = []
    found = shortest().optimise(on_design=seen.append)
    assert found.ending == "converged" and found.verdict == "pass" and found.scenario is not None
    assert len(seen) == len(found.designs) == found.counts["runs"] and seen[-1] == found.designs[-1]
    assert found.scenario.run().verdict == "pass" and found.values
    assert all(isinstance(value, float) for value in found.values.values())


def test_ctrl_c_keeps_the_best_design() -> None:
    timer = threading.Timer(0.5, _thread.interrupt_main)
    timer.start()
    with pytest.raises(wireloom.Interrupted, match="found") as caught:
        while True:
            wireloom.load(SCENARIOS / "optimise/door_loop.toml").optimise()
    timer.join()
    found = caught.value.found
    assert isinstance(found, wireloom.Optimised) and found.ending == "stopped"


def test_an_exception_of_the_function_ends_the_work() -> None:
    def fail(design: dict[str, object]) -> None:
        raise ZeroDivisionError(design["run"])

    with pytest.raises(ZeroDivisionError):
        shortest().optimise(on_design=fail)

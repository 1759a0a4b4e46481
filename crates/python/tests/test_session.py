"""Sessions."""

import threading
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import wireloom


@pytest.fixture
def session() -> wireloom.Session:
    return wireloom.Session(wireloom.loads(wireloom.EXAMPLE))


def test_motions_end_where_a_run_ends(session: wireloom.Session) -> None:
    target = [0.55, 0.2, 0.1]
    step = session.move("plug-B", position=target)
    assert step.status == "converged" and step.stable
    assert np.allclose(step.branches["cable"].position[-1], target, atol=1e-9)
    scenario = wireloom.loads(wireloom.EXAMPLE)
    scenario["steps"] = [
        {"name": "move", "increments": 3, "move": [{"constraint": "plug-B", "position": target}]},
    ]
    run = scenario.run()
    assert run.status == "converged"
    there = run.steps[-1].branches["cable"].position
    assert np.allclose(step.branches["cable"].position, there, atol=1e-5)
    assert np.allclose(step.constraints["plug-B"].force, run.steps[-1].constraints["plug-B"].force, atol=1e-3)


def test_plugs_turn(session: wireloom.Session) -> None:
    step = session.move("plug-B", tangent=[0, 1, 0])
    assert np.allclose(step.branches["cable"].d3[-1], [0, 1, 0], atol=1e-6)
    q = np.array([np.cos(0.2), 0, 0, np.sin(0.2)])
    step = session.move("plug-A", position=(0, 0, 0.1), orientation=3 * q)
    assert step.status == "converged"
    assert np.allclose(step.branches["cable"].position[0], [0, 0, 0.1], atol=1e-9)
    assert np.allclose(session.state.branches["cable"].position, step.branches["cable"].position)


def test_a_door_takes_its_plug_along_its_arc() -> None:
    path = Path(__file__).parents[3] / "scenarios/mechanisms/door.toml"
    session = wireloom.Session(wireloom.load(path))
    assert session.state.mechanisms == {"front door": {"hinge": [0.0]}}
    step = session.drive("hinge", 1)
    assert step.status == "converged" and step.mechanisms["front door"]["hinge"] == [1.0]
    # The hinge is at (0.1, 0); as drawn the plug is at (0.3, -0.02).
    (c, s), drawn = (np.cos(1), np.sin(1)), np.array([0.2, -0.02])
    there = [0.1 + np.dot([c, -s], drawn), np.dot([s, c], drawn), 0]
    assert np.allclose(step.constraints["door plug"].position, there, atol=1e-9)
    step = session.move("pillar plug", position=[0, 0, 0.02])
    scenario = session.scenario
    assert scenario["steps.2.drive.0"] == {"joint": "front door/hinge", "to": 1.0}
    assert scenario.name == str(path) and [step["name"] for step in scenario["steps"]][3] == "drag pillar plug"
    run = scenario.run()
    assert run.status == "converged"
    assert np.allclose(run.steps[-1].branches["loop"].position, step.branches["loop"].position, rtol=0, atol=1e-6)
    with pytest.raises(wireloom.RequestError, match="there is no joint \"hinges\"; known: `front door/hinge`"):
        session.drive("hinges", 0)
    with pytest.raises(wireloom.RequestError, match="not a value of a joint"):
        session.drive("hinge", np.nan)
    with pytest.raises(wireloom.ScenarioError, match="limit"):
        session.drive("hinge", 1.4)
    with pytest.raises(wireloom.RequestError, match="a mechanism carries \"door panel\""):
        session.move_obstacle("door panel", position=[0, 0, 1])
    assert session.scenario == scenario
    assert session.undo().mechanisms["front door"]["hinge"] == [1.0]
    assert session.undo().mechanisms["front door"]["hinge"] == [0.0]


def test_the_cable_is_held_and_released(session: wireloom.Session) -> None:
    before = session.state.branches["cable"].position
    held = session.hold("cable", 0.5, "hand")
    place = held.constraints["hand"].position
    step = session.move("hand", position=place + [0, 0.05, 0.02])
    assert np.allclose(step.constraints["hand"].position, place + [0, 0.05, 0.02], atol=1e-9)
    session.move("hand", position=place + [0, 0.06, 0.02])
    # Both motions are one.
    assert np.allclose(session.undo().constraints["hand"].position, place, atol=1e-9)
    step = session.release("hand")
    assert list(step.constraints) == ["plug-A", "plug-B"]
    assert [step["name"] for step in session.scenario["steps"]] == ["hold hand", "release hand"]
    assert list(session.undo().constraints) == ["plug-A", "plug-B", "hand"]
    assert np.array_equal(session.undo().branches["cable"].position, before)
    with pytest.raises(wireloom.RequestError, match="nothing to undo"):
        session.undo()


def test_a_value_is_set_and_all_steps_are_carried_out_again(session: wireloom.Session) -> None:
    target = [0.55, 0.2, 0.1]
    before = session.move("plug-B", position=target)
    step = session.set("sections.cable.bending_stiffness", np.array([0.03, 0.04]))
    assert np.allclose(step.branches["cable"].position[-1], target, atol=1e-9)
    assert not np.allclose(step.branches["cable"].position, before.branches["cable"].position, atol=1e-4)
    assert session.scenario["sections.cable.bending_stiffness"] == [0.03, 0.04]
    for fault, key, value in (
        (KeyError, "sections.nothing.there", 1),
        (TypeError, "name", object()),
        (ValueError, "branches.cable.length", np.nan),
        (wireloom.ScenarioError, "branches.cable.length", "900 kg"),
        (wireloom.ScenarioError, "plugins.load", ["own.so"]),
    ):
        with pytest.raises(fault):
            session.set(key, value)
    assert np.array_equal(session.undo().branches["cable"].position, before.branches["cable"].position)


def test_obstacles_move() -> None:
    scenario = wireloom.loads(wireloom.EXAMPLE)
    box = {"name": "box", "shape": "box", "size": [0.1, 0.1, 0.02], "position": [0.35, 0, -0.6], "friction": 0.5}
    scenario["obstacles"] = [box]
    session = wireloom.Session(scenario)
    lowest = session.state.branches["cable"].position[20, 2]
    step = session.move_obstacle("box", position=[0.35, 0, lowest + 0.02], orientation=[1, 0, 0, 0.02])
    # The cable lies on the box.
    assert step.branches["cable"].position[20, 2] > lowest + 0.03
    there = session.scenario.run().steps[-1].branches["cable"].position
    assert np.allclose(there, step.branches["cable"].position, rtol=0, atol=1e-6)


def test_a_motion_that_fails_stays_in_the_last_equilibrium_on_its_way() -> None:
    scenario = wireloom.loads(wireloom.EXAMPLE)
    scenario["obstacles"] = [{"name": "box", "shape": "box", "size": [0.2, 0.2, 0.2], "position": [0.7, 0, 0.45]}]
    session = wireloom.Session(scenario)
    with pytest.raises(wireloom.RequestError, match="the harness is in the last equilibrium on the way"):
        session.move("plug-B", position=[0.7, 0, 0.9])
    stays = session.state.branches["cable"].position
    assert np.allclose(stays[-1], [0.7, 0, 0.3], atol=1e-9)
    assert np.allclose(session.scenario.run().steps[-1].branches["cable"].position, stays, rtol=0, atol=1e-6)


def test_earlier_equilibria_stay_what_they_were(session: wireloom.Session) -> None:
    before = session.state.branches["cable"].position
    copy = before.copy()
    session.move("plug-B", position=[0.5, 0, 0])
    session.close()
    del session
    assert np.array_equal(before, copy)


@pytest.mark.parametrize(
    ("name", "target", "words"),
    [
        ("plug-X", {"position": [0, 0, 0]}, "no constraint"),
        ("plug-B", {}, "empty"),
        ("plug-B", {"position": [np.nan, 0, 0]}, "not a valid position"),
        ("plug-B", {"position": [1e9, 0, 0]}, "not a valid position"),
        ("plug-B", {"orientation": [0, 0, 0, 0]}, "not an orientation"),
        ("plug-B", {"orientation": [np.inf, 0, 0, 0]}, "not an orientation"),
        ("plug-B", {"tangent": [0, 0, 0]}, "not a direction"),
        ("plug-B", {"tangent": [1, 0, 0], "orientation": [1, 0, 0, 0]}, "both given"),
    ],
)
def test_a_wrong_target_is_refused_and_changes_nothing(
    session: wireloom.Session, name: str, target: dict[str, list[float]], words: str
) -> None:
    before = session.state.branches["cable"].position
    with pytest.raises(wireloom.RequestError, match=words):
        session.move(name, **target)
    assert np.array_equal(session.state.branches["cable"].position, before)
    assert session.move("plug-B", position=[0.69, 0, 0]).status == "converged"


def test_a_closed_session_says_so(session: wireloom.Session) -> None:
    session.close()
    session.close()
    uses: list[Callable[[], object]] = [
        lambda: session.state,
        lambda: session.constraints,
        lambda: session.scenario,
        lambda: session.move("plug-B", position=[0, 0, 0]),
        lambda: session.hold("cable", 0.5, "hand"),
        lambda: session.release("plug-B"),
        lambda: session.drive("hinge", 0),
        lambda: session.move_obstacle("box", position=[0, 0, 0]),
        lambda: session.set("branches.cable.length", 1),
        session.undo,
    ]
    for use in uses:
        with pytest.raises(wireloom.ClosedError):
            use()


@pytest.mark.parametrize(
    ("use", "fault", "words"),
    [
        (lambda session: session.hold("cables", 0.5, "hand"), wireloom.RequestError, "did you mean `cable`"),
        (lambda session: session.hold("cable", 1.5, "hand"), wireloom.RequestError, "outside branch"),
        (lambda session: session.hold("cable", 0.5, "plug-A"), wireloom.ScenarioError, "plug-A"),
        (lambda session: session.release("plug-X"), wireloom.RequestError, "no constraint"),
        (lambda session: session.drive("hinge", 0), wireloom.RequestError, "there is no joint"),
        (lambda session: session.move_obstacle("box", position=[0, 0, 0]), wireloom.RequestError, "no obstacle"),
        (lambda session: session.move_obstacle("box", position=[0, 0]), ValueError, "3 numbers"),
    ],
)
def test_what_is_refused_ends_no_motion(
    session: wireloom.Session, use: Callable[[wireloom.Session], object], fault: type[Exception], words: str
) -> None:
    session.move("plug-B", position=[0.55, 0.1, 0])
    with pytest.raises(fault, match=words):
        use(session)
    session.move("plug-B", position=[0.55, 0.2, 0])
    assert [step["name"] for step in session.scenario["steps"]] == ["drag plug-B"]


def test_a_scenario_with_faults_opens_no_session() -> None:
    with pytest.raises(wireloom.ScenarioError):
        wireloom.Session(wireloom.loads("schema = 1"))


def test_threads_share_a_session(session: wireloom.Session) -> None:
    faults: list[BaseException] = []

    def drag(y: float) -> None:
        try:
            for k in range(20):
                step = session.move("plug-B", position=[0.7, y, 0.001 * k])
                assert abs(step.branches["cable"].position[-1, 1] - y) < 1e-9
        except BaseException as error:
            faults.append(error)

    threads = [threading.Thread(target=drag, args=(0.01 * k,)) for k in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert faults == []

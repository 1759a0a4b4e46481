"""Sessions."""

import threading

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
    for use in (lambda: session.state, lambda: session.constraints, lambda: session.move("plug-B", position=[0, 0, 0])):
        with pytest.raises(wireloom.ClosedError):
            use()


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

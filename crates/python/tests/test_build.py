"""Scenarios that are built in Python."""

import numpy as np
import pytest

import wireloom


def built() -> wireloom.Harness:
    """The harness of the README, with a step of each kind."""
    h = wireloom.Harness("y-harness", output={"increments": True})
    for name, diameter, density, stretch, bend in (
        ("trunk", "8 mm", "120 g/m", 2.0e4, 0.012),
        ("arm", "5 mm", "60 g/m", 1.0e4, 0.006),
    ):
        h.section(
            name, diameter=diameter, linear_density=density, axial_stiffness=stretch, bending_stiffness=bend,
            torsion_stiffness=0.75 * bend,
        )
    h.branch("trunk", "A", "J", section="trunk", length="600 mm", segments=60)
    h.branch("left", "J", "B", section="arm", length=0.4, segments=40)
    h.branch("right", "J", "C", section="arm", length=0.4, max_segment="10 mm")
    arms = {"trunk": [-1, 0, 0], "left": np.array([0.866, 0.5, 0.0]), "right": (0.866, -0.5, 0.0)}
    h.joint("J", arms, wires={("trunk", "left"): 0.5, ("trunk", "right"): 0.5})
    straight = {"tangent": [1, 0, 0], "up": [0, 0, 1]}
    h.connector("plug-A", end="A", position=[0, 0, 0], **straight)
    h.connector("plug-C", end="C", position=[0.85, -0.25, 0], **straight)
    h.handle("hand", branch="left", s=0.2)
    h.load("tool", joint="J", force=[0, 0, -2.0], factor=0)
    h.marker("m1", branch="trunk", s="300 mm")
    h.requirement("reach", "force", max="500 N", of={"constraint": "plug-A"})
    plug = h.step("plug B", increments=3)
    plug.connector("plug-B", end="B")
    plug.move("plug-B", position=[0.85, 0.25, 0], **straight)
    off = h.step("tool on, hand off", increments=2)
    off.release("hand")
    off.load("tool", 1.0)
    return h


def test_what_is_built_is_the_document_of_a_file() -> None:
    s = built().scenario()
    assert s.check() == [], s.text
    assert s["branches.right.max_segment"] == "10 mm" and s["branches.left.from"] == "J"
    assert s["joints.J.arms.1.direction"] == [0.866, 0.5, 0.0]
    assert s["steps"][0]["add"] == [{"name": "plug-B", "kind": "connector", "at": {"end": "B"}}]
    assert s["steps"][1]["release"] == ["hand"]
    run = s.run()
    assert run.status == "converged" and len(run.steps) == 5
    assert "hand" not in run.steps[-1].constraints and "m1" in run.steps[-1].markers
    # The same text, read again, is the same run.
    again = wireloom.loads(s.text).run()
    assert np.array_equal(again.steps[-1].branches["left"].position, run.steps[-1].branches["left"].position)


def test_faults_are_those_of_a_file() -> None:
    h = built()
    h.branch("tail", "B", "D", section="arms", length=-1.0, segments=4, hue="red")
    said = " ".join(str(fault) for fault in h.scenario().check())
    for part in ("hue", "arms", "-1"):
        assert part in said, said


def test_later_calls_do_not_change_a_scenario() -> None:
    h = built()
    before = h.scenario()
    text = before.text
    h.step("more").release("plug-C")
    assert before.text == text != h.scenario().text


@pytest.mark.parametrize("place", [{}, {"end": "A", "joint": "J"}, {"branch": "left"}, {"end": "A", "s": 0.1}])
def test_one_place_is_given(place: dict[str, object]) -> None:
    with pytest.raises(ValueError, match="give one place"):
        wireloom.Harness("h").handle("hand", **place)
    with pytest.raises(ValueError, match="give one place"):
        wireloom.Harness("h").load("load", force=[0, 0, 1], **place)  # type: ignore[arg-type]

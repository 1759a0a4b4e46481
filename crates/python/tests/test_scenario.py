"""Scenarios: their text, their faults."""

import copy
import pickle
import subprocess
from pathlib import Path

import numpy as np
import pytest

import wireloom

from conftest import SCENARIOS


def test_values_change_and_comments_stay(first: wireloom.Scenario) -> None:
    before = first.text
    first["sections.trunk.bending_stiffness"] = 0.02
    assert first["sections.trunk.bending_stiffness"] == 0.02
    changed = [(a, b) for a, b in zip(before.splitlines(), first.text.splitlines(), strict=True) if a != b]
    assert changed == [('bending_stiffness = "0.012 N m^2"', "bending_stiffness = 0.02")]
    assert first.check() == []


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("branches.left.length", "410 mm"),
        ("branches.0.length", 0.61),
        ("constraints.plug-A.position.2", 0.01),
        ("constraints.plug-A.tangent", [0.0, 1.0, 0.0]),
        ("sections.arm.bending_stiffness", [0.006, 0.007]),
        ("minimiser", {"kind": "lbfgs", "max_iterations": 500}),
        ('steps."plug B".increments', 3),
        ("output.increments", True),
    ],
)
def test_values_of_every_form_are_read_back(first: wireloom.Scenario, key: str, value: object) -> None:
    first[key] = value
    assert first[key] == value
    assert first.check() == []


def test_arrays_of_numpy_are_values(first: wireloom.Scenario) -> None:
    first["constraints.plug-A.position"] = np.array([0.0, 0.0, 0.25])
    first["steps.0.increments"] = np.int64(4)
    first["branches.left.length"] = np.float32(0.5)
    assert first["constraints.plug-A.position"] == [0.0, 0.0, 0.25]
    assert first["steps.0.increments"] == 4
    assert first.check() == []


def test_a_key_that_leads_nowhere_is_a_key_error(first: wireloom.Scenario) -> None:
    for key in ["nothing", "branches.middle.length", "branches.7.length", "", "a..b", "name.x"]:
        with pytest.raises(KeyError):
            first[key]
    for key in ["branches.middle.length", "branches.7.length", "", "a..b", "name.x"]:
        with pytest.raises(KeyError):
            first[key] = 1
    with pytest.raises(TypeError, match="object is no value"):
        first["name"] = object()
    with pytest.raises(ValueError, match="not JSON compliant"):
        first["branches.left.length"] = float("nan")
    with pytest.raises(KeyError, match="nothing"):
        first["name"] = None
    assert first == wireloom.load(SCENARIOS / "first.toml")


def test_a_fault_has_its_place_and_a_suggestion(first: wireloom.Scenario) -> None:
    first["sections.trunk.bending_stifness"] = 1
    (fault,) = first.check()
    line = first.text.splitlines()[fault.line - 1]
    assert line[fault.column - 1 :].startswith("bending_stifness")
    assert "bending_stifness" in fault.message and fault.suggestion == "did you mean `bending_stiffness`?"


def test_a_refusal_prints_what_the_command_line_prints(program: str) -> None:
    seen = 0
    for path in sorted((SCENARIOS / "refused").glob("*.toml")):
        if "plugins" in path.read_text():
            continue
        out = subprocess.run([program, "check", path], capture_output=True, text=True, check=False)
        with pytest.raises(wireloom.ScenarioError) as refused:
            wireloom.load(path).run()
        assert str(refused.value) == out.stderr.rstrip("\n"), path
        assert "\n".join(map(str, refused.value.diagnostics)) in str(refused.value)
        seen += 1
    assert seen > 50


def test_files_beside_the_scenario_are_found() -> None:
    path = SCENARIOS / "assembly" / "carry_together.toml"
    assert wireloom.load(path).check() == []
    text = path.read_text(encoding="utf-8")
    assert wireloom.loads(text, folder=path.parent).check() == []
    without = wireloom.loads(text).check()
    assert without and any("folder" in fault.message for fault in without), without


def test_plugins_are_refused_and_not_ignored() -> None:
    text = '[plugins]\nload = ["strap"]\n' + wireloom.EXAMPLE
    (fault,) = wireloom.loads(text.replace("schema = 1\n", "", 1) + "\n").check()
    assert "does not load plugins" in fault.message and fault.line == 2


def test_scenarios_are_copied_and_pickled(first: wireloom.Scenario) -> None:
    for other in (first.copy(), copy.copy(first), copy.deepcopy(first), pickle.loads(pickle.dumps(first))):
        assert other == first
        other["name"] = "other"
        assert other != first and first["name"] == "y-harness"


def test_a_text_is_saved_and_loaded(first: wireloom.Scenario, tmp_path: Path) -> None:
    first["name"] = "Größe"
    first.save(tmp_path / "s.toml")
    assert wireloom.load(tmp_path / "s.toml").text == first.text
    (tmp_path / "latin.toml").write_bytes(b"name = '\xe9'")
    with pytest.raises(ValueError, match="latin.toml:1: not UTF-8"):
        wireloom.load(tmp_path / "latin.toml")
    with pytest.raises(FileNotFoundError, match="missing.toml"):
        wireloom.load(tmp_path / "missing.toml")
    with pytest.raises((ValueError, OSError)):
        wireloom.load(tmp_path)


def test_errors_are_pickled(first: wireloom.Scenario) -> None:
    first["name"] = 3
    with pytest.raises(wireloom.ScenarioError) as refused:
        first.run()
    again = pickle.loads(pickle.dumps(refused.value))
    assert str(again) == str(refused.value) and again.diagnostics == refused.value.diagnostics


def test_a_dict_becomes_the_same_document(first: wireloom.Scenario) -> None:
    keys = ["schema", "name", "sections", "branches", "joints", "constraints", "steps"]
    document = {key: first[key] for key in keys}
    other = wireloom.from_dict(document)
    assert other.check() == [] and {key: other[key] for key in keys} == document
    one, two = first.run(), other.run()
    assert np.array_equal(one.steps[-1].branches["left"].position, two.steps[-1].branches["left"].position)


def test_every_string_and_number_survives() -> None:
    document = {
        "name": 'a "quoted" \\ \t\n\x00\x1b\x7f\u2028 Größe 𝛼',
        "dotted.key": {"a b": {"": 1, "ö": [1e-300, -0.0, 1.5, 2**63 - 1, True]}},
        "empty": {},
        "list": [],
        "mixed": [{"a": {}}, 1],
        "tables": [{"a": [{"b": np.arange(3)}]}, {}],
    }
    scenario = wireloom.from_dict(document)
    assert scenario["name"] == document["name"]
    assert scenario['"dotted.key"."a b"."ö"'] == [1e-300, -0.0, 1.5, 2**63 - 1, True]
    assert scenario["tables"] == [{"a": [{"b": [0, 1, 2]}]}, {}]
    assert scenario["mixed"] == [{"a": {}}, 1] and scenario["empty"] == {} and scenario["list"] == []
    cyclic: list[object] = []
    cyclic.append(cyclic)
    for wrong in (None, float("inf"), 2**63, object(), {1: 2}, b"x", cyclic, "\ud800", {"x": None}):
        with pytest.raises((TypeError, ValueError)):
            wireloom.from_dict({"a": wrong})
    with pytest.raises(TypeError):
        wireloom.from_dict([1])  # type: ignore[arg-type]

"""Thousands of wrong calls: each is an exception of Python, none ends the interpreter."""

import random
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import wireloom
from wireloom import _wireloom

CALLS = 10_000

VALUES: list[Any] = [
    None,
    True,
    0,
    -1,
    2**70,
    1e308,
    float("nan"),
    float("inf"),
    "",
    "plug-B",
    "cable",
    "sections.cable.diameter",
    "a\0b",
    "\ud800",
    "ä" * 1000,
    b"bytes",
    [],
    [1, 2],
    [0.6, 0.0, 0.0],
    [float("nan")] * 3,
    [[1, 2, 3]],
    (),
    {},
    {"a": {"b": [1, None]}},
    {1: 2},
    {1, 2},
    object(),
    object,
    lambda *_: None,
    np.zeros(3),
    np.full(3, np.nan),
    np.zeros((3, 3)),
    np.zeros(0),
    np.array(["x", "y", "z"]),
    np.array([1 + 2j, 0, 0]),
    np.zeros(3, dtype=object),
]


# Complex numbers on the way to the compiled part.
@pytest.mark.filterwarnings("ignore:Casting complex values")
def test_wrong_calls_are_exceptions(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # Some calls write files.
    monkeypatch.chdir(tmp_path)
    rng = random.Random(7)
    run = wireloom.loads(wireloom.EXAMPLE).run()
    session = wireloom.Session(wireloom.loads(wireloom.EXAMPLE))
    closed = wireloom.Session(wireloom.loads(wireloom.EXAMPLE))
    closed.close()
    source = (wireloom.EXAMPLE, "x.toml", None)
    lengths = '[sweep.vary]\n"branches.cable.length" = { from = "0.9 m", to = "1.1 m", count = 3 }'
    swept = (wireloom.EXAMPLE + lengths, "x.toml", None)
    step = run.steps[-1]
    branch = step.branches["cable"]

    def value() -> Any:
        return rng.choice(VALUES)

    def scenario() -> wireloom.Scenario:
        return wireloom.loads(wireloom.EXAMPLE)

    calls: list[Callable[[], object]] = [
        lambda: wireloom.load(value()),
        lambda: wireloom.loads(value()).check(),
        lambda: wireloom.loads(wireloom.EXAMPLE, name=value(), folder=value()).check(),
        lambda: scenario()[value()],
        lambda: value() in scenario(),
        lambda: wireloom.from_dict(value()),
        lambda: wireloom.from_dict({"a": value(), "name": value()}).check(),
        lambda: scenario().__setitem__(value(), value()),
        lambda: scenario().__setitem__("branches.cable.length", value()),
        lambda: scenario().run(on_increment=value(), progress=False),
        lambda: wireloom.Session(value()),
        lambda: session.move(value(), position=value()),
        lambda: session.move("plug-B", position=value(), orientation=value(), tangent=value()),
        lambda: closed.move("plug-B", position=value()),
        lambda: closed.state,
        lambda: run.save(value()),
        lambda: run.picture(value()),
        lambda: wireloom.Run.open(value()),
        lambda: run.steps[value()],
        lambda: step.branches[value()],
        lambda: step.constraints[value()],
        lambda: branch._handle.director(value()),
        lambda: np.asarray(branch._handle.director(2)),
        lambda: run._handle.picture(value()),
        lambda: _wireloom.run(value(), value(), value()),
        lambda: _wireloom.run(source, value(), value()),
        lambda: _wireloom.check(value()),
        lambda: _wireloom.with_value(source, value(), value()),
        lambda: _wireloom.value_at(source, value()),
        lambda: _wireloom.Session(value()),
        lambda: session._handle.move(value(), value(), value(), value()),
        lambda: wireloom.sweep(scenario(), value(), client=value(), columns=value(), points=value()),
        lambda: wireloom.sweep(value(), "parts", columns=value()),
        lambda: wireloom.slurm(scenario(), value(), value(), columns=value(), points=value(), jobs=value()),
        lambda: wireloom.Sweep(value()).status(),
        lambda: wireloom.Sweep(value()).compact(),
        lambda: _wireloom.sweep_part((source, value(), value(), value()), value(), value(), value()),
        lambda: _wireloom.sweep_part((swept, None, "parts", None), value(), value(), value()),
        lambda: _wireloom.sweep_begin((swept, None, value(), value()), value()),
        lambda: wireloom.Branch("x", value()).position,
        lambda: wireloom.Run(value()).steps,
        lambda: wireloom.Interrupted(value()),
        lambda: wireloom.ScenarioError(value(), value()),
    ]
    faults: list[str] = []

    def hurt(count: int) -> None:
        for _ in range(count):
            try:
                rng.choice(calls)()
            except Exception as error:
                if isinstance(error, wireloom.InternalError):
                    faults.append(repr(error))
            except BaseException as error:
                # Such as the exception of a panic.
                faults.append(repr(error))

    threads = [threading.Thread(target=hurt, args=(CALLS // 8,)) for _ in range(4)]
    for thread in threads:
        thread.start()
    hurt(CALLS // 2)
    for thread in threads:
        thread.join()
    assert faults == []
    # The session still works.
    assert session.move("plug-B", position=[0.65, 0, 0]).status == "converged"
    assert session.state.branches["cable"].position.shape == (41, 3)

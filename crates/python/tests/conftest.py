"""What the tests share."""

import os
import signal
from pathlib import Path

import pytest

import wireloom

# A shell that starts the tests in the background has them ignore Ctrl-C, and those that send it would wait for ever.
signal.signal(signal.SIGINT, signal.default_int_handler)

SCENARIOS = Path(__file__).resolve().parents[3] / "scenarios"


@pytest.fixture
def first() -> wireloom.Scenario:
    """The Y harness of the README."""
    return wireloom.load(SCENARIOS / "first.toml")


@pytest.fixture(scope="session")
def run() -> wireloom.Run:
    """Its run, with all increments."""
    scenario = wireloom.load(SCENARIOS / "first.toml")
    scenario["output.increments"] = True
    return scenario.run()


@pytest.fixture
def program() -> str:
    """The command line."""
    path = os.environ.get("WIRELOOM")
    if path is None:
        pytest.skip("WIRELOOM does not name the program wireloom, which results are compared with")
    return path

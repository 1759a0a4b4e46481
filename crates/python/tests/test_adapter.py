"""The adapter for cosseratbench: its static experiments, and what is refused of the others."""

import pytest

pytest.importorskip("cosseratbench", reason="cosseratbench is not installed: pip install cosseratbench")

from cosseratbench.registry import load_experiment
from wireloom._cosseratbench import WireloomSolver


def test_the_cantilever_is_that_of_beam_theory() -> None:
    """Shear and large deflection, which the reference leaves out, change it by less than 0.1 % each, as the suite says."""
    experiment = load_experiment("cantilever")
    trajectory = WireloomSolver().run(experiment.scenario, n_elements=20, n_frames=11)
    metrics = {name: metric(experiment.scenario, trajectory) for name, metric in experiment.metrics.items()}
    assert metrics["tip_deflection_error"] < 2e-3 and metrics["settling_residual"] == 0.0


@pytest.mark.parametrize(("span", "most"), [(0.6, 0.02), (0.8, 0.003), (0.95, 0.003)])
@pytest.mark.parametrize("modulus", [1e5, 1e6])
def test_the_catenary_hangs_as_the_elastic_catenary_does(modulus: float, span: float, most: float) -> None:
    """The reference has no bending stiffness: the suite quotes up to 1 % for that at a span of 0.6."""
    experiment = load_experiment("catenary")
    scenario = experiment.scenario_for(youngs_modulus=modulus, span=span)
    trajectory = WireloomSolver().run(scenario, n_elements=50, n_frames=5)
    metrics = {name: metric(scenario, trajectory) for name, metric in experiment.metrics.items()}
    assert metrics["shape_error"] < most and metrics["sag_error"] < most, metrics


@pytest.mark.parametrize(
    ("name", "reason"),
    [("pendulum", "motions"), ("twist", "several rods"), ("capstan", "obstacles")],
)
def test_what_is_not_static_is_refused_with_its_reason(name: str, reason: str) -> None:
    with pytest.raises(NotImplementedError, match=reason):
        WireloomSolver().run(load_experiment(name).scenario, n_elements=20, n_frames=11)

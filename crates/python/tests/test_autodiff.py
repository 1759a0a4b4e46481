"""Own constraints whose gradient JAX or PyTorch derives."""

from typing import Any

import numpy as np
import pytest

import wireloom
from wireloom import parts

HAND = """
[[constraints]]
name = "pull"
kind = "{kind}"
at = {{ branch = "cable", s = "500 mm" }}
position = [0.3, 0.05, -0.25]
stiffness = "20 N/m"
"""


def jax_tether() -> type[parts.Constraint]:
    """A springy hand whose gradient is that of `jax.grad`."""
    jax = pytest.importorskip("jax", reason="JAX is not installed: pip install jax")
    jax.config.update("jax_enable_x64", True)
    energy = jax.jit(lambda x, target, stiffness: 0.5 * stiffness * jax.numpy.sum((x - target) ** 2))
    slope = jax.jit(jax.grad(energy))

    class JaxTether(parts.Constraint, kind="jax-tether"):
        """Pulls a place of a cable to its target."""

        stiffness = parts.Number("N/m", minimum=0.0)

        def energy(self, at: parts.View) -> float:
            return float(energy(at.position[0], at.target_position[0], self.stiffness))

        def gradient(self, at: parts.View) -> tuple[object, object]:
            force = np.asarray(slope(at.position[0], at.target_position[0], self.stiffness))
            return [[force, np.zeros(3)]], np.zeros((0, 3))

    return JaxTether


def torch_tether() -> type[parts.Constraint]:
    """The same with `torch.autograd`."""
    torch = pytest.importorskip("torch", reason="PyTorch is not installed, which is large: pip install torch")

    class TorchTether(parts.Constraint, kind="torch-tether"):
        """Pulls a place of a cable to its target."""

        stiffness = parts.Number("N/m", minimum=0.0)

        def of(self, at: parts.View) -> tuple[Any, Any]:
            x = torch.tensor(np.array(at.position[0]), dtype=torch.float64, requires_grad=True)
            target = torch.tensor(np.array(at.target_position[0]), dtype=torch.float64)
            return x, 0.5 * self.stiffness * torch.sum((x - target) ** 2)

        def energy(self, at: parts.View) -> float:
            return float(self.of(at)[1])

        def gradient(self, at: parts.View) -> tuple[object, object]:
            x, energy = self.of(at)
            energy.backward()
            return [[x.grad.numpy(), np.zeros(3)]], np.zeros((0, 3))

    return TorchTether


@pytest.mark.parametrize("make", [jax_tether, torch_tether])
def test_a_derived_gradient_is_that_of_a_springy_hand(make: Any) -> None:
    own = make()
    assert parts.check(own, stiffness=20.0) == []
    kind = "jax-tether" if make is jax_tether else "torch-tether"
    run = wireloom.loads(wireloom.EXAMPLE + HAND.format(kind=kind), parts=[own]).run()
    reference = wireloom.loads(wireloom.EXAMPLE + HAND.format(kind="handle")).run()
    assert (run.status, reference.status) == ("converged", "converged")
    force, expected = (one.steps[-1].constraints["pull"].force for one in (run, reference))
    assert np.linalg.norm(expected) > 0.1
    # Both runs are converged to 1e-6 of the loads.
    assert np.allclose(force, expected, rtol=0, atol=1e-5)

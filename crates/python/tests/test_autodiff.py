"""Own constraints whose gradient JAX or PyTorch derives; results that they differentiate."""

from typing import Any

import numpy as np
import pytest
from conftest import SCENARIOS

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
            return float(self.of(at)[1].detach())

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


OF = ["energy.total", "force.plug-B"]
BY = ["sections.cable.bending_stiffness", "branches.cable.length", "constraints.plug-B.position.2"]
AT = [0.012, 1.0, 0.05]


def scenario() -> wireloom.Scenario:
    """One whose equilibria are exact enough for differences of runs."""
    return wireloom.loads(wireloom.EXAMPLE + "\n[minimiser]\nforce_tolerance = 1e-10\n")


def test_jax_differentiates_results() -> None:
    jax = pytest.importorskip("jax", reason="JAX is not installed: pip install jax")
    from jax.test_util import check_grads

    jax.config.update("jax_enable_x64", True)
    s = scenario()
    function, at = s.jax_function(OF, BY), jax.numpy.array(AT)
    check_grads(function, (at,), order=1, modes=["rev"], eps=1e-5, atol=1e-4, rtol=1e-4)
    # Compiled, and one after the other.
    slopes = jax.jit(jax.jacrev(function))(at)
    for key, value in zip(BY, AT, strict=True):
        s[key] = value
    assert np.allclose(slopes, s.sensitivities(OF, BY).derivatives, rtol=1e-9, atol=1e-12)
    both = jax.vmap(function)(jax.numpy.stack([at, at * 1.01]))
    assert both.shape == (2, 2) and np.allclose(both[0], function(at), rtol=1e-12)
    assert jax.grad(lambda x: function(x)[0])(at.astype("float32")).dtype == "float32"
    with pytest.raises(ValueError, match=r"shape \(3,\) are wanted"):
        function(at[:2])
    with pytest.raises(Exception, match="force.plug-X"):
        s.jax_function(["force.plug-X"], BY)(at).block_until_ready()


def test_torch_differentiates_results() -> None:
    torch = pytest.importorskip("torch", reason="PyTorch is not installed, which is large: pip install torch")
    function = scenario().torch_function(OF, BY)
    at = torch.tensor(AT, dtype=torch.float64, requires_grad=True)
    assert torch.autograd.gradcheck(function, (at,), eps=1e-5, atol=1e-4, rtol=1e-4)
    with pytest.raises(ValueError, match=r"shape \(3,\) are wanted"):
        function(at[:2])
    with pytest.raises(TypeError, match="floating point"):
        function(torch.tensor([1, 1, 1]))
    with pytest.raises(wireloom.RequestError, match="force.plug-X"):
        scenario().torch_function(["force.plug-X"], BY)(at)


def test_where_there_is_no_derivative_none_is_taken() -> None:
    jax = pytest.importorskip("jax", reason="JAX is not installed: pip install jax")
    jax.config.update("jax_enable_x64", True)
    s = wireloom.load(SCENARIOS / "contact/cable_on_plane.toml")
    # Here contact changes.
    s["constraints.plug-A.position.2"] = "10.1 mm"
    function = s.jax_function(["energy.total"], ["obstacles.floor.point.2"])
    at = jax.numpy.zeros(1)
    assert np.isfinite(function(at)).all()
    with pytest.raises(Exception, match=r"energy.total has no derivative by obstacles.floor.point.2 here"):
        jax.jacrev(function)(at).block_until_ready()

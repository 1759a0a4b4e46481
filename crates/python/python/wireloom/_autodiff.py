"""Results of a scenario as functions of its numbers, which JAX and PyTorch differentiate."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ._errors import NoAnswerError

if TYPE_CHECKING:
    from ._scenario import Scenario

Array = npt.NDArray[np.float64]


class Outputs:
    """Outputs of a scenario at the end of a step, with other numbers at some of its keys."""

    def __init__(self, scenario: Scenario, of: Sequence[str], by: Sequence[str], step: str | None) -> None:
        for name, given in (("of", of), ("by", by)):
            if isinstance(given, str) or not given:
                raise TypeError(f"{name} is a list of at least one name")
        self.scenario, self.of, self.by, self.step = scenario.copy(), tuple(of), tuple(by), step

    def __call__(self, numbers: Array) -> tuple[Array, Array]:
        """Values, shape (outputs,), and derivatives, shape (outputs, keys), not-a-number where there is none."""
        changed = self.scenario.copy()
        for key, number in zip(self.by, numbers, strict=True):
            changed[key] = float(number)
        found = changed.sensitivities(self.of, self.by, step=self.step)
        for name, value in zip(found.outputs, found.values, strict=True):
            if np.isnan(value):
                raise NoAnswerError(f"{name} has no value in step {found.step}")
        return found.values, found.derivatives

    def differentiable(self, numbers: Array) -> tuple[Array, Array]:
        """The same, where all derivatives exist."""
        values, derivatives = self(numbers)
        for name, row in zip(self.of, derivatives, strict=True):
            for key, derivative in zip(self.by, row, strict=True):
                if np.isnan(derivative):
                    raise NoAnswerError(f"{name} has no derivative by {key} here: see Scenario.sensitivities")
        return values, derivatives

    def check_shape(self, shape: Sequence[int]) -> None:
        """Refuses numbers of another shape than the keys have."""
        if tuple(shape) != (len(self.by),):
            raise ValueError(f"numbers of shape ({len(self.by)},) are wanted, one for each key, not {tuple(shape)}")


def jax_function(outputs: Outputs) -> Callable[[Any], Any]:
    """A function for JAX, from numbers to values."""
    import jax
    import jax.numpy as jnp

    def call(function: Callable[[Array], tuple[Array, Array]], numbers: Any, *shapes: tuple[int, ...]) -> Any:
        def on_host(numbers: Any) -> tuple[Any, ...]:
            return tuple(own.astype(kind) for own in function(np.asarray(numbers, dtype=np.float64))[: len(shapes)])

        kind = jnp.result_type(float)
        wanted = tuple(jax.ShapeDtypeStruct(shape, kind) for shape in shapes)
        return jax.pure_callback(on_host, wanted, numbers, vmap_method="sequential")

    values, derivatives = (len(outputs.of),), (len(outputs.of), len(outputs.by))

    @jax.custom_vjp
    def function(numbers: Any) -> Any:
        return call(outputs, numbers, values)[0]

    def forward(numbers: Any) -> Any:
        return call(outputs.differentiable, numbers, values, derivatives)

    def backward(known: Any, of_values: Any) -> tuple[Any]:
        return (of_values @ known,)

    function.defvjp(forward, backward)

    def checked(numbers: Any) -> Any:
        outputs.check_shape(jnp.shape(numbers))
        return function(jnp.asarray(numbers, dtype=float))

    return checked


def torch_function(outputs: Outputs) -> Callable[[Any], Any]:
    """A function for PyTorch, from numbers to values."""
    import torch
    from torch.autograd.function import once_differentiable

    class Function(torch.autograd.Function):
        @staticmethod
        def forward(ctx: Any, numbers: Any) -> Any:
            outputs.check_shape(numbers.shape)
            if not numbers.is_floating_point():
                raise TypeError(f"numbers are floating point, not {numbers.dtype}: results would be cut off")
            function = outputs.differentiable if ctx.needs_input_grad[0] else outputs
            values, derivatives = function(numbers.detach().cpu().double().numpy())
            ctx.save_for_backward(torch.as_tensor(derivatives).to(numbers))
            return torch.as_tensor(values).to(numbers)

        @staticmethod
        @once_differentiable
        def backward(ctx: Any, of_values: Any) -> Any:
            (derivatives,) = ctx.saved_tensors
            return of_values @ derivatives

    function: Callable[[Any], Any] = Function.apply
    return function

"""Sweeps on the workers of Ray."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from . import _sweep

if TYPE_CHECKING:
    from ._types import Task

AHEAD = 3
"""Tasks for each core that are sent before one of them is done."""


def run(ray: Any, task: Task, ranges: list[_sweep.Range]) -> Iterator[_sweep.Range]:
    """Computes ranges, one task each, and yields those that are done. Ray computes the task of a lost worker again."""
    remote = ray.remote(num_cpus=1, max_retries=-1)(_sweep.compute)
    shared = ray.put(task)
    left = list(reversed(ranges))
    cores = max(1, int(ray.cluster_resources().get("CPU", 1)))
    running = [remote.remote(shared, *left.pop()) for _ in range(min(len(left), AHEAD * cores))]
    try:
        while running:
            done, running = ray.wait(running, num_returns=1)
            for result in ray.get(done):
                yield result
                if left:
                    running.append(remote.remote(shared, *left.pop()))
    finally:
        # After an exception nobody wants the others.
        for reference in running:
            ray.cancel(reference, force=True)

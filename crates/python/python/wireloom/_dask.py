"""Sweeps on the workers of Dask."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from . import _sweep

if TYPE_CHECKING:
    from ._types import Task

AHEAD = 3
"""Tasks for each core that are sent before one of them is done: a worker never waits, and few tasks are in memory."""
ATTEMPTS = 10
"""Times that a range is sent again after Dask gave it up: workers ended while they computed it."""


def run(client: Any, task: Task, ranges: list[_sweep.Range]) -> Iterator[_sweep.Range]:
    """Computes ranges, one task each, and yields those that are done. A task is small: the parts go to the place of the
    sweep, not through Dask. Dask itself computes the task of a lost worker again; where it gives one up, because workers
    ended at it several times, it is sent again."""
    import distributed

    # Not every version of Dask has types for it.
    as_completed: Any = distributed.as_completed

    left = list(reversed(ranges))
    attempts: dict[_sweep.Range, int] = {}
    known: dict[str, _sweep.Range] = {}

    def send(asked: _sweep.Range) -> Any:
        # `pure=False`: the key is new, so that a task that was given up is not remembered.
        future = client.submit(_sweep.compute, task, *asked, pure=False, retries=2)
        known[future.key] = asked
        return future

    cores = max(1, sum(client.nthreads().values()))
    futures = as_completed([send(left.pop()) for _ in range(min(len(left), AHEAD * cores))])
    try:
        for future in futures:
            asked = known.pop(future.key)
            error = future.exception()
            if isinstance(error, distributed.KilledWorker):
                attempts[asked] = attempts.get(asked, 0) + 1
                if attempts[asked] > ATTEMPTS:
                    raise error
                futures.add(send(asked))
                continue
            if error is not None:
                raise error
            yield asked
            if left:
                futures.add(send(left.pop()))
    finally:
        # After an exception nobody wants the others.
        client.cancel(list(futures.futures), force=True)

"""Sweeps as job arrays of SLURM. Each job runs `python -m wireloom._job TASK.json INDEX`."""

from __future__ import annotations

import base64
import json
import os
import shlex
import sys
from typing import TYPE_CHECKING

from . import _sweep, _wireloom

if TYPE_CHECKING:
    from ._scenario import Scenario

JOBS = 1000
"""Most jobs of an array: SLURM allows 1001 where nothing else is configured."""


def slurm(
    scenario: Scenario,
    into: str | os.PathLike[str],
    script: str | os.PathLike[str],
    *,
    columns: list[str] | None = None,
    points: int = _sweep.POINTS,
    jobs: int = JOBS,
    options: tuple[str, ...] = (),
) -> int:
    """Writes a job array that computes the points of a sweep that no part has yet: `sbatch SCRIPT`. Beside the script
    lies SCRIPT.json, which has the scenario with its files. A job computes its ranges on one core; the next array has
    only what is missing.

    Args:
        scenario: a scenario with `[sweep]`.
        into: a folder that all nodes see, or a URL of an object store.
        script: file to be written.
        columns: as for `sweep`.
        points: points of a range, which is what a lost job costs; rounded up to whole chains.
        jobs: most jobs of the array; each has several ranges if there are more.
        options: further lines for SLURM, such as `"--time=02:00:00"` or `"--partition=long"`.

    Returns:
        The number of jobs; 0: nothing is missing, and nothing was written.

    Raises:
        ScenarioError, RequestError, ResultError, OSError: as for `sweep`.

    >>> import os, tempfile, wireloom
    >>> lengths = '[sweep.vary]\\n"branches.cable.length" = { from = "0.9 m", to = "1.1 m", count = 5 }'
    >>> s = wireloom.loads(wireloom.EXAMPLE + lengths)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     wireloom.slurm(s, os.path.join(folder, "parts"), os.path.join(folder, "sweep.sh"), points=2)
    3
    """
    if jobs < 1:
        raise ValueError(f"jobs is at least 1, not {jobs}")
    script = os.path.abspath(script)
    source, files, place, columns = task = _sweep.task_of(scenario, _sweep.Sweep(into).place, columns)
    _, ranges = _wireloom.sweep_begin(task, points)
    if not ranges:
        return 0
    count = min(jobs, len(ranges))
    document = {
        "source": source,
        "files": {name: base64.b64encode(content).decode() for name, content in (files or {}).items()},
        "place": place,
        "columns": columns,
        "jobs": [ranges[job::count] for job in range(count)],
    }
    with open(f"{script}.json", "w", encoding="utf-8") as file:
        json.dump(document, file)
    command = shlex.join([sys.executable, "-m", "wireloom._job", f"{script}.json"])
    lines = [
        "#!/bin/sh",
        "#SBATCH --job-name=wireloom",
        f"#SBATCH --array=0-{count - 1}",
        "#SBATCH --ntasks=1",
        "#SBATCH --cpus-per-task=1",
        # A node that fails gives its job to another one.
        "#SBATCH --requeue",
        *(f"#SBATCH {option}" for option in options),
        f'exec {command} "$SLURM_ARRAY_TASK_ID"',
    ]
    with open(script, "w", encoding="utf-8") as file:
        file.write("\n".join(lines) + "\n")
    os.chmod(script, 0o755)
    return count

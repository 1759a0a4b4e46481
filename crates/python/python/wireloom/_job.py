"""A job of an array that `wireloom.slurm` has written: `python -m wireloom._job TASK.json INDEX`."""

from __future__ import annotations

import base64
import json
import sys

from . import _sweep


def main(path: str, index: str) -> None:
    """Computes the ranges of one job; those that are done already cost nothing."""
    with open(path, encoding="utf-8") as file:
        document = json.load(file)
    text, name, folder, parts = document["source"]
    files = {name: base64.b64decode(content) for name, content in document["files"].items()}
    task = (text, name, folder, parts), files, document["place"], document["columns"]
    for first, end in document["jobs"][int(index)]:
        _sweep.compute(task, first, end)


if __name__ == "__main__":
    main(*sys.argv[1:])

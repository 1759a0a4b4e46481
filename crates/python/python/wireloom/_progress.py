"""The line of progress of long work."""

from __future__ import annotations

import sys
from types import TracebackType


class Progress:
    """A line on standard error, which is written anew as the work goes on."""

    def __init__(self, shown: bool, words: str = "finding the initial equilibrium") -> None:
        self._shown = shown
        self._words = words
        self._width = 0

    def __enter__(self) -> Progress:
        if self._shown:
            self._write(self._words)
        return self

    def say(self, words: str) -> None:
        """What is done so far."""
        if self._shown:
            self._write(words)

    def show(self, step: str, index: int, steps: int, increment: int, increments: int) -> None:
        """The end of an increment."""
        self._write(f"step {index + 1} of {max(steps, 1)}, {step}: increment {increment} of {increments}")

    def _write(self, line: str) -> None:
        # Names come from files: they must not command the terminal.
        line = "".join(c if c.isprintable() else "?" for c in line)
        sys.stderr.write("\r" + line.ljust(self._width))
        sys.stderr.flush()
        self._width = len(line)

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        if self._shown:
            sys.stderr.write("\n")
            sys.stderr.flush()

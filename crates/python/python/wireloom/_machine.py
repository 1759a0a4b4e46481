"""The machine in words, as the command line writes it into reports."""

from __future__ import annotations

import os
import platform
import sys


def machine() -> str:
    """Processor, number of cores and system, as far as they are known."""
    processor = platform.machine()
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as file:
            processor = next((line.split(":", 1)[1].strip() for line in file if line.startswith("model name")), processor)
    except OSError:
        # Only Linux has this file.
        pass
    cores = len(os.sched_getaffinity(0)) if sys.platform == "linux" else os.cpu_count() or 1
    system = {"darwin": "macos", "win32": "windows"}.get(sys.platform, sys.platform)
    return f"{processor}, {cores} {'core' if cores == 1 else 'cores'}, {system}"

"""Examples in docstrings and READMEs run; every public name has a docstring."""

import doctest
import importlib
import inspect
import pkgutil
import re
import shutil
from pathlib import Path

import pytest

import wireloom

ROOT = Path(__file__).resolve().parents[3]
OPTIONAL = {"wireloom._cosseratbench": "cosseratbench", "wireloom._widget": "anywidget"}
"""Modules that need a package which is no dependency."""
MODULES = ["wireloom", *(f"wireloom.{module.name}" for module in pkgutil.iter_modules(wireloom.__path__))]


@pytest.mark.parametrize("name", [name for name in MODULES if name != "wireloom._wireloom"])
def test_examples_of_docstrings_run(name: str) -> None:
    if name in OPTIONAL:
        pytest.importorskip(OPTIONAL[name], reason=f"{OPTIONAL[name]} is not installed")
    flags = doctest.NORMALIZE_WHITESPACE | doctest.IGNORE_EXCEPTION_DETAIL
    assert doctest.testmod(importlib.import_module(name), optionflags=flags).failed == 0


def test_there_are_examples() -> None:
    finder = doctest.DocTestFinder()
    modules = [importlib.import_module(name) for name in MODULES if name not in OPTIONAL]
    assert sum(len(test.examples) for module in modules for test in finder.find(module)) > 20


@pytest.mark.parametrize("readme", ["README.md", "crates/python/README.md"])
def test_examples_of_readmes_run(readme: str, monkeypatch: pytest.MonkeyPatch) -> None:
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    pytest.importorskip("distributed", reason="Dask is not installed: pip install distributed")
    monkeypatch.chdir(ROOT)
    # Parts of an older build.
    shutil.rmtree(ROOT / "out" / "parts", ignore_errors=True)
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / readme).read_text(encoding="utf-8"), re.DOTALL)
    assert blocks
    for block in blocks:
        exec(compile(block, readme, "exec"), {})


def test_every_public_name_is_documented() -> None:
    missing = []
    for name in wireloom.__all__:
        item = getattr(wireloom, name)
        if not (inspect.isclass(item) or inspect.isfunction(item)):
            continue
        members = vars(item).items() if inspect.isclass(item) else []
        own = [(key, value) for key, value in members if not key.startswith("_")]
        missing += [name] if not inspect.getdoc(item) else []
        for key, value in own:
            described = callable(value) or isinstance(value, (property, staticmethod)) or hasattr(value, "func")
            if described and not inspect.getdoc(value):
                missing.append(f"{name}.{key}")
    assert missing == []

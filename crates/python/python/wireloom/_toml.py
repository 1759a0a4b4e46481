"""Documents of dicts and lists as TOML."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping, Sequence
from typing import cast

_BARE = re.compile(r"[A-Za-z0-9_-]+")


def _string(text: str) -> str:
    """A string of TOML. Its escapes are those of JSON, but for one character that JSON does not escape."""
    # Half a pair of UTF-16 is no text.
    text.encode()
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _key(key: object) -> str:
    if not isinstance(key, str):
        raise TypeError(f"a key is a str, not {type(key).__name__}")
    return key if _BARE.fullmatch(key) else _string(key)


def _value(value: object, depth: int = 0) -> str:
    """A value on one line."""
    if depth > 50:
        raise ValueError("lists and dicts are nested too deeply, or contain themselves")
    if hasattr(value, "tolist"):
        # Arrays and numbers of NumPy.
        value = value.tolist()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        if not -(2**63) <= value < 2**63:
            raise ValueError(f"{value} has more than 64 bits")
        return str(int(value))
    if isinstance(value, float):
        if not math.isfinite(value):
            raise ValueError(f"{value} is not finite")
        return repr(float(value))
    if isinstance(value, str):
        return _string(value)
    if isinstance(value, Mapping):
        inside = ", ".join(f"{_key(key)} = {_value(own, depth + 1)}" for key, own in value.items())
        return "{ " + inside + " }" if inside else "{}"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_value(own, depth + 1) for own in value) + "]"
    raise TypeError(f"{type(value).__name__} is no value of a scenario: give numbers, strings, lists or dicts")


def _table(head: str, table: Mapping[object, object]) -> str:
    return "\n".join(["", head, *(f"{_key(key)} = {_value(own)}" for key, own in table.items()), ""])


def _is_table(value: object) -> bool:
    return isinstance(value, Mapping)


def document(value: Mapping[str, object]) -> str:
    """A document of TOML: tables of the first two levels have headings, all others stand on one line."""
    if not isinstance(value, Mapping):
        raise TypeError(f"a document is a dict, not {type(value).__name__}")
    plain, tables = [], []
    for key, own in value.items():
        name = _key(key)
        if isinstance(own, Mapping) and own and all(map(_is_table, own.values())):
            inner = cast("Mapping[str, Mapping[object, object]]", own)
            tables += [_table(f"[{name}.{_key(part)}]", table) for part, table in inner.items()]
        elif isinstance(own, Mapping):
            tables.append(_table(f"[{name}]", own))
        elif isinstance(own, Sequence) and not isinstance(own, str) and own and all(map(_is_table, own)):
            tables += [_table(f"[[{name}]]", table) for table in own]
        else:
            plain.append(f"{name} = {_value(own)}\n")
    return "".join(plain) + "".join(tables)

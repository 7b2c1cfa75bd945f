"""Plain data written as TOML, which the standard library only reads."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from typing import Any

_BARE = re.compile(r"[A-Za-z0-9_-]+")


def toml_text(data: Mapping[str, Any]) -> str:
    """Tables, lists, text, numbers and booleans as TOML text."""
    lines: list[str] = []
    _table(data, (), lines)
    return "\n".join(lines).strip() + "\n"


def _table(data: Mapping[str, Any], path: tuple[str, ...], lines: list[str]) -> None:
    inner = {}
    for key, value in data.items():
        if isinstance(value, Mapping) or _is_table_array(value):
            inner[key] = value
        else:
            lines.append(f"{_key(key)} = {_value(value)}")
    for key, value in inner.items():
        here = (*path, key)
        head = ".".join(_key(part) for part in here)
        for table in [value] if isinstance(value, Mapping) else value:
            lines.append(f"\n[{head}]" if isinstance(value, Mapping) else f"\n[[{head}]]")
            _table(table, here, lines)


def _is_table_array(value: Any) -> bool:
    return isinstance(value, (list, tuple)) and bool(value) and all(isinstance(one, Mapping) for one in value)


def _key(key: str) -> str:
    return key if _BARE.fullmatch(key) else _quoted(key)


def _quoted(text: str) -> str:
    """A basic string: JSON's escapes are TOML's too, but for characters above U+FFFF and for DEL."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _value(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (int, float)):
        return repr(value)
    if isinstance(value, str):
        return _quoted(value)
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_value(one) for one in value) + "]"
    raise TypeError(f"{type(value).__name__} cannot be written as TOML")

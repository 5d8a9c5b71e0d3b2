"""Plain data as JSON text."""

import json
from typing import Any


def _plain(value: Any) -> Any:
    """Arrays and numbers of numpy as lists and numbers, mappings as dicts, paths as text."""
    if hasattr(value, "tolist"):
        return value.tolist()
    if hasattr(value, "__fspath__"):
        return value.__fspath__()
    if hasattr(value, "keys"):
        return {key: value[key] for key in value.keys()}
    raise TypeError(f"{type(value).__name__} is nothing that a scene can hold")


def dumps(value: Any) -> str:
    return json.dumps(value, default=_plain)

"""Tables of members: columns as arrays, data frames where a library for them is installed."""

from __future__ import annotations

from importlib import import_module
from typing import Any, Optional, Sequence

import numpy as np

LIBRARIES = ("pandas", "polars")


def frame(table: dict[str, np.ndarray], library: Optional[str] = None) -> Any:
    """`table` as a data frame of `library`; left out: of the first that is installed, or the table itself."""
    if library is not None and library not in LIBRARIES:
        raise ValueError(f"library: found {library!r}; allowed: {', '.join(map(repr, LIBRARIES))}, None")
    for name in LIBRARIES if library is None else (library,):
        try:
            module = import_module(name)
        except ImportError:
            if library is not None:
                raise
            continue
        return module.DataFrame({name: _native_list(column) for name, column in table.items()})
    return table


def _native_list(column: np.ndarray) -> Any:
    return column.tolist() if column.dtype == object else column


def column(values: Sequence[Any]) -> np.ndarray:
    """`values` as an array: of numbers or texts where all are, else of objects."""
    kinds = {type(value) for value in values}
    if kinds and (kinds <= {int} or kinds <= {bool} or kinds <= {int, float}):
        return np.array(values)
    array = np.empty(len(values), dtype=object)
    array[:] = [tuple(value) if isinstance(value, list) else value for value in values]
    return array


def of_members(members: Any) -> dict[str, np.ndarray]:
    """A row a member."""
    table = {"member": np.arange(len(members))}
    table.update((name, column(values)) for name, values in members.inputs.items())
    for name, values in (
        ("captured", members.captured),
        ("verdict", members.verdicts),
        ("reason", members.reasons),
        ("failure", members.failures),
        ("state_hash", members.state_hashes),
    ):
        table[name] = column(values)
    table.update(members.numbers)
    return table


def stack(members: Any, name: str) -> np.ndarray:
    """An array of every result: [B, T, ...], NaN where a member has no frame."""
    if not any(members.results) and any(failure is None for failure in members.failures):
        raise ValueError("no frames were kept: frames=True keeps them")
    arrays = [None if result is None else getattr(result, name) for result in members.results]
    known = [array for array in arrays if array is not None]
    if not known:
        raise ValueError("no member was finished")
    if len({array.shape[1:] for array in known}) > 1:
        raise ValueError(f"{name} of members of different size: {sorted({array.shape[1:] for array in known})}")
    n_frames = max(len(array) for array in known)
    stacked = np.full((len(arrays), n_frames, *known[0].shape[1:]), np.nan)
    for row, array in zip(stacked, arrays):
        if array is not None:
            row[: len(array)] = array
    return stacked


def of_rows(columns: list[str], rows: list[list[str]]) -> dict[str, np.ndarray]:
    """Texts as a sweep writes them, without columns that no row fills."""
    texts = {name: [row[i] for row in rows] for i, name in enumerate(columns)}
    return {name: _read(name, values) for name, values in texts.items() if any(values)}


TEXTS = ("verdict", "reason", "failure")


def _read(name: str, values: list[str]) -> np.ndarray:
    if name in ("member", "point", "seed"):
        return np.array([int(value) for value in values])
    if name == "captured":
        return column([None if not value else value == "true" for value in values])
    if name not in TEXTS:
        try:
            return np.array([float(value) if value else np.nan for value in values])
        except ValueError:
            pass  # an input that is no number
    return column([value or None for value in values])

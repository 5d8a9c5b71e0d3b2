"""Many runs at once."""

from __future__ import annotations

from os import PathLike
from typing import Any, Mapping, Optional, Sequence, Union

import numpy as np

from . import _native, _table
from ._json import dumps
from ._native import Rollout
from ._types import SceneLike

Params = Union[Sequence[Mapping[str, Any]], Mapping[str, Sequence[Any]]]


def _members(params: Params) -> list[Mapping[str, Any]]:
    """The changes of each member."""
    if not isinstance(params, Mapping):
        return list(params)
    lengths = {path: len(values) for path, values in params.items()}
    if len(set(lengths.values())) > 1:
        raise ValueError(f"params: found lists of different lengths, {lengths}; allowed: a value a member in each")
    return [dict(zip(params, values)) for values in zip(*params.values())]


def rollout(
    scene: SceneLike,
    params: Params,
    *,
    until_settled: bool = False,
    at_most: Optional[float] = None,
    threads: Optional[int] = None,
    frames: bool = False,
) -> Rollout:
    """Runs `scene` once for each member of `params`, in parallel.

    `params`: for each of the B members a dict of changes by path, as `Scene` takes them; or a dict of lists of B values.
    `until_settled`, `at_most`: as `run`. `threads`: left out, as many as there are processors; the bits are the same
    with any number. `frames`: keeps the whole run of each (`results`, `stack`), else its end alone.

    A member that fails, a faulty scene included, says why in `failures`, and the others go on.
    """
    members = _members(params)
    paths = list(dict.fromkeys(path for member in members for path in member))
    inputs = {f"input.{path}": [_plain(member.get(path)) for member in members] for path in paths}
    changes = [[f"{path}={dumps(value)}" for path, value in member.items()] for member in members]
    return _native.rollout(scene, changes, inputs, until_settled, at_most, threads, frames)


def _plain(value: Any) -> Any:
    return value.tolist() if hasattr(value, "tolist") else value


class Ensemble:
    """Copies of a scene that differ in the last digits of the folded net, and in what the scene calls uncertain."""

    summary: dict[str, Any]
    """What `ensemble.json` has: shares with their intervals, survival, quartiles of every number."""
    members: Rollout
    """The members."""

    def __init__(self, members: Rollout, summary: dict[str, Any]) -> None:
        self.members = members
        self.summary = summary

    def table(self) -> dict[str, np.ndarray]:
        """A row a member: a dict of columns, arrays of [B]."""
        return self.members.table()

    def frame(self, library: Optional[str] = None) -> Any:
        """The table as a data frame, as `Rollout.frame`."""
        return self.members.frame(library)

    def __repr__(self) -> str:
        return f"Ensemble({self.summary['title']!r}, {self.members!r})"


def ensemble(
    scene: SceneLike,
    members: int,
    *,
    perturb_m: float = 1e-6,
    seed: int = 1,
    until_settled: bool = False,
    at_most: Optional[float] = None,
    threads: Optional[int] = None,
    frames: bool = False,
) -> Ensemble:
    """Runs `members` copies of `scene`, as `tumblenet run --ensemble`: the same bits as there.

    Knots of the folded net are moved by up to `perturb_m` [m] along each axis, drawn from `seed`. The rest is as in
    `rollout`.
    """
    return Ensemble(
        *_native.ensemble(scene, members, perturb_m, seed, until_settled, at_most, threads, frames)
    )


class Sweep:
    """A scene at many points of its parameters: a row a member, the columns of `table.csv`."""

    def __init__(self, table: dict[str, np.ndarray]) -> None:
        self._table = table

    def table(self) -> dict[str, np.ndarray]:
        """A dict of columns, arrays of [B]."""
        return self._table

    def frame(self, library: Optional[str] = None) -> Any:
        """The table as a data frame, as `Rollout.frame`."""
        return _table.frame(self._table, library)

    def __len__(self) -> int:
        return len(self._table["member"])

    def __repr__(self) -> str:
        return f"Sweep({len(self)} members)"


def sweep(
    study: Union[str, "PathLike[str]", Mapping[str, Any]],
    *,
    threads: Optional[int] = None,
    limits: Optional[Mapping[str, float]] = None,
) -> Sweep:
    """Runs all members of `study`: the path of a study file, the name of a built-in one, or a dict as such a file has it.

    `limits`: how much its scene may ask for, as `Scene` takes them.

    For one that takes minutes. A longer one is the program's, which goes on after an interruption: `tumblenet sweep`
    writes the same table as `table.csv`.
    """
    return Sweep(_table.of_rows(*_native.sweep(study, threads, limits)))

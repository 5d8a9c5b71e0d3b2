"""Names of types for who checks them."""

from __future__ import annotations

from os import PathLike
from typing import TYPE_CHECKING, Any, Mapping, Optional, TypedDict, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

if TYPE_CHECKING:
    from ._native import Scene

Array = NDArray[np.float64]
Whole = NDArray[np.int64]
SceneLike = Union["Scene", str, "PathLike[str]", Mapping[str, Any]]
"""A scene, or what one is made of."""


class Winch(TypedDict, total=False):
    """What winches are told: whether they start now (True where it is left out), at most how fast [m/s], how hard [N]."""

    start: bool
    reel_speed_m_s: float
    max_tension_n: float


class Thrust(TypedDict, total=False):
    """Force at the centre of mass [N] and torque [N m], [3] each; `frame` is "local" (left out) or "body"."""

    force_n: ArrayLike
    torque_n_m: ArrayLike
    frame: str


class Controls(TypedDict, total=False):
    """What a simulation is told; what is left out stays as it is."""

    winch: Winch
    target: Optional[Thrust]
    chaser: Optional[Thrust]


class Contacts(TypedDict):
    """M contacts: see `Simulation.contacts`."""

    knot: Whole
    part: Whole
    point: Array
    normal: Array
    friction: Array
    gap: Array
    impulse: Array

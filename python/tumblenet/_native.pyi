from os import PathLike
from typing import Any, Mapping, Optional, Sequence, Union, final

import numpy as np
from numpy.typing import NDArray

from ._types import Array, Contacts, Controls, SceneLike, Whole

__all__ = [
    "Body",
    "Episodes",
    "Result",
    "Rollout",
    "Scene",
    "Simulation",
    "__version__",
    "_unpickled_scene",
    "ensemble",
    "rollout",
    "run",
    "scenes",
    "sweep",
]
__version__: str

@final
class Scene:
    def __new__(
        cls,
        scene: SceneLike,
        changes: Optional[Mapping[str, Any]] = None,
        *,
        limits: Optional[Mapping[str, float]] = None,
        allow_outside: bool = False,
        **more: Any,
    ) -> Scene: ...
    @property
    def limits(self) -> dict[str, int]: ...
    @property
    def name(self) -> str: ...
    @property
    def title(self) -> str: ...
    @property
    def hash(self) -> str: ...
    @property
    def json(self) -> str: ...
    def to_dict(self) -> dict[str, Any]: ...
    @property
    def duration(self) -> float:
        """[s]"""
    @property
    def time_step(self) -> float:
        """[s]"""
    @property
    def n_knots(self) -> int: ...
    @property
    def cables(self) -> Whole:
        """[C, 2]"""
    @property
    def bullets(self) -> Whole:
        """[4]"""
    @property
    def masses(self) -> Array:
        """[K], kg"""
    @property
    def warnings(self) -> list[str]: ...

@final
class Body:
    @property
    def position(self) -> Array:
        """[3] or [T, 3], m"""
    @property
    def attitude(self) -> Array:
        """[4] or [T, 4], w, x, y, z"""
    @property
    def velocity(self) -> Array:
        """[3] or [T, 3], m/s"""
    @property
    def rate(self) -> Array:
        """[3] or [T, 3], rad/s, local frame"""

@final
class Result:
    @property
    def summary(self) -> dict[str, Any]: ...
    @property
    def audit(self) -> dict[str, float]: ...
    @property
    def warnings(self) -> list[str]: ...
    @property
    def state_hash(self) -> str: ...
    @property
    def captured(self) -> Optional[bool]: ...
    @property
    def verdict(self) -> Optional[str]: ...
    @property
    def time(self) -> Array:
        """[T], s"""
    @property
    def positions(self) -> Array:
        """[T, K, 3], m"""
    @property
    def velocities(self) -> Array:
        """[T, K, 3], m/s"""
    @property
    def contact_impulses(self) -> Array:
        """[T, K, 3], N s"""
    @property
    def tensions(self) -> Array:
        """[T, C], N"""
    @property
    def target(self) -> Optional[Body]: ...
    @property
    def chaser(self) -> Optional[Body]: ...
    @property
    def energy(self) -> dict[str, Array]:
        """[T] each, J"""
    @property
    def momentum(self) -> Array:
        """[T, 3], kg m/s"""
    @property
    def angular_momentum(self) -> Array:
        """[T, 3], kg m^2/s"""
    @property
    def curves(self) -> dict[str, Array]:
        """[T] each"""
    @property
    def readings(self) -> dict[str, Array]:
        """[T] each"""
    @property
    def replay_html(self) -> str: ...
    def save(self, folder: Union[str, PathLike[str]]) -> None: ...
    def _repr_html_(self) -> str: ...

@final
class Simulation:
    def __new__(cls, scene: SceneLike, *, thrust: bool = False, record: bool = False) -> Simulation: ...
    def step(self, dt: Optional[float] = None, controls: Optional[Controls] = None) -> None: ...
    @property
    def time_step(self) -> float:
        """[s]"""
    @property
    def time(self) -> float:
        """[s]"""
    @property
    def positions(self) -> Array:
        """[K, 3], m"""
    @property
    def velocities(self) -> Array:
        """[K, 3], m/s"""
    @property
    def tension(self) -> Array:
        """[C], N"""
    @property
    def target(self) -> Optional[Body]: ...
    @property
    def chaser(self) -> Optional[Body]: ...
    @property
    def energy(self) -> dict[str, float]:
        """J"""
    @property
    def contacts(self) -> Contacts: ...
    @property
    def readings(self) -> dict[str, float]: ...
    def result(self) -> Result: ...
    @property
    def state_hash(self) -> str: ...

@final
class Episodes:
    def __new__(
        cls, scene: SceneLike, n: int, dt: float, at_most: float, perturb_m: float, threads: Optional[int]
    ) -> Episodes: ...
    @staticmethod
    def names() -> list[str]: ...
    def reset(self, seeds: Sequence[Optional[int]]) -> None: ...
    def step(
        self, goes_on: Sequence[bool], start: Sequence[bool], reel_speed: Sequence[float], max_tension: float
    ) -> None: ...
    def observation(self) -> Array:
        """[B, O]"""
    def work(self) -> Array:
        """[B], J"""
    def ended(self) -> list[NDArray[np.bool_]]:
        """[B] each"""
    def verdict(self, number: int) -> tuple[bool, str, Optional[str]]: ...
    def drawn(self, number: int) -> tuple[int, dict[str, str]]: ...
    def result(self, number: int) -> Result: ...

@final
class Rollout:
    def __len__(self) -> int: ...
    @property
    def inputs(self) -> dict[str, list[Any]]: ...
    @property
    def failures(self) -> list[Optional[str]]: ...
    @property
    def captured(self) -> list[Optional[bool]]: ...
    @property
    def verdicts(self) -> list[Optional[str]]: ...
    @property
    def reasons(self) -> list[Optional[str]]: ...
    @property
    def state_hashes(self) -> list[Optional[str]]: ...
    @property
    def summaries(self) -> list[Optional[dict[str, Any]]]: ...
    @property
    def numbers(self) -> dict[str, Array]:
        """[B] each"""
    @property
    def positions(self) -> Array:
        """[B, K, 3], m"""
    @property
    def velocities(self) -> Array:
        """[B, K, 3], m/s"""
    @property
    def target_positions(self) -> Array:
        """[B, 3], m"""
    @property
    def target_attitudes(self) -> Array:
        """[B, 4], w, x, y, z"""
    @property
    def target_velocities(self) -> Array:
        """[B, 3], m/s"""
    @property
    def target_rates(self) -> Array:
        """[B, 3], rad/s"""
    @property
    def results(self) -> list[Optional[Result]]: ...
    def table(self) -> dict[str, NDArray[Any]]:
        """[B] each"""
    def frame(self, library: Optional[str] = None) -> Any: ...
    def stack(self, name: str) -> Array:
        """[B, T, ...]"""

def scenes() -> list[str]: ...
def _unpickled_scene(
    name: str,
    input: str,
    folder: Optional[Union[str, PathLike[str]]],
    json: str,
    limits: Sequence[str],
    allow_outside: bool,
) -> Scene: ...
def run(scene: SceneLike, *, until_settled: bool = False, at_most: Optional[float] = None) -> Result: ...
def rollout(
    scene: SceneLike,
    changes: Sequence[Sequence[str]],
    inputs: dict[str, list[Any]],
    until_settled: bool,
    at_most_s: Optional[float],
    threads: Optional[int],
    frames: bool,
) -> Rollout: ...
def ensemble(
    scene: SceneLike,
    members: int,
    perturb_m: float,
    seed: int,
    until_settled: bool,
    at_most_s: Optional[float],
    threads: Optional[int],
    frames: bool,
) -> tuple[Rollout, dict[str, Any]]: ...
def sweep(
    study: Union[str, PathLike[str], Mapping[str, Any]],
    threads: Optional[int],
    limits: Optional[Mapping[str, float]] = None,
) -> tuple[list[str], list[list[str]]]: ...

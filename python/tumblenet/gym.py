"""Closing control as an environment of gymnasium: when the winches start, and how fast they reel in.

    pip install './python[gym]'

>>> import tumblenet.gym
>>> env = tumblenet.gym.ClosingControl()
>>> observation, info = env.reset(seed=1)

An episode is a flight of the scene, its uncertain inputs and the last digits of its fold drawn from a seed: member 0 of
`tumblenet run SCENE --ensemble 1 --seed SEED`. The scene's own trigger does not fire. It ends when the verdict is decided
(from the scene's own end on), or is truncated at `at_most` seconds.

**Action** [2], each from 0 to 1: the winches start at 0.5 or more of the first, once and for all; they reel in with the
second's share of `reel_speed` at most. The tension is limited as the scene says. Winches never pay out.

**Observation** [11], clipped to the bounds of the space:

| name | unit | |
|---|---|---|
| `time_s` | s | since the shot |
| `area_m2` | m² | area between the four bullets, projected across the flight (X) |
| `mouth` | – | vector area of the net's edge over its designed area |
| `distance_m` | m | from the net's centre of mass to the target's, along X; positive before it |
| `bullets_past_m` | m | by how much the last bullet is past the target's centre of mass along X |
| `approach_m_s` | m/s | speed of the net's centre of mass along X less the target's |
| `target_rate_rad_s` | rad/s | angular speed of the target |
| `has_met` | 0, 1 | whether net and target have touched |
| `is_closing` | 0, 1 | whether the winches were started |
| `off_reels_m` | m | thread off the reels, of the longest thread |
| `tension_n` | N | largest tension of a thread since the observation before |

**Reward**: minus `price_of_work` times the winches' work within the step [J]; and 1 in the last step if the target is then
held, settled or so far. A run whose method fails ends its episode with 0 and `info["failure"]`.
"""

from __future__ import annotations

from typing import Any, Optional, Sequence

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from ._native import Episodes, Result, Scene
from ._types import Array, SceneLike

Numbers = NDArray[Any]

OBSERVATION: tuple[str, ...] = tuple(Episodes.names())
"""Names of what is observed, in order."""

UNCERTAIN: list[dict[str, Any]] = [
    {"path": "target.spin_rad_s", "direction": {"length": [0, 2]}},
    {"path": "launch.speed_m_s", "normal": {"relative": 0.05}},
    {"path": "launch.angle_deg", "normal": {"relative": 0.05}},
]
"""What is uncertain where no scene is given: the target tumbles about any axis at up to 2 rad/s; speed and shooting angle of
the launch are off by 5 %, one sigma."""


def default_scene() -> Scene:
    """The Cubesat and the tube thread of Section 5.4, with `UNCERTAIN` inputs, by the cheapest method."""
    changes = {"uncertain": UNCERTAIN, "solver.cables": "explicit", "solver.contact": "impulse"}
    return Scene("cubesat-spin-x-2.0-tube", changes)


class _Flights:
    """What both environments share: n flights, their spaces, what an action tells, what a step is worth."""

    def __init__(
        self,
        n: int,
        scene: Optional[SceneLike],
        dt: float,
        at_most: Optional[float],
        reel_speed: Optional[float],
        price_of_work: float,
        perturb_m: float,
        threads: Optional[int],
    ) -> None:
        scene = default_scene() if scene is None else Scene(scene)
        written = scene.to_dict()
        closing = written.get("effects", {}).get("closing")
        if closing is None:
            raise ValueError(f"scene: found {scene.name!r}; allowed: one with effects.closing and a target")
        self.scene = Scene(scene, {"effects.closing.trigger": {"on": "time", "at_s": 1e9}})
        self.at_most = 2 * scene.duration if at_most is None else at_most
        for name, value, least in (("at_most", self.at_most, scene.duration), ("price_of_work", price_of_work, 0)):
            if not (np.isfinite(value) and value >= least):
                raise ValueError(f"{name}: found {value}; allowed: a number of at least {least}")
        self.reel_speed = float(closing["reel_speed_m_s"] if reel_speed is None else reel_speed)
        self.max_tension = float(closing["max_tension_n"])
        self.price = price_of_work
        self.runs = Episodes(self.scene, n, dt, self.at_most, perturb_m, threads)
        self.paid = np.zeros(n)
        self.observation_space = _bounds(written, self.at_most + dt)
        self.action_space = spaces.Box(0.0, 1.0, (2,), np.float64)

    def reset(self, seeds: Sequence[Optional[int]]) -> None:
        """Begins anew those that have a seed."""
        self.runs.reset(list(seeds))
        self.paid[[seed is not None for seed in seeds]] = 0

    def step(self, actions: Array, goes_on: Sequence[bool]) -> tuple[Array, Numbers, Numbers]:
        """Rewards, whether each is over, whether it was cut off: [n] each."""
        if not np.isfinite(actions).all():
            raise ValueError(f"action: found {actions.tolist()}; allowed: numbers from 0 to 1")
        start = (actions[:, 0] >= 0.5).tolist()
        speed = (self.reel_speed * np.clip(actions[:, 1], 0, 1)).tolist()
        self.runs.step(list(goes_on), start, speed, self.max_tension)
        work = self.runs.work()
        rewards = -self.price * (work - self.paid)
        self.paid = work
        over, cut_off = self.runs.ended()
        for number in np.flatnonzero((over | cut_off) & np.array(goes_on)):
            rewards[number] += float(self.runs.verdict(int(number))[0])
        return rewards, over, cut_off

    def observe(self) -> Array:
        """[n, 11]"""
        space = self.observation_space
        return np.clip(self.runs.observation(), space.low, space.high)

    def begun(self, number: int) -> dict[str, Any]:
        """What was drawn for an episode, and its seed."""
        seed, drawn = self.runs.drawn(number)
        return {"seed": seed, "drawn": drawn}

    def ended(self, number: int) -> dict[str, Any]:
        """What became of an episode."""
        held, verdict, failure = self.runs.verdict(number)
        known = {"held": held, "verdict": verdict, "work_j": float(self.paid[number])}
        return known if failure is None else {**known, "failure": failure}


def _bounds(scene: dict[str, Any], at_most: float) -> spaces.Box:
    """Bounds of the observation, so wide that a flight which means anything stays within."""
    net, launch = scene["net"], scene["launch"]
    sides = [n * net["mesh_length_m"] for n in net["meshes"]]
    area, speed = sides[0] * sides[1], max(launch["speed_m_s"], 1e-3)
    reach = scene["target"]["distance_m"] + 2 * at_most * speed
    thread = 16 * max(sides)
    rate = 10 * max(float(np.linalg.norm(scene["target"]["spin_rad_s"])), 1.0)
    tension = 10 * scene["effects"]["closing"]["max_tension_n"]
    high = np.array([at_most, 2 * area, 2, reach, reach, 10 * speed, rate, 1, 1, thread, tension])
    low = np.array([0, 0, 0, -reach, -reach, -10 * speed, 0, 0, 0, 0, 0], dtype=float)
    return spaces.Box(low, high, dtype=np.float64)


class ClosingControl(gymnasium.Env[Numbers, Numbers]):
    """One flight at a time: see the module.

    `scene`: one with `effects.closing` and a target; left out, `default_scene()`. `dt`: time between two actions [s].
    `at_most`: of an episode [s], at least the scene's duration; left out, twice that. `reel_speed`: the largest of each winch
    [m/s]; left out, the scene's. `price_of_work`: reward a joule costs [1/J]. `perturb_m`: by how much knots of the folded net are moved
    [m].
    """

    metadata = {"render_modes": []}

    def __init__(
        self,
        scene: Optional[SceneLike] = None,
        *,
        dt: float = 0.02,
        at_most: Optional[float] = None,
        reel_speed: Optional[float] = None,
        price_of_work: float = 0.1,
        perturb_m: float = 1e-6,
    ) -> None:
        self._flights = _Flights(1, scene, dt, at_most, reel_speed, price_of_work, perturb_m, 1)
        self.observation_space = self._flights.observation_space
        self.action_space = self._flights.action_space
        self._is_over = True

    def reset(
        self, *, seed: Optional[int] = None, options: Optional[dict[str, Any]] = None
    ) -> tuple[Array, dict[str, Any]]:
        """Begins an episode; `options={"episode": 17}` names its seed, else it is drawn from `seed`.

        `info` has the episode's `seed` and what was `drawn`.
        """
        super().reset(seed=seed)
        self._flights.reset([_episode(self.np_random, options)])
        self._is_over = False
        return self._flights.observe()[0], self._flights.begun(0)

    def step(self, action: Numbers) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        """Goes on by `dt`; in the last step `info` has `verdict`, `held` and `work_j`."""
        if self._is_over:
            raise gymnasium.error.ResetNeeded("the episode is over: reset begins another")
        rewards, over, cut_off = self._flights.step(np.asarray(action, dtype=float)[None], [True])
        self._is_over = bool(over[0] or cut_off[0])
        info = self._flights.ended(0) if self._is_over else {}
        return self._flights.observe()[0], float(rewards[0]), bool(over[0]), bool(cut_off[0]), info

    def result(self) -> Result:
        """The episode up to now, as `tumblenet.run` returns a run: frames, verdict, replay."""
        return self._flights.runs.result(0)


def _episode(random: np.random.Generator, options: Optional[dict[str, Any]]) -> int:
    if options and options.get("episode") is not None:
        return int(options["episode"])
    return int(random.integers(2**32))


class ClosingControlVector(VectorEnv[Numbers, Numbers, Numbers]):
    """B flights at once, on all processors, without the interpreter's lock: see the module.

    With `reset(seed=s)` environment i is `ClosingControl` after `reset(seed=s + i)`, to the same bits; the number of
    `threads` changes nothing. An episode that is over begins anew in the step after (`AutoresetMode.NEXT_STEP`), whose action
    is not used; with `autoreset=False` it stays as it is, worth nothing more, until all are reset. The rest is as in
    `ClosingControl`.
    """

    def __init__(
        self,
        num_envs: int = 1,
        scene: Optional[SceneLike] = None,
        *,
        dt: float = 0.02,
        at_most: Optional[float] = None,
        reel_speed: Optional[float] = None,
        price_of_work: float = 0.1,
        perturb_m: float = 1e-6,
        threads: Optional[int] = None,
        autoreset: bool = True,
    ) -> None:
        mode = AutoresetMode.NEXT_STEP if autoreset else AutoresetMode.DISABLED
        self.metadata = {"render_modes": [], "autoreset_mode": mode}
        self._autoreset = autoreset
        self._flights = _Flights(num_envs, scene, dt, at_most, reel_speed, price_of_work, perturb_m, threads)
        self.num_envs = num_envs
        self.single_observation_space = self._flights.observation_space
        self.single_action_space = self._flights.action_space
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._randoms = [np.random.default_rng() for _ in range(num_envs)]
        self._is_over = np.ones(num_envs, dtype=bool)

    def reset(
        self, *, seed: Optional[int] = None, options: Optional[dict[str, Any]] = None
    ) -> tuple[Array, dict[str, Any]]:
        """Begins all episodes; `options={"episodes": [17, 18]}` names their seeds, else they are drawn from `seed`."""
        super().reset(seed=seed)
        if seed is not None:
            self._randoms = [gymnasium.utils.seeding.np_random(seed + i)[0] for i in range(self.num_envs)]
        named = (options or {}).get("episodes") or [None] * self.num_envs
        if len(named) != self.num_envs:
            raise ValueError(f"episodes: found {len(named)} seeds; allowed: one for each of {self.num_envs}")
        return self._begin([_episode(random, {"episode": name}) for random, name in zip(self._randoms, named)])

    def _begin(self, seeds: Sequence[Optional[int]]) -> tuple[Array, dict[str, Any]]:
        self._flights.reset(seeds)
        infos: dict[str, Any] = {}
        for number, seed in enumerate(seeds):
            if seed is not None:
                self._is_over[number] = False
                infos = self._add_info(infos, self._flights.begun(number), number)
        return self._flights.observe(), infos

    def step(self, actions: Numbers) -> tuple[Array, Array, Numbers, Numbers, dict[str, Any]]:
        """Goes on by `dt`; of those that end `infos` have `verdict`, `held` and `work_j`."""
        was_over = self._is_over.copy()
        infos: dict[str, Any] = {}
        if self._autoreset and was_over.any():
            # What begins anew does not step.
            seeds = [_episode(random, None) if new else None for random, new in zip(self._randoms, was_over)]
            infos = self._begin(seeds)[1]
        rewards, over, cut_off = self._flights.step(np.asarray(actions, dtype=float), (~was_over).tolist())
        self._is_over = over | cut_off
        for number in np.flatnonzero(self._is_over & ~was_over):
            infos = self._add_info(infos, self._flights.ended(int(number)), int(number))
        return self._flights.observe(), rewards, over, cut_off, infos

    def result(self, number: int) -> Result:
        """The episode `number` up to now, as `tumblenet.run` returns a run."""
        return self._flights.runs.result(number)


gymnasium.register(
    id="tumblenet/ClosingControl-v0",
    entry_point="tumblenet.gym:ClosingControl",
    vector_entry_point="tumblenet.gym:ClosingControlVector",
)

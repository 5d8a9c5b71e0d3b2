"""When to close: a rule that looks at the net, beside fixed delays, for a target that tumbles at up to 2 rad/s about any axis.

    python python/examples/closing_control.py [--dispersion 0.05] [--tune 96] [--fresh 160] [--seconds 3]

Each way of choosing the moment has one number. It and the speed of the reels are chosen on the same `--tune` episodes for
all ways, by the mean reward (held at the end, less 0.1 a joule of work); then each is tried on the same `--fresh` episodes,
which none has seen. Needs `pip install './python[gym]'`.
"""

from __future__ import annotations

import argparse
import itertools
from typing import Callable, Iterable, NamedTuple

import numpy as np
import tumblenet
from tumblenet.gym import OBSERVATION, UNCERTAIN, ClosingControlVector, default_scene

TIME, PAST, MET = map(OBSERVATION.index, ("time_s", "bullets_past_m", "has_met"))
Moment = Callable[[np.ndarray], np.ndarray]
"""From observations [B, O] of one step after the other to whether it is time [B]."""


def after_the_shot(delay: float) -> Moment:
    return lambda seen: seen[:, TIME] >= delay - 1e-9


def after_contact(delay: float) -> Moment:
    since: list[np.ndarray] = []

    def moment(seen: np.ndarray) -> np.ndarray:
        met = np.where(seen[:, MET] > 0, seen[:, TIME], np.inf)
        since[:] = [np.minimum(met, *since) if since else met]
        return seen[:, TIME] >= since[0] + delay - 1e-9

    return moment


def bullets_past(distance: float) -> Moment:
    return lambda seen: seen[:, PAST] >= distance


def never(_: float) -> Moment:
    return lambda seen: np.zeros(len(seen), dtype=bool)


WAYS: dict[str, tuple[Callable[[float], Moment], list[tuple[float, float]]]] = {
    "never": (never, [(0.0, 1.0)]),
    "fixed: s after the shot": (after_the_shot, list(itertools.product((0.7, 0.8, 0.9, 1.0), (1.0, 0.5)))),
    "fixed: s after contact": (after_contact, [(0.0, 1.0), (0.3, 1.0)]),
    "rule: bullets past by, m": (bullets_past, [(-0.2, 1.0), (0.0, 1.0)]),
}
"""Ways, with the numbers and the shares of the scene's reel speed to choose from."""


class Episodes(NamedTuple):
    """What became of some, [B] each."""

    held: np.ndarray
    work: np.ndarray
    reward: np.ndarray


def scene(dispersion: float) -> tumblenet.Scene:
    """The environment's own, with speed and angle of the launch off by this share, one sigma."""
    launch = [{**row, "normal": {"relative": dispersion}} if "normal" in row else row for row in UNCERTAIN]
    return tumblenet.Scene(default_scene(), {"uncertain": launch})


def fly(env: ClosingControlVector, moment: Callable[[], Moment], reel: float, seeds: Iterable[int]) -> Episodes:
    """The episodes with these seeds."""
    all_seeds, parts = list(seeds), []
    for first in range(0, len(all_seeds), env.num_envs):
        some = all_seeds[first : first + env.num_envs]
        seen, _ = env.reset(options={"episodes": some + some[:1] * (env.num_envs - len(some))})
        over, reward, is_time = np.zeros(env.num_envs, dtype=bool), np.zeros(env.num_envs), moment()
        held, work = np.zeros(env.num_envs, dtype=bool), np.zeros(env.num_envs)
        while not over.all():
            action = np.stack([is_time(seen), np.full(env.num_envs, reel)], axis=1)
            seen, rewards, ends, cut_off, infos = env.step(action)
            new = (ends | cut_off) & ~over
            if new.any():
                held[new], work[new] = infos["held"][new], infos["work_j"][new]
            reward += rewards
            over |= new
        parts.append(Episodes(held[: len(some)], work[: len(some)], reward[: len(some)]))
    return Episodes(*(np.concatenate(column) for column in zip(*parts)))


def wilson(n_held: int, n: int) -> tuple[float, float]:
    """Interval of 95 % of a share."""
    z = 1.96
    middle, width = n_held + z * z / 2, z * np.sqrt(n_held * (n - n_held) / n + z * z / 4)
    return (middle - width) / (n + z * z), (middle + width) / (n + z * z)


def bootstrap(differences: np.ndarray) -> tuple[float, float]:
    """Interval of 95 % of the mean of differences, episode by episode."""
    draws = np.random.default_rng(1).integers(len(differences), size=(4000, len(differences)))
    low, high = np.quantile(differences[draws].mean(axis=1), (0.025, 0.975))
    return float(low), float(high)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--dispersion", type=float, default=0.05, help="of the launch, one sigma")
    parser.add_argument("--tune", type=int, default=96, help="episodes to choose the numbers on")
    parser.add_argument("--fresh", type=int, default=160, help="episodes to try them on")
    parser.add_argument("--seconds", type=float, default=3.0, help="of an episode")
    arguments = parser.parse_args()
    n = min(16, arguments.tune, arguments.fresh)
    env = ClosingControlVector(n, scene(arguments.dispersion), at_most=arguments.seconds, autoreset=False)
    tune, fresh = range(arguments.tune), range(10_000, 10_000 + arguments.fresh)

    found: dict[str, tuple[float, float, Episodes]] = {}
    for way, (make, choices) in WAYS.items():
        tuned = {choice: float(fly(env, lambda: make(choice[0]), choice[1], tune).reward.mean()) for choice in choices}
        print(f"{way}: " + ", ".join(f"{n:g} at {reel:g} {value:.3f}" for (n, reel), value in tuned.items()), flush=True)
        number, reel = max(tuned, key=tuned.__getitem__)
        found[way] = (number, reel, fly(env, lambda: make(number), reel, fresh))

    print(f"\n{arguments.fresh} fresh episodes of {arguments.seconds:g} s, dispersion {arguments.dispersion:g}\n")
    print("| way | number | reels | held | interval of 95 % | work, J | reward | more than the first fixed one | interval |")
    print("|---|---|---|---|---|---|---|---|---|")
    base = found["fixed: s after the shot"][2]
    for way, (number, reel, episodes) in found.items():
        n_held = int(episodes.held.sum())
        low, high = wilson(n_held, len(episodes.held))
        differences = episodes.reward - base.reward
        (less, more), mean = bootstrap(differences), differences.mean()
        print(
            f"| {way} | {number:g} | {reel:g} | {n_held} of {len(episodes.held)} | {low:.3f} to {high:.3f} "
            f"| {episodes.work.mean():.3f} | {episodes.reward.mean():.3f} | {mean:+.3f} | {less:+.3f} to {more:+.3f} |"
        )


if __name__ == "__main__":
    main()

# ---
# jupyter:
#   jupytext:
#     text_representation:
#       extension: .py
#       format_name: percent
#   kernelspec:
#     display_name: Python 3
#     language: python
#     name: python3
# ---

# %% [markdown]
# # When to close
#
# The winches that shut a net start once and cannot pay out. `tumblenet.gym` is that decision as an environment of gymnasium: an episode
# is a flight whose tumbling axis, rate and launch are drawn from a seed; an action says whether to start, and how fast to reel.

# %%
import matplotlib.pyplot as plt
import numpy as np
from tumblenet.gym import OBSERVATION, ClosingControl, ClosingControlVector

PAST, TIME = OBSERVATION.index("bullets_past_m"), OBSERVATION.index("time_s")

env = ClosingControl(at_most=3.0)
observation, info = env.reset(seed=1)
print({name: round(float(text), 3) for name, text in info["drawn"].items()})

# %% [markdown]
# A rule without any learning: start when the last bullet is past the target's centre.

# %%
seen, total, over = [observation], 0.0, False
while not over:
    observation, reward, terminated, truncated, info = env.step(np.array([observation[PAST] > 0, 1.0]))
    seen.append(observation)
    total, over = total + reward, terminated or truncated
print(info, f"reward {total:.3f}")

# %%
rows = np.array(seen)
_, axes = plt.subplots(2, 2, sharex=True, figsize=(8, 5))
for panel, name in zip(axes.flat, ("area_m2", "bullets_past_m", "off_reels_m", "tension_n")):
    panel.plot(rows[:, TIME], rows[:, OBSERVATION.index(name)])
    panel.set_title(name)

# %% [markdown]
# The episode as a run, with its replay:

# %%
env.result()

# %% [markdown]
# Eight flights at once, on all processors, by the rule and at a fixed time after the shot. Eight are few:
# `python/examples/closing_control.py` chooses the best number of each way on some episodes and tries it on others, with intervals
# (the table is in `docs/python.md`).


# %%
def fly(is_time, n=8):
    """How many of n are held, and the mean work of their winches [J]."""
    flights = ClosingControlVector(n, at_most=3.0, autoreset=False)
    observations, _ = flights.reset(seed=100)
    held, work, over = np.zeros(n, dtype=bool), np.zeros(n), np.zeros(n, dtype=bool)
    while not over.all():
        actions = np.stack([is_time(observations), np.ones(n)], axis=1)
        observations, _, terminated, truncated, infos = flights.step(actions)
        new = (terminated | truncated) & ~over
        if new.any():
            held[new], work[new] = infos["held"][new], infos["work_j"][new]
        over |= new
    return held.sum(), work.mean()


for name, is_time in (
    ("bullets past the target", lambda rows: rows[:, PAST] > 0),
    ("0.8 s after the shot", lambda rows: rows[:, TIME] >= 0.8),
    ("0.6 s after the shot", lambda rows: rows[:, TIME] >= 0.6),
):
    held, work = fly(is_time)
    print(f"{name}: {held} of 8 held, {work:.2f} J")

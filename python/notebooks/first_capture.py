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
# # A first capture
#
# A net is shot at a 3U Cubesat that tumbles at 2 rad/s, and a thread around its edge is reeled in when the two touch. Does it hold?
# Open this file as a notebook with jupytext (`pip install './python[notebooks]'`), or run it as a script.

# %%
import matplotlib.pyplot as plt
import tumblenet

scene = tumblenet.Scene("cubesat-spin-x-2.0-tube")
print(scene.title)
print(f"{scene.n_knots} knots, {len(scene.cables)} cables, {scene.duration} s in steps of {1e3 * scene.time_step} ms")

# %% [markdown]
# A run is one call. A result as the last line of a cell is its replay: drag to turn it, the slider is time.

# %%
result = tumblenet.run(scene)
result

# %% [markdown]
# Everything in it is an array, in SI units. The net holds the target while at least half of it is enclosed and the mouth is at most
# a fifth of the designed area.

# %%
print(result.verdict, "since", result.summary["capture"]["captured_at_s"], "s")

_, (above, below) = plt.subplots(2, sharex=True, figsize=(7, 5))
above.plot(result.time, result.curves["enclosed"], label="enclosed share of the target")
above.plot(result.time, result.curves["mouth"], label="mouth over designed area")
above.axvline(result.summary["contact"]["first_contact_s"], color="grey", lw=0.8)
above.legend()
below.plot(result.time, result.tensions.max(axis=1), label="tautest cable")
below.plot(result.time, result.readings["thread_1_tension_n"], label="thread")
below.set_xlabel("time, s")
below.set_ylabel("tension, N")
below.legend()

# %% [markdown]
# Where did the energy go? The ledger adds up at every moment.

# %%
energy = result.energy
for name in ("kinetic_net", "kinetic_target", "elastic", "taken_by_cables", "taken_by_solver", "taken_by_contact", "work_of_closing"):
    print(f"{name:17} {energy[name][0]:7.4f} J at the start, {energy[name][-1]:7.4f} J at the end")
print(f"made or lost by the method: {result.audit['energy_residual']:.1e} of the launch energy")

# %% [markdown]
# One run after contact is one toss of a coin: a change in the last digits makes another. Eight runs whose folded net differs by a
# micrometre tell more, sixty would tell enough; without the thread for comparison.

# %%
cheap = {"solver.cables": "explicit", "solver.contact": "impulse"}
for name in ("cubesat-spin-x-2.0-tube", "cubesat-spin-x-2.0"):
    captured = tumblenet.ensemble(tumblenet.Scene(name, cheap), 8).summary["captured"]
    low, high = captured["interval_95"]
    print(f"{name}: {captured['captured']} of {captured['of']} held after 3 s, interval {low:.2f} to {high:.2f}")

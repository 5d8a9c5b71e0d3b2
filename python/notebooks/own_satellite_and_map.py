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
# # A satellite of your own, and a map
#
# A scene is a dict as its file has it. Here a bus with two panels, which tumbles about an oblique axis; parts are convex, SI units.

# %%
import matplotlib.pyplot as plt
import numpy as np
import tumblenet

satellite = {
    "parts": [
        {"name": "bus", "cuboid": [0.4, 0.4, 0.4], "mass_kg": 40.0},
        {"name": "panel, +y", "cuboid": [0.3, 0.8, 0.02], "position_m": [0, 0.65, 0], "mass_kg": 3.0},
        {"name": "panel, -y", "cuboid": [0.3, 0.8, 0.02], "position_m": [0, -0.65, 0], "mass_kg": 3.0},
    ]
}
capture = {
    "title": "A small satellite that tumbles about an oblique axis",
    "duration_s": 2.5,
    "net": {
        "meshes": [10, 10],
        "mesh_length_m": 0.3,
        "cable": {"material": "nylon", "diameter_m": 0.001},
        "bullet_mass_kg": 0.25,
        "fold": {"scheme": "scaled", "ratio": 0.1},
    },
    "launch": {"speed_m_s": 4.0, "angle_deg": 30.0},
    "target": {"shape": satellite, "distance_m": 4.0, "spin_rad_s": [0.3, 0.0, 0.1]},
    "effects": {
        "closing": {
            "trigger": {"on": "contact", "delay_s": 0.1},
            "reel_speed_m_s": 3.0,
            "max_tension_n": 20.0,
        }
    },
    "solver": {"cables": "explicit", "contact": "impulse"},
}
scene = tumblenet.Scene(capture)
for warning in scene.warnings:
    print(warning)

# %% [markdown]
# A typing error is told with all others, each with its place:

# %%
try:
    tumblenet.Scene(scene, {"target.spin_rads": [0, 0, 1], "net.bullet_mass_kg": -1})
except tumblenet.SceneError as error:
    print(error)

# %%
result = tumblenet.run(scene)
result

# %% [markdown]
# How far off may the shot be, and how fast may the target tumble? `rollout` runs all combinations on all processors. A member is a
# row; two runs in each box differ in the phase of the tumble.

# %%
offsets, rates, turns = np.linspace(0, 0.3, 3), np.linspace(0, 2, 3), (0, 90)
grid = [
    {"target.offset_m": [offset, 0], "target.spin_rad_s": [rate, 0, 0], "target.attitude_deg": [turn, 0, 0]}
    for offset in offsets
    for rate in rates
    for turn in turns
]
members = tumblenet.rollout(scene, grid)
assert not any(members.failures)
frame = members.frame("pandas")
print(frame[["verdict", "contact.first_contact_s", "capture.enclosed", "capture.mouth"]].describe())

# %%
share = np.reshape(members.captured, (len(offsets), len(rates), len(turns))).mean(axis=2)
figure, axes = plt.subplots(figsize=(6, 4.5))
image = axes.pcolormesh(rates, offsets, share, vmin=0, vmax=1, cmap="Greens", shading="nearest")
for i, j in np.ndindex(share.shape):
    axes.text(rates[j], offsets[i], f"{share[i, j] * len(turns):.0f} of {len(turns)}", ha="center")
axes.set_xlabel("tumbling rate, rad/s")
axes.set_ylabel("the shot passes beside the target, m")
figure.colorbar(image, label="share held after 2.5 s")

# %% [markdown]
# Two runs a box say little of each: `tumblenet map` fits a probability with its interval to a sweep of hundreds
# (`docs/sweeps.md`). And 2.5 s are short: `until_settled=True` goes on until the verdict is decided.

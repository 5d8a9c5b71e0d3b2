"""Tether-net capture of tumbling space debris, simulated on the Rapier rigid-body engine.

>>> import tumblenet
>>> result = tumblenet.run("cubesat-spin-x-2.0-tube")
>>> result.verdict
'held_so_far'

SI units and radians; the local frame O-XYZ has its origin at the centre of the net container, X along the travelling
direction, Y to the left, Z up. Attitudes are quaternions w, x, y, z, local frame from body frame.
"""

from ._batch import Ensemble, Sweep, ensemble, rollout, sweep
from ._errors import ControlError, Fault, InputError, RunError, SceneError
from ._native import Body, Result, Rollout, Scene, Simulation, __version__, run, scenes
from ._types import Contacts, Controls, SceneLike, Thrust, Winch

__all__ = [
    "Body",
    "Contacts",
    "ControlError",
    "Controls",
    "Ensemble",
    "Fault",
    "InputError",
    "Result",
    "Rollout",
    "RunError",
    "Scene",
    "SceneError",
    "SceneLike",
    "Simulation",
    "Sweep",
    "Thrust",
    "Winch",
    "__version__",
    "ensemble",
    "rollout",
    "run",
    "scenes",
    "sweep",
]

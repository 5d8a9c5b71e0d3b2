"""Reads back what `run --export vtk,gltf` wrote, with pyvista and pygltflib, and compares it with trajectory.npz.

    python3 tests/exchange.py DIR
"""

import sys
from pathlib import Path

import numpy as np
import pygltflib
import pyvista


def vtk(folder, arrays):
    """Every frame of the list, every body of a frame."""
    reader = pyvista.get_reader(folder / "vtk" / "run.pvd")
    assert list(reader.time_values) == list(arrays["t"]), "times"
    for frame in range(len(arrays["t"])):
        reader.set_active_time_point(frame)
        bodies = {Path(entry.path).name.split("_")[0]: body
                  for entry, body in zip(reader.active_datasets, reader.read())}
        net = bodies["net"]
        ends = net.lines.reshape(-1, 3)
        assert (ends[:, 0] == 2).all() and (ends[:, 1:] == arrays["cables"]).all(), "cables"
        # pyvista keeps points as they are written, 64 bits.
        assert (net.points == arrays["knots"][frame]).all(), f"knots of frame {frame}"
        for name, there in [("velocity_m_s", "velocities"), ("contact_impulse_n_s", "contact_impulses")]:
            assert (net.point_data[name] == arrays[there][frame]).all(), f"{name} of frame {frame}"
        assert (net.cell_data["tension_n"] == arrays["tensions"][frame]).all(), f"tensions of frame {frame}"
        if "target_position" in arrays:
            # Of a single box the middle of its corners is its centre of mass.
            middle = bodies["target"].points.mean(axis=0)
            assert np.abs(middle - arrays["target_position"][frame]).max() < 1e-12, f"target of frame {frame}"
    return len(arrays["t"])


def gltf(folder, arrays):
    """The path of every knot and the target's pose."""
    file = pygltflib.GLTF2().load(str(folder / "run.glb"))
    blob = file.binary_blob()

    def numbers(accessor):
        accessor = file.accessors[accessor]
        view = file.bufferViews[accessor.bufferView]
        width = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[accessor.type]
        assert accessor.componentType == pygltflib.FLOAT
        return np.frombuffer(blob, "<f4", accessor.count * width, view.byteOffset).reshape(-1, width)

    motion = file.animations[0]
    nodes = {node.name: place for place, node in enumerate(file.nodes)}
    paths = {(channel.target.node, channel.target.path): motion.samplers[channel.sampler] for channel in motion.channels}
    for knot in range(arrays["knots"].shape[1]):
        sampler = paths[nodes[f"knot {knot}"], "translation"]
        assert (numbers(sampler.input)[:, 0] == arrays["t"].astype("f4")).all()
        assert (numbers(sampler.output) == arrays["knots"][:, knot].astype("f4")).all(), f"knot {knot}"
    if "target_position" in arrays:
        target = nodes["target"]
        place = numbers(paths[target, "translation"].output)
        assert (place == arrays["target_position"].astype("f4")).all(), "target"
        # x, y, z, w here and w, x, y, z there; both signs are the same attitude.
        turn, there = numbers(paths[target, "rotation"].output), arrays["target_attitude"][:, [1, 2, 3, 0]]
        assert (np.abs((turn * there).sum(axis=1)) > 1 - 1e-6).all(), "attitude"
    assert [file.nodes[joint].name for joint in file.skins[0].joints] == [
        f"knot {knot}" for knot in range(arrays["knots"].shape[1])]
    return len(file.nodes)


if __name__ == "__main__":
    place = Path(sys.argv[1])
    kept = dict(np.load(place / "trajectory.npz"))
    print(f"{vtk(place, kept)} frames of VTK and {gltf(place, kept)} nodes of glTF say what trajectory.npz says")

"""A run: the same bits as the program, and its results as arrays."""

import json
import signal
import threading
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
import tumblenet
from tumblenet import Scene


def hashes(root):
    """Runs whose last state the program's own test hashes, but those in single precision."""
    known = json.loads((root / "tests/state_hashes.json").read_text())
    return {run: digest for run, digest in known.items() if "precision" not in run}


def scene_of(run):
    name, *changes = run.split(" ")
    pairs = (change.split("=", 1) for change in changes)

    def value(text):
        try:
            return json.loads(text)
        except json.JSONDecodeError:
            return text

    return name, {path: value(text) for path, text in pairs}


def test_every_built_in_scene_ends_in_the_bits_of_the_program(root):
    known = hashes(root)
    # Knots that touch each other, and elements, cost as much as all others together: not run here.
    cheap = {run: digest for run, digest in known.items() if "self_contact" not in run and "ancf" not in run}
    assert {scene_of(run)[0] for run in cheap} == set(tumblenet.scenes())
    # In threads of Python: a run leaves the interpreter to others.
    with ThreadPoolExecutor() as pool:
        found = pool.map(lambda run: tumblenet.run(Scene(*scene_of(run))).state_hash, cheap)
    assert dict(zip(cheap, found)) == cheap


def test_files_are_those_of_the_program(capture, program, tmp_path):
    scene, result = capture
    result.save(tmp_path / "saved")
    program("run", "cubesat-spin-x-2.0-tube", "--set", "duration_s=1.5", "--out", tmp_path / "program", "--quiet")
    for name in ("series.csv", "trajectory.npz"):
        assert (tmp_path / "saved" / name).read_bytes() == (tmp_path / "program" / name).read_bytes(), name
    saved, other = (json.loads((tmp_path / who / "summary.json").read_text()) for who in ("saved", "program"))
    for key in ("wall_s", "time_shares"):
        assert saved.pop(key) and other.pop(key)
    # The command is that of each; a wheel may be made of another commit than the program beside it.
    for summary in (saved, other):
        assert all(summary["provenance"].pop(key) for key in ("commit", "command"))
    assert saved == other
    assert (tmp_path / "saved/replay.html").read_text() == result.replay_html


def test_arrays_are_those_of_the_trajectory(capture, tmp_path):
    scene, result = capture
    result.save(tmp_path)
    arrays = np.load(tmp_path / "trajectory.npz")
    frames, knots, cables = len(result.time), scene.n_knots, len(scene.cables)
    assert result.positions.shape == (frames, knots, 3) and result.tensions.shape == (frames, cables)
    own = {
        "t": result.time,
        "knots": result.positions,
        "velocities": result.velocities,
        "contact_impulses": result.contact_impulses,
        "tensions": result.tensions,
        "target_position": result.target.position,
        "target_attitude": result.target.attitude,
        "target_velocity": result.target.velocity,
        "target_rate": result.target.rate,
        "threads": np.stack(list(result.readings.values()), axis=1),
        "cables": scene.cables,
    }
    for name, array in own.items():
        np.testing.assert_array_equal(array, arrays[name], err_msg=name)
    # What net and target are made of, for figures; and what the arrays are.
    made_of = {"masses", "bullets", "edge", "rest_lengths", "breaking_tensions", "thread_way"}
    target = {"target_points", "target_triangles", "target_parts"}
    assert set(arrays) - set(own) == {"grid", "units", "thread_names"} | made_of | target
    np.testing.assert_array_equal(arrays["rest_lengths"].shape, (cables,))
    np.testing.assert_array_equal(arrays["masses"].shape, (knots,))


def test_an_array_is_made_once_and_not_written_to(capture):
    _, result = capture
    assert result.positions is result.positions and result.summary is result.summary
    with pytest.raises(ValueError):
        result.positions[0, 0, 0] = 1


def test_the_ledger_adds_up(capture):
    _, result = capture
    energy = result.energy
    has = energy["kinetic_net"] + energy["kinetic_target"] + energy["elastic"] + energy["stored"]
    taken = sum(row for name, row in energy.items() if name.startswith("taken_by_")) + energy["residual"]
    given = energy["drive"] + sum(row for name, row in energy.items() if name.startswith("work_of_"))
    np.testing.assert_allclose(has + taken - given, has[0], rtol=1e-12)
    assert result.audit == result.summary["conservation"]
    assert set(result.curves) > {"enclosed", "mouth"} and result.momentum.shape == (len(result.time), 3)


def test_a_notebook_shows_the_replay(capture):
    _, result = capture
    html = result._repr_html_()
    assert html.startswith('<iframe srcdoc="<!doctype html>')
    # The page is one attribute: no quote ends it early.
    assert html.count('"') == 4


def test_a_run_goes_on_until_it_is_decided():
    scene = Scene("cubesat-spin-x-2.0-tube", {"duration_s": 0.3, "solver": {"cables": "explicit", "contact": "impulse"}})
    short, on = tumblenet.run(scene), tumblenet.run(scene, until_settled=True, at_most=0.5)
    assert short.time[-1] == pytest.approx(0.3) and on.time[-1] == pytest.approx(0.5)
    for wrong in ({"at_most": 1.0}, {"until_settled": True, "at_most": -1.0}, {"until_settled": True, "at_most": 1e9}):
        with pytest.raises(ValueError, match="at_most"):
            tumblenet.run(scene, **wrong)
    with pytest.raises(tumblenet.SceneError, match="without a target"):
        tumblenet.run(Scene("deployment-kevlar"), until_settled=True)


def test_a_scene_without_a_target_has_none():
    result = tumblenet.run(Scene("deployment-kevlar", duration_s=0.05))
    assert (result.target, result.captured, result.verdict, result.curves) == (None, None, None, {})


def test_a_folder_that_cannot_be_is_an_os_error(capture, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(OSError):
        capture[1].save(tmp_path / "file" / "below")


def test_an_interrupt_ends_a_run(interruptible):
    scene = Scene("cubesat-spin-x-2.0-tube")
    threading.Timer(0.2, signal.raise_signal, [signal.SIGINT]).start()
    with pytest.raises(KeyboardInterrupt):
        for _ in range(1000):
            tumblenet.run(scene)

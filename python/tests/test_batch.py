"""Many runs: the same bits with any number of threads, a reason for each that fails, tables."""

import csv
import json
import runpy
import signal
import threading

import numpy as np
import pytest
import tumblenet
from tumblenet import Scene

FAST = {"duration_s": 0.9, "capture.hold_s": 0, "solver.cables": "explicit", "solver.contact": "impulse"}


@pytest.fixture(scope="module")
def scene():
    return Scene("cubesat-spin-x-1.0", FAST)


def test_a_rollout_does_not_depend_on_the_number_of_threads(scene):
    params = {"target.mass_kg": np.linspace(1, 8, 5), "target.spin_rad_s.0": [0, 0.5, 1, 1.5, 2]}
    one, three = (tumblenet.rollout(scene, params, threads=threads) for threads in (1, 3))
    assert one.state_hashes == three.state_hashes and len(set(one.state_hashes)) == 5
    np.testing.assert_array_equal(one.positions, three.positions)
    for name, column in one.table().items():
        np.testing.assert_array_equal(column, three.table()[name], err_msg=name)
    # Each is the run alone.
    alone = tumblenet.run(Scene(scene, {path: values[3] for path, values in params.items()}))
    assert alone.state_hash == one.state_hashes[3]
    np.testing.assert_array_equal(one.positions[3], alone.positions[-1])
    np.testing.assert_array_equal(one.target_attitudes[3], alone.target.attitude[-1])


def test_a_member_that_fails_is_a_row_with_its_reason(scene):
    members = tumblenet.rollout(scene, [{}, {"target.mass_kg": -1}, {"launch.speed_m_s": 2.1}])
    assert [failure is None for failure in members.failures] == [True, False, True]
    assert "target.mass_kg: found -1" in members.failures[1]
    assert members.positions.shape == (3, scene.n_knots, 3) and np.isnan(members.positions[1]).all()
    assert not np.isnan(members.positions[[0, 2]]).any()
    table = members.table()
    assert table["failure"][1] == members.failures[1] and table["state_hash"][1] is None
    assert np.isnan(table["contact.first_contact_s"][1]) and table["input.launch.speed_m_s"][2] == 2.1
    assert members.summaries[1] is None and members.summaries[0]["state_hash"] == members.state_hashes[0]


def test_frames_are_kept_on_request(scene):
    members = tumblenet.rollout(scene, [{"duration_s": 0.1}, {"duration_s": 0.2}], frames=True)
    short, long = members.results
    stacked = members.stack("positions")
    assert stacked.shape == (2, len(long.time), scene.n_knots, 3)
    np.testing.assert_array_equal(stacked[1], long.positions)
    np.testing.assert_array_equal(stacked[0, : len(short.time)], short.positions)
    assert np.isnan(stacked[0, len(short.time) :]).all()
    with pytest.raises(ValueError, match="frames=True"):
        tumblenet.rollout(scene, [{"duration_s": 0.1}]).stack("positions")


def test_an_ensemble_is_that_of_the_program(scene, program, tmp_path):
    found = tumblenet.ensemble(scene, 4, seed=7)
    changes = [part for path, value in FAST.items() for part in ("--set", f"{path}={value}")]
    out = tmp_path / "four"
    program("run", "cubesat-spin-x-1.0", *changes, "--ensemble", 4, "--seed", 7, "--out", out, "--quiet")
    summary = json.loads((out / "ensemble.json").read_text())
    for block in (summary, found.summary):
        block["scalars"] = {
            name: row for name, row in block["scalars"].items() if not name.startswith(("wall_s", "time_shares"))
        }
    assert found.summary == summary
    assert len(found.members) == 4 and len(set(found.members.state_hashes)) == 4


STUDY = {
    "title": "mass",
    "scene": "cubesat-free",
    "set": {"duration_s": 0.9},
    "solver": "explicit+impulse",
    "parameters": [{"path": "target.mass_kg", "uniform": [2, 6]}],
    "design": {"kind": "sobol", "points": 4},
    "collect": ["contact", "capture"],
}


def test_a_sweep_is_that_of_the_program(program, tmp_path):
    file = tmp_path / "mass.json"
    file.write_text(json.dumps(STUDY))
    out = tmp_path / "out"
    program("sweep", file, "--out", out, "--quiet")
    header, *rows = [line.split(",") for line in (out / "table.csv").read_text().splitlines()]
    for study in (file, STUDY):
        table = tumblenet.sweep(study).table()
        assert list(table) == header
        for i, name in enumerate(header):
            texts = [row[i] for row in rows]
            same = [float(text) if text else np.nan for text in texts] if table[name].dtype == float else None
            if same is not None:
                np.testing.assert_array_equal(table[name], same, err_msg=name)
            else:
                assert [str(value).lower() if value is not None else "" for value in table[name]] == texts, name
    with pytest.raises(tumblenet.SceneError, match="collect"):
        tumblenet.sweep({**STUDY, "collect": ["no.such.number"]})


def test_shards_of_a_sweep_become_one_parquet_file(root, program, tmp_path):
    polars = pytest.importorskip("polars")
    file = tmp_path / "mass.json"
    # Each is within what the scene allows; both together the target begins within the net.
    study = {
        **STUDY,
        "set": {"duration_s": 0.9, "target.offset_m": [0.5, 0.5]},
        "parameters": [
            {"path": "target.distance_m", "values": [0.15, 0.02]},
            {"path": "target.offset_m", "values": [[0.5, 0.5], [0, 0]]},
        ],
        "design": {"kind": "grid"},
    }
    file.write_text(json.dumps(study))
    for folder, shard in (("whole", "1/1"), ("one", "1/2"), ("two", "2/2")):
        program("sweep", file, "--out", tmp_path / folder, "--shard", shard, "--quiet")
        program("sweep", "merge", tmp_path / folder, "--partial", "--quiet")
    convert = runpy.run_path(str(root / "python/examples/sweep_to_parquet.py"))["main"]
    convert(tmp_path / "all.parquet", tmp_path / "one", tmp_path / "two")
    convert(tmp_path / "whole.parquet", tmp_path / "whole")
    table = polars.read_parquet(tmp_path / "all.parquet")
    whole = polars.read_parquet(tmp_path / "whole.parquet")
    assert set(table.columns) == set(whole.columns) and table.equals(whole.select(table.columns))
    assert table["member"].to_list() == [0, 1, 2, 3]
    text = csv.DictReader((tmp_path / "whole/table.csv").read_text().splitlines())
    for row, line in zip(table.iter_rows(named=True), text):
        assert {name for name, value in row.items() if value is not None} == {name for name, value in line.items() if value}
        assert row["input.target.distance_m"] == float(line["input.target.distance_m"])
    assert [failure is None for failure in table["failure"]] == [True, True, True, False]
    assert "inside part 0 of the target" in table["failure"][3] and table["verdict"][3] is None
    known = polars.read_parquet_metadata(tmp_path / "all.parquet")
    assert json.loads(known["scene"])["duration_s"] == 0.9 and "sweep" in json.loads(known["provenance"])["command"]


@pytest.mark.parametrize("library", ["pandas", "polars"])
def test_tables_are_data_frames_where_there_is_a_library(scene, library):
    pytest.importorskip(library)
    members = tumblenet.rollout(scene, [{"duration_s": 0.05, "target.mass_kg": 3}, {"target.mass_kg": -3}])
    frame = members.frame(library)
    assert type(frame).__module__.startswith(library)
    assert list(frame.columns) == list(members.table()) and len(frame) == 2
    assert list(frame["input.target.mass_kg"]) == [3, -3]
    # What is missing is None in polars, NaN in pandas.
    assert not isinstance(frame["failure"][0], str) and "found -3" in frame["failure"][1]
    with pytest.raises(ValueError, match="library"):
        members.frame("excel")


def test_arguments_are_checked(scene):
    for wrong, match in (
        (lambda: tumblenet.rollout(scene, {"a": [1], "b": [1, 2]}), "different lengths"),
        (lambda: tumblenet.rollout(scene, [{}], threads=0), "threads"),
        (lambda: tumblenet.ensemble(scene, 2, perturb_m=-1.0), "perturb_m"),
        (lambda: tumblenet.ensemble(scene, 2, perturb_m=10.0), "perturb"),
    ):
        with pytest.raises(ValueError, match=match):
            wrong()
    assert len(tumblenet.rollout(scene, [])) == 0


def test_an_interrupt_ends_a_batch(scene, interruptible):
    threading.Timer(0.2, signal.raise_signal, [signal.SIGINT]).start()
    with pytest.raises(KeyboardInterrupt):
        tumblenet.rollout(scene, [{}] * 5000)

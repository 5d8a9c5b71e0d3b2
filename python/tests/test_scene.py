"""Scenes: found, changed, refused."""

import copy
import json
import pickle
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import numpy as np
import pytest
import tumblenet
from tumblenet import Scene, SceneError


def test_changes_may_be_a_dict_or_keywords():
    one = Scene("cubesat-free", {"target.mass_kg": 5, "target.spin_rad_s.0": 0.5})
    same = Scene("cubesat-free", {"target.spin_rad_s.0": np.float64(0.5)}, target__mass_kg=np.int64(5))
    assert one.hash == same.hash != Scene("cubesat-free").hash
    assert one.to_dict()["target"]["mass_kg"] == 5
    assert Scene(one, target__mass_kg=6).to_dict()["target"]["spin_rad_s"] == [0.5, 0, 0]
    assert Scene(one, {"effects.friction": {"coefficient": np.array(0.3)}}).hash != one.hash


def test_a_scene_is_a_name_a_path_or_a_dict(tmp_path):
    named = Scene("cubesat-free")
    file = tmp_path / "own.json"
    file.write_text(named.json)
    written = Scene(file)
    assert (written.name, written.hash) == ("own", named.hash)
    assert Scene(named.to_dict()).hash == Scene(str(file)).hash == named.hash
    assert json.loads(named.json) == named.to_dict()


def test_every_built_in_scene_is_what_the_program_shows(program):
    names = tumblenet.scenes()
    assert len(names) > 20
    for name in names[::8]:
        assert json.loads(program("show", name, "--json")) == Scene(name).to_dict()


def test_all_faults_of_a_scene_come_at_once():
    with pytest.raises(SceneError) as caught:
        Scene("cubesat-free", {"target.mass_kg": -1, "net.bulet_mass_kg": 1, "launch.speed_m_s": float("nan")})
    faults = {fault.place: fault for fault in caught.value.faults}
    assert set(faults) == {"target.mass_kg", "net.bulet_mass_kg", "launch.speed_m_s"}
    assert faults["target.mass_kg"].found == "-1"
    assert "above 0" in faults["target.mass_kg"].allowed
    assert all(place in str(caught.value) for place in faults)
    assert isinstance(caught.value, ValueError)


@pytest.mark.parametrize("scene", ["no-such-scene", {}, {"title": 3}, {"net": object}, "", 5, None])
def test_what_is_no_scene_is_refused(scene):
    with pytest.raises((SceneError, TypeError)) as caught:
        Scene(scene)
    assert str(caught.value)


def test_shapes():
    scene = Scene("cubesat-free")
    assert scene.cables.shape[1] == 2 and scene.cables.max() < scene.n_knots
    assert scene.masses.shape == (scene.n_knots,) and (scene.masses > 0).all()
    assert scene.bullets.shape == (4,) and scene.cables.dtype == scene.bullets.dtype == np.int64
    assert scene.duration > scene.time_step > 0
    assert repr(scene) == f'Scene("cubesat-free", hash="{scene.hash}")'


def test_limits_are_raised_and_lowered_by_name():
    scene = Scene("cubesat-free")
    few = {"net.meshes": [400, 400], "net.mesh_length_m": 0.002, "output.sample_s": 1, "duration_s": 0.01}
    with pytest.raises(SceneError, match="knots") as caught:
        Scene(scene, few, limits={"knots": 1000})
    assert "at most 1000 knots" in str(caught.value)
    lowered = Scene(scene, limits={"knots": 122.0})
    assert lowered.limits["knots"] == 122 and scene.limits["knots"] == 250_000
    # They stay with the scene.
    with pytest.raises(SceneError, match="at most 122 knots"):
        Scene(lowered, few)
    two = Scene(scene, limits={"members": 2})
    assert tumblenet.rollout(two, [{"duration_s": 0.4}] * 2).failures == [None, None]
    with pytest.raises(SceneError, match="at most 2 members"):
        tumblenet.rollout(two, [{}] * 3)
    for wrong in ({"knot": 5}, {"knots": -1}, {"knots": "many"}):
        with pytest.raises(SceneError, match="limits: 1 fault"):
            Scene(scene, limits=wrong)


def test_a_file_outside_is_read_on_request(tmp_path):
    (tmp_path / "inner").mkdir()
    shape = {"title": "a box", "parts": [{"cuboid": [0.1, 0.1, 0.1]}]}
    (tmp_path / "box.json").write_text(json.dumps(shape))
    scene = Scene("cubesat-free").to_dict()
    scene["target"]["shape"] = "../box.json"
    file = tmp_path / "inner" / "scene.json"
    file.write_text(json.dumps(scene))
    with pytest.raises(SceneError, match="target.shape"):
        Scene(file)
    assert Scene(file, allow_outside=True).name == "scene"


def end(scene):
    return tumblenet.run(scene).state_hash


def test_a_scene_is_pickled_with_its_files_and_limits(tmp_path, monkeypatch):
    (tmp_path / "box.json").write_text(json.dumps({"title": "a box", "parts": [{"cuboid": [0.1, 0.2, 0.1]}]}))
    scene = Scene("cubesat-free").to_dict()
    scene["target"]["shape"] = "box.json"
    monkeypatch.chdir(tmp_path)
    one = Scene(scene, {"launch.speed_m_s": 1.8 + 1e-15}, limits={"members": 3})
    pickled, ended = pickle.dumps(one), end(Scene(one, duration_s=0.4))
    monkeypatch.chdir("/")
    again = pickle.loads(pickled)
    assert (again.name, again.hash, again.limits) == (one.name, one.hash, one.limits)
    assert end(Scene(again, duration_s=0.4)) == ended
    assert copy.deepcopy(again).hash == one.hash
    (tmp_path / "box.json").unlink()
    with pytest.raises(SceneError, match="target.shape"):
        pickle.loads(pickled)


def test_a_scene_goes_to_another_process():
    scenes = [Scene("cubesat-free", duration_s=0.4, target__mass_kg=mass) for mass in (1.0, 2.0)]
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        assert list(pool.map(end, scenes)) == [end(scene) for scene in scenes]


def test_what_is_not_pickled_says_what_to_send_instead():
    scene = Scene("cubesat-free", duration_s=0.4)
    result, members = tumblenet.run(scene), tumblenet.rollout(scene, [{}])
    for thing, instead in ((result, "scene"), (members, "table"), (tumblenet.Simulation(scene), "scene")):
        with pytest.raises(TypeError, match=f"a {type(thing).__name__} is not pickled.*{instead}"):
            pickle.dumps(thing)
    assert (pickle.loads(pickle.dumps(result.positions)) == result.positions).all()
    with pytest.raises(SceneError) as caught:
        Scene("cubesat-free", {"target.mass_kg": -1})
    again = pickle.loads(pickle.dumps(caught.value))
    assert str(again) == str(caught.value) and again.faults == caught.value.faults

"""Scenes: found, changed, refused."""

import json

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

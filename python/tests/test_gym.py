"""Closing control as an environment: gymnasium's own check, the bits of an ensemble's member, reward, ends."""

import runpy
import sys

import numpy as np
import pytest
import tumblenet

gymnasium = pytest.importorskip("gymnasium")

from gymnasium.utils.env_checker import check_env  # noqa: E402
from tumblenet.gym import OBSERVATION, ClosingControl, ClosingControlVector, default_scene  # noqa: E402

WAIT, CLOSE = np.array([0.0, 1.0]), np.array([1.0, 1.0])
SHORT = {"dt": 0.1, "at_most": 1.5}


@pytest.fixture(scope="module")
def scene():
    """Ends while the net closes."""
    return tumblenet.Scene(default_scene(), {"duration_s": 1.5, "capture.hold_s": 0.1})


def flown(env, policy, seed, **options):
    """Observations, rewards, and what the last step said, of an episode."""
    seen, rewards = [env.reset(seed=seed, **options)[0]], []
    while True:
        observation, reward, over, cut_off, info = env.step(policy(seen[-1]))
        seen.append(observation)
        rewards.append(reward)
        if over or cut_off:
            return np.array(seen), np.array(rewards), (over, cut_off, info)


def at_contact(observation):
    return CLOSE if observation[OBSERVATION.index("has_met")] else WAIT


def test_gymnasium_finds_nothing_to_complain_of():
    # Warnings are errors here.
    check_env(gymnasium.make("tumblenet/ClosingControl-v0", disable_env_checker=True).unwrapped, skip_render_check=True)
    assert isinstance(gymnasium.make_vec("tumblenet/ClosingControl-v0", num_envs=2).unwrapped, ClosingControlVector)


def test_an_episode_without_an_action_is_a_member_of_the_ensemble(scene):
    env = ClosingControl(scene, **SHORT)
    flown(env, lambda _: WAIT, seed=None, options={"episode": 7})
    never = {"effects.closing.trigger": {"on": "time", "at_s": 1e9}}
    members = tumblenet.ensemble(tumblenet.Scene(scene, never), 1, seed=7, frames=True).members
    alone, result = members.results[0], env.result()
    assert result.state_hash == alone.state_hash
    np.testing.assert_array_equal(result.curves["enclosed"], alone.curves["enclosed"])
    _, info = env.reset(options={"episode": 7})
    assert info["seed"] == 7
    assert {f"drawn.{name}": [text] for name, text in info["drawn"].items()} == members.inputs


def test_the_same_seed_has_the_same_bits_one_by_one_and_at_once(scene):
    alone = [flown(ClosingControl(scene, **SHORT), at_contact, seed) for seed in (3, 4, 5)]
    again = flown(ClosingControl(scene, **SHORT), at_contact, 4)
    for one, other in zip(alone[1][:2], again[:2]):
        np.testing.assert_array_equal(one, other)
    for threads in (1, 2):
        env = ClosingControlVector(3, scene, **SHORT, threads=threads, autoreset=False)
        seen, infos = env.reset(seed=3)
        assert list(infos["seed"]) == [env.reset(seed=3)[1]["seed"][i] for i in range(3)]
        for step in range(1, len(alone[0][0])):
            seen, rewards, over, cut_off, infos = env.step(np.array([at_contact(row) for row in seen]))
            for i, (alone_seen, alone_rewards, _) in enumerate(alone):
                np.testing.assert_array_equal(seen[i], alone_seen[step])
                assert rewards[i] == alone_rewards[step - 1]
        assert cut_off.all() and list(infos["verdict"]) == [end[2]["verdict"] for _, _, end in alone]
        # Over is over: nothing moves, nothing is worth anything.
        after, rewards, *_ = env.step(np.array([CLOSE] * 3))
        np.testing.assert_array_equal(after, seen)
        assert not rewards.any()


def test_what_is_over_begins_anew_in_the_step_after(scene):
    env = ClosingControlVector(2, scene, dt=0.5, at_most=1.5)
    env.reset(seed=1)
    actions = np.array([WAIT] * 2)
    for _ in range(3):
        seen, _, _, cut_off, _ = env.step(actions)
    assert cut_off.all() and (seen[:, 0] == 1.5).all()
    seen, rewards, over, cut_off, infos = env.step(actions)
    assert (seen[:, 0] == 0).all() and not rewards.any() and not over.any() and not cut_off.any()
    assert len(set(infos["seed"])) == 2 and set(infos["seed"]) != set(env.reset(seed=1)[1]["seed"])


def test_the_observation_is_what_the_run_shows(scene):
    env = ClosingControl(scene, **SHORT)
    seen, _, _ = flown(env, at_contact, seed=1)
    assert all(row in env.observation_space for row in seen)
    result, column = env.result(), dict(zip(OBSERVATION, seen.T))
    at = np.searchsorted(result.time, column["time_s"] - 1e-9)
    masses, bullets = env._flights.scene.masses, env._flights.scene.bullets
    net = result.positions[at] @ np.array([1, 0, 0]) @ masses / masses.sum()
    np.testing.assert_allclose(column["distance_m"], result.target.position[at, 0] - net, atol=1e-12)
    past = result.positions[at][:, bullets, 0].min(axis=1) - result.target.position[at, 0]
    np.testing.assert_allclose(column["bullets_past_m"], past, atol=1e-12)
    np.testing.assert_allclose(column["mouth"], result.curves["mouth"][at], atol=1e-12)
    np.testing.assert_allclose(column["target_rate_rad_s"], np.linalg.norm(result.target.rate[at], axis=1))
    assert 0.3 < column["area_m2"].max() < 0.5 and column["approach_m_s"][0] > 1
    # The largest tension since the look before, though every frame is a look of its own.
    threads = [name for name in result.readings if name.endswith("_tension_n")]
    tension = np.max([result.readings[name] for name in threads], axis=0)
    largest = [tension[i + 1 : j + 1].max() for i, j in zip(at, at[1:])]
    np.testing.assert_allclose(column["tension_n"][1:], largest)
    assert 0.5 < max(largest) <= 1 + 1e-12
    assert (np.diff(column["off_reels_m"]) <= 0).all() and column["off_reels_m"][-1] < 0.5 * column["off_reels_m"][0]


def test_the_reward_is_held_less_the_price_of_work(scene):
    for price in (0.0, 2.0):
        env = ClosingControl(scene, **SHORT, price_of_work=price)
        _, rewards, (over, cut_off, info) = flown(env, at_contact, seed=1)
        assert info["held"] and cut_off and not over and info["work_j"] > 0.1
        assert rewards.sum() == pytest.approx(1 - price * info["work_j"], rel=1e-12)
        numbers = env.result().summary["closing"]
        assert info["work_j"] == pytest.approx(numbers["winch_work_j"], rel=1e-12)
    # Before anything can be held the thread shuts the mouth.
    _, rewards, (_, _, info) = flown(env, lambda _: CLOSE, seed=1)
    assert not info["held"] and rewards.sum() < 0


def test_a_slower_reel_is_slower(scene):
    env = ClosingControl(scene, **SHORT)
    ends = [flown(env, lambda seen, reel=reel: np.array([at_contact(seen)[0], reel]), 1)[0] for reel in (1.0, 0.2, 0.0)]
    off = [seen[-1, OBSERVATION.index("off_reels_m")] for seen in ends]
    # Held at no speed at all, the thread is as long as it was when the winches started: stretched by a hair.
    assert off[0] < off[1] < off[2] == pytest.approx(ends[2][0, OBSERVATION.index("off_reels_m")], rel=1e-3)


def test_an_episode_ends_when_it_is_settled():
    env = ClosingControl(tumblenet.Scene(default_scene(), {"uncertain": None}), dt=0.1, at_most=20)
    seen, _, (over, cut_off, info) = flown(env, at_contact, seed=1)
    assert over and not cut_off and info["verdict"] == "held_settled" and seen[-1, 0] < 10
    with pytest.raises(gymnasium.error.ResetNeeded):
        env.step(WAIT)


def test_the_example_sets_ways_beside_each_other(root, scene, monkeypatch, capsys):
    main = runpy.run_path(str(root / "python/examples/closing_control.py"))["main"]
    few = {way: (make, choices[:1]) for way, (make, choices) in main.__globals__["WAYS"].items()}
    for name, value in {"WAYS": few, "scene": lambda dispersion: scene}.items():
        monkeypatch.setitem(main.__globals__, name, value)
    monkeypatch.setattr(sys, "argv", ["closing_control.py", "--tune", "2", "--fresh", "3", "--seconds", "1.5"])
    main()
    rows = [line.split(" | ") for line in capsys.readouterr().out.splitlines() if " of 3 " in line]
    assert [row[0].removeprefix("| ") for row in rows] == list(few)
    work = [float(row[5]) for row in rows]
    assert work[0] == 0 and min(work[1:]) > 0.1 and all(0 <= float(row[6]) <= 1 for row in rows)


def test_faults_are_told():
    with pytest.raises(ValueError, match="effects.closing"):
        ClosingControl("cubesat-free")
    for wrong in ({"dt": 0.0}, {"at_most": -1.0}, {"at_most": 2.9}, {"at_most": 1e9}, {"price_of_work": float("nan")}, {"perturb_m": 1.0}):
        with pytest.raises(ValueError, match=next(iter(wrong)).split("_m")[0]):
            ClosingControl(**wrong)
    env = ClosingControl()
    env.reset(seed=1)
    with pytest.raises(ValueError, match="from 0 to 1"):
        env.step(np.array([np.nan, 1]))
    with pytest.raises(ValueError, match="episodes"):
        ClosingControlVector(2).reset(options={"episodes": [1]})

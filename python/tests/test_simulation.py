"""Step by step: the state, and what a simulation is told."""

import numpy as np
import pytest
import tumblenet
from tumblenet import ControlError, Scene, Simulation

NEVER = {"effects.closing.trigger": {"on": "time", "at_s": 1e9}}


def test_stepping_has_the_bits_of_a_run(capture):
    scene, result = capture
    simulation = Simulation(scene)
    while simulation.time < scene.duration - 0.5 * scene.time_step:
        simulation.step(0.0375)
    assert simulation.state_hash == result.state_hash
    np.testing.assert_array_equal(simulation.positions, result.positions[-1])
    np.testing.assert_array_equal(simulation.velocities, result.velocities[-1])
    np.testing.assert_array_equal(simulation.target.attitude, result.target.attitude[-1])
    assert simulation.energy["elastic"] == result.energy["elastic"][-1]
    assert simulation.tension.shape == (len(scene.cables),)


def test_without_dt_it_takes_one_step():
    simulation = Simulation("cubesat-free")
    simulation.step()
    assert simulation.time == simulation.time_step
    for wrong in (0.0, -1.0, float("nan"), float("inf")):
        with pytest.raises(ValueError, match="dt"):
            simulation.step(wrong)
    assert simulation.time == simulation.time_step


def test_contacts_push_the_net_away_from_the_target():
    simulation = Simulation("cubesat-spin-x-2.0")
    while not len(simulation.contacts["knot"]) and simulation.time < 1.5:
        simulation.step()
    contacts = simulation.contacts
    n = len(contacts["knot"])
    assert n > 0 and contacts["point"].shape == contacts["normal"].shape == contacts["friction"].shape == (n, 3)
    np.testing.assert_allclose(np.linalg.norm(contacts["normal"], axis=1), 1, rtol=1e-12)
    assert (contacts["impulse"] >= 0).all() and contacts["gap"].shape == (n,)
    away = contacts["point"] - simulation.target.position
    assert (np.sum(away * contacts["normal"], axis=1) > 0).all()


def test_a_loop_commands_the_winches():
    scene = Scene("cubesat-spin-x-2.0-tube", NEVER)
    simulation = Simulation(scene)
    first, started, tension = simulation.readings["thread_1_off_reels_m"], None, 0.0
    while simulation.time < 1.5:
        controls = None
        if (simulation.positions[scene.bullets, 0] > simulation.target.position[0]).all():
            started = started if started is not None else simulation.time
            gentle = simulation.time < started + 0.1
            controls = {"winch": {"reel_speed_m_s": 0.5, "max_tension_n": 0.1 if gentle else 0.5}}
        simulation.step(0.01, controls)
        tension = max(tension, simulation.readings["thread_1_tension_n"])
    assert started is not None
    assert simulation.readings["thread_1_off_reels_m"] < first - 0.05
    assert 0.1 < tension <= 0.5 * (1 + 1e-12)


def test_a_recorded_simulation_has_the_result_of_a_run(capture):
    scene, result = capture
    simulation = Simulation(scene, record=True)
    simulation.step(0.5123)
    # Not at a frame: what is there so far ends with the state as it is.
    assert simulation.result().time[-1] == simulation.time and simulation.result().state_hash == simulation.state_hash
    simulation.step(scene.duration - simulation.time)
    recorded = simulation.result()
    assert recorded.state_hash == result.state_hash
    np.testing.assert_array_equal(recorded.positions, result.positions)
    np.testing.assert_array_equal(recorded.curves["mouth"], result.curves["mouth"])
    machine = ("wall_s", "time_shares")
    told, run = ({name: row for name, row in one.summary.items() if name not in machine} for one in (recorded, result))
    assert told == run
    with pytest.raises(ValueError, match="record"):
        Simulation(scene).result()


def test_a_look_has_the_largest_tension_since_the_last_also_when_recorded():
    tensions = []
    for record in (False, True):
        simulation, seen = Simulation("cubesat-spin-x-2.0-tube", record=record), []
        while simulation.time < 1.2:
            simulation.step(0.03)
            seen.append(simulation.readings["thread_1_tension_n"])
        tensions.append(seen)
    assert tensions[0] == tensions[1] and max(tensions[0]) > 0.1


def test_thrust_on_a_free_target_is_newtons_law():
    scene = Scene("cubesat-free")
    mass = scene.to_dict()["target"]["mass_kg"]
    simulation = Simulation(scene, thrust=True)
    before = simulation.target.velocity
    simulation.step(0.1, {"target": {"force_n": [0, 0.3, 0]}})
    np.testing.assert_allclose(simulation.target.velocity - before, [0, 0.3 * 0.1 / mass, 0], rtol=1e-9, atol=1e-15)
    # Thrust holds until it is told anew; None ends it.
    simulation.step(0.1)
    np.testing.assert_allclose(simulation.target.velocity[1], 0.3 * 0.2 / mass, rtol=1e-9)
    simulation.step(0.1, {"target": None})
    np.testing.assert_allclose(simulation.target.velocity[1], 0.3 * 0.2 / mass, rtol=1e-9)
    kinetic = simulation.energy["work_of_thrust"]
    assert kinetic == pytest.approx(0.5 * mass * simulation.target.velocity[1] ** 2, rel=1e-9)


def test_thrust_in_the_body_frame_turns_with_the_body():
    scene = Scene("cubesat-spin-x-2.0", {"target.spin_rad_s": [0, 0, 2]})
    simulation = Simulation(scene, thrust=True)
    force, mass = np.array([0.0, 0.2, 0.0]), scene.to_dict()["target"]["mass_kg"]
    velocity = np.zeros(3)
    simulation.step(controls={"target": {"force_n": force, "frame": "body"}})
    while simulation.time < 0.5:
        w, *v = simulation.target.attitude
        turned = force + 2 * np.cross(v, np.cross(v, force) + w * force)
        velocity += turned * simulation.time_step / mass
        simulation.step()
    assert np.linalg.norm(velocity) > 0.01
    np.testing.assert_allclose(simulation.target.velocity, velocity, atol=1e-2 * np.linalg.norm(velocity))


def test_thrust_moves_a_free_chaser():
    simulation = Simulation("cubesat-chaser", thrust=True)
    other = Simulation("cubesat-chaser", thrust=True)
    simulation.step(0.1, {"chaser": {"force_n": [-1, 0, 0], "torque_n_m": [0, 0.1, 0]}})
    other.step(0.1)
    assert simulation.chaser.velocity[0] < other.chaser.velocity[0]
    assert simulation.chaser.rate[1] > other.chaser.rate[1]


def test_all_faults_of_controls_come_at_once_and_nothing_is_done():
    simulation = Simulation("cubesat-spin-x-2.0-tube", thrust=True)
    with pytest.raises(ControlError) as caught:
        simulation.step(
            controls={
                "winch": {"start": "now", "reel_speed_m_s": -1},
                "target": {"force_n": [1, 2], "frame": "orbit"},
                "chaser": {"force_n": [1, 0, 0]},
                "cut": [3],
            }
        )
    places = {fault.place for fault in caught.value.faults}
    assert places == {
        "winch.start", "winch.reel_speed_m_s", "winch.max_tension_n", "target.force_n", "target.frame", "chaser", "cut",
    }
    assert simulation.time == 0
    with pytest.raises(ControlError, match="thrust=True"):
        Simulation("cubesat-free").step(controls={"target": {"force_n": [0, 0, 1]}})
    with pytest.raises(ControlError, match="effects.closing"):
        Simulation("cubesat-free").step(controls={"winch": {"reel_speed_m_s": 1, "max_tension_n": 1}})
    with pytest.raises(ControlError, match="a dict of"):
        simulation.step(controls=[1])


def test_thrusters_that_are_silent_change_nothing():
    plain, silent = Simulation("cubesat-free"), Simulation("cubesat-free", thrust=True)
    plain.step(0.3), silent.step(0.3)
    np.testing.assert_allclose(plain.positions, silent.positions, atol=1e-9)


def test_a_failed_run_says_why():
    # Far beyond what any method can follow.
    simulation = Simulation("cubesat-free", thrust=True)
    with pytest.raises(tumblenet.RunError) as caught:
        simulation.step(1.0, {"target": {"force_n": [1e300, 0, 0]}})
    with pytest.raises(tumblenet.RunError) as again:
        simulation.step()
    assert str(again.value) == str(caught.value)

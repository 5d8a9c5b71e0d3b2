"""What stepping from Python costs: calls of 1 ms that read the state, against one call for the whole time.

    python python/examples/overhead.py [SCENE] [REPEATS]

Processor time, least of the repeats, so that other work on the machine enters little.
"""

import sys
import time

import tumblenet

DT = 1e-3


def seconds(scene: tumblenet.Scene, dt: float, look: bool) -> float:
    simulation = tumblenet.Simulation(scene)
    controls = {"winch": {"start": False, "reel_speed_m_s": 0.5, "max_tension_n": 0.5}} if look else None
    began = time.process_time()
    while simulation.time < scene.duration - 0.5 * scene.time_step:
        simulation.step(dt, controls)
        if look:
            simulation.positions, simulation.velocities, simulation.target, simulation.readings
    return time.process_time() - began


def main(name: str = "cubesat-spin-x-2.0-tube", repeats: int = 9) -> None:
    pairs = {"joints+rapier": {}, "explicit+impulse": {"solver.cables": "explicit", "solver.contact": "impulse"}}
    for pair, changes in pairs.items():
        scene = tumblenet.Scene(name, {"duration_s": 1.0, **changes})
        ways = ((scene.duration, False), (DT, False), (DT, True))
        # In turn, so that a slow minute of the machine meets all of them.
        times = [[seconds(scene, dt, look) for dt, look in ways] for _ in range(repeats)]
        once, stepped, looked = (min(column) for column in zip(*times))
        print(
            f"{pair}: {once:.3f} s in one call; in calls of 1 ms {stepped / once - 1:+.1%}, "
            f"with controls, knots, target and threads at each {looked / once - 1:+.1%}"
        )


if __name__ == "__main__":
    main(*sys.argv[1:2], *map(int, sys.argv[2:3]))

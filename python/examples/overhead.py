"""What stepping from Python costs: calls of 1 ms, with and without a look at the state, against calls of 20 ms.

    python python/examples/overhead.py [SCENE] [REPEATS]

The same run again and again: of every 20 ms of it the least processor time counts, so that other work on the machine enters
little.
"""

import sys
import time

import tumblenet

CHUNK, DT = 0.02, 1e-3


def chunks(scene: tumblenet.Scene, dt: float, look: bool) -> list[float]:
    """Processor time of every 20 ms, in calls of `dt` [s]."""
    simulation = tumblenet.Simulation(scene)
    controls = {"winch": {"start": False, "reel_speed_m_s": 0.5, "max_tension_n": 0.5}} if look else None
    times = []
    for _ in range(round(scene.duration / CHUNK)):
        began = time.process_time()
        for _ in range(round(CHUNK / dt)):
            simulation.step(dt, controls)
            if look:
                simulation.positions, simulation.velocities, simulation.target, simulation.readings
        times.append(time.process_time() - began)
    return times


def main(name: str = "cubesat-spin-x-2.0-tube", repeats: int = 15) -> None:
    pairs = {"joints+rapier": {}, "explicit+impulse": {"solver.cables": "explicit", "solver.contact": "impulse"}}
    for pair, changes in pairs.items():
        scene = tumblenet.Scene(name, {"duration_s": 1.0, **changes})
        ways = ((CHUNK, False), (DT, False), (DT, True))
        # In turn, so that a slow minute of the machine meets all of them.
        runs = [[chunks(scene, dt, look) for dt, look in ways] for _ in range(repeats)]
        whole, stepped, looked = (sum(map(min, zip(*(run[way] for run in runs)))) for way in range(3))
        n_calls = scene.duration / DT
        print(f"{pair}: 1 ms takes {1e6 * whole / n_calls:.0f} us")
        for what, total in (("in calls of 1 ms", stepped), ("and a look at all with each", looked)):
            print(f"  {what}: {1e6 * (total - whole) / n_calls:+.1f} us, {total / whole - 1:+.1%}")


if __name__ == "__main__":
    main(*sys.argv[1:2], *map(int, sys.argv[2:3]))

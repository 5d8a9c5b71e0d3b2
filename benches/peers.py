"""The net of Table 3.2 in flight: this program beside others, in one run on one machine.

    python3 benches/peers.py target/release/tumblenet

prints a table (in Markdown) of processor time a simulated second and of the error of the bullets at 0.5 s, with machine and
versions. What is not installed is left out, with a word; `pip install numpy numba mujoco` has them all. Every program gets
the same net, from the arrays that a run writes. Of this program the time of a run of one step is taken off. The order of the
runs is gone through several times and the least time of each is taken: others' work on the machine only adds.
"""

import json
import os
import platform
import subprocess
import sys
import tempfile
import time

import numpy as np

END = 0.5  # s: until then neighbouring starts stay neighbours
ROUNDS = 30
EXPLICIT = ["solver.cables=explicit", "solver.contact=impulse"]
FINE = "solver.step_s=2e-6"


def tumblenet(program, changes, folder, end=END):
    """Processor time of a run of the program [s], and its folder's arrays and summary."""
    command = [program, "run", "deployment-kevlar", "--out", folder]
    for change in [*changes, f"duration_s={end}", f"output.sample_s={end}", "expect=null"]:
        command += ["--set", change]
    child = subprocess.Popen(command, stdout=subprocess.DEVNULL, env={**os.environ, "TUMBLENET_PROGRESS": "0s"})
    _, status, used = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    assert child.returncode == 0, command
    with open(os.path.join(folder, "summary.json")) as file:
        return used.ru_utime + used.ru_stime, dict(np.load(os.path.join(folder, "trajectory.npz"))), json.load(file)


def cables_of(program, run):
    """Stiffness and damping of each cable by Eq. 3.1 and 3.4, from what the scene says."""
    scene = json.loads(subprocess.run([program, "show", "deployment-kevlar", "--json"], check=True, capture_output=True).stdout)
    cable = scene["net"]["cable"]
    young_modulus = 130e9  # Table 3.1, Kevlar
    k = young_modulus * np.pi / 4 * cable["diameter_m"] ** 2 / run["rest_lengths"]
    lesser = run["masses"][run["cables"]].min(axis=1)
    return k, 2 * cable["damping_ratio"] * np.sqrt(lesser * k)


def numba_loop(run, k, c):
    """The loop that a user writes: semi-implicit Euler over the cables, compiled."""
    import numba

    @numba.njit(cache=False)
    def fly(x, v, mass, a, b, rest, k, c, h, n):
        force = np.zeros_like(x)
        for _ in range(n):
            force[:] = 0.0
            for i in range(len(a)):
                d0, d1, d2 = x[b[i], 0] - x[a[i], 0], x[b[i], 1] - x[a[i], 1], x[b[i], 2] - x[a[i], 2]
                length = np.sqrt(d0 * d0 + d1 * d1 + d2 * d2)
                if length > rest[i]:
                    rate = (d0 * (v[b[i], 0] - v[a[i], 0]) + d1 * (v[b[i], 1] - v[a[i], 1])
                            + d2 * (v[b[i], 2] - v[a[i], 2])) / length
                    pull = max(0.0, k[i] * (length - rest[i]) + c[i] * rate) / length
                    for j, d in enumerate((d0, d1, d2)):
                        force[a[i], j] += pull * d
                        force[b[i], j] -= pull * d
            for knot in range(len(mass)):
                for j in range(3):
                    v[knot, j] += h * force[knot, j] / mass[knot]
                    x[knot, j] += h * v[knot, j]

    a, b = run["cables"].T.copy()

    def timed(h):
        x, v = run["knots"][0].copy(), run["velocities"][0].copy()
        start = time.process_time()
        fly(x, v, run["masses"], a, b, run["rest_lengths"], k, c, h, round(END / h))
        return (time.process_time() - start) / END, x[run["bullets"]]

    timed(0.1)  # compiles
    return f"numba {numba.__version__}", timed


def mujoco_limits(run, _k, _c):
    """Cables as limits of tendons between free points, as stiff as it takes them at 1 ms and critically damped: with the
    cables' own stiffness and damping it leaves all numbers behind at 0.1 s."""
    import mujoco

    x, mass = run["knots"][0], run["masses"]
    bodies = "".join(
        f'<body pos="{p[0]} {p[1]} {p[2]}"><joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 1 0"/>'
        f'<joint type="slide" axis="0 0 1"/><site name="s{i}"/>'
        f'<inertial pos="0 0 0" mass="{mass[i]}" diaginertia="1e-6 1e-6 1e-6"/></body>'
        for i, p in enumerate(x))
    tendons = ""
    for (a, b), rest in zip(run["cables"], run["rest_lengths"]):
        tendons += (f'<spatial limited="true" range="0 {rest}" solreflimit="0.002 1">'
                    f'<site site="s{a}"/><site site="s{b}"/></spatial>')
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option gravity="0 0 0" timestep="0.001"/><worldbody>{bodies}</worldbody><tendon>{tendons}</tendon></mujoco>')
    data = mujoco.MjData(model)

    def timed(h):
        model.opt.timestep = h
        mujoco.mj_resetData(model, data)
        data.qvel[:] = run["velocities"][0].ravel()
        start = time.process_time()
        for _ in range(round(END / h)):
            mujoco.mj_step(model, data)
        return (time.process_time() - start) / END, (x + data.qpos.reshape(-1, 3))[run["bullets"]]

    return f"MuJoCo {mujoco.__version__}", timed


def main(program):
    with tempfile.TemporaryDirectory() as folder:
        _, run, summary = tumblenet(program, [*EXPLICIT, FINE], os.path.join(folder, "fine"))
        true = run["knots"][-1][run["bullets"]]
        k, c = cables_of(program, run)

        def own(number, *changes):
            place = os.path.join(folder, str(number))

            def timed():
                used, found, _ = tumblenet(program, changes, place)
                return used, found["knots"][-1][found["bullets"]]

            return timed

        runs = {
            "`explicit`, own step": own(0, *EXPLICIT),
            "`explicit`, 5e-5 s": own(1, *EXPLICIT, "solver.step_s=5e-5"),
            "`explicit`, 2e-5 s": own(2, *EXPLICIT, "solver.step_s=2e-5"),
            "`joints`, own step": own(3),
            "`joints`, 1 ms": own(4, "solver.step_s=1e-3"),
        }
        names = [f"tumblenet {summary['version']}"]
        for peer, steps, what in [(numba_loop, (5e-5, 2e-5), "compiled loop"), (mujoco_limits, (1e-3,), "tendon limits")]:
            try:
                name, timed = peer(run, k, c)
            except ImportError as missing:
                print(f"left out: {missing}", file=sys.stderr)
                continue
            names.append(name)
            for h in steps:
                runs[f"{name.split()[0]}, {what}, {h:g} s"] = lambda timed=timed, h=h: timed(h)
        best, errors, least = {}, {}, np.inf
        for _ in range(ROUNDS):
            least = min(least, tumblenet(program, EXPLICIT, os.path.join(folder, "least"), 5e-4)[0])
            for name, once in runs.items():
                seconds, bullets = once()
                best[name] = min(best.get(name, np.inf), seconds)
                errors[name] = np.linalg.norm(bullets - true, axis=1).max()
        for name in best:
            best[name] = (best[name] - least) / END if name.startswith("`") else best[name]
    first = best["`explicit`, own step"]
    with open("/proc/cpuinfo") as file:
        facts = dict(line.split(":", 1) for line in file.read().split("\n\n")[0].splitlines() if ":" in line)
    facts = {key.strip(): value.strip() for key, value in facts.items()}
    flags = facts.get("flags", "").split()
    vectors = next((name for name in ("avx512f", "avx2") if name in flags), "no avx2")
    print(f"{facts.get('model name', platform.machine())} ({vectors}), {os.cpu_count()} cores; {', '.join(names)}; Python {platform.python_version()}\n")
    print("| | s a simulated second | over `explicit` at its own step | error of the bullets at 0.5 s, m |\n|---|---|---|---|")
    for name, seconds in best.items():
        print(f"| {name} | {seconds:.4f} | {seconds / first:.2f} | {errors[name]:.1e} |")


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "target/release/tumblenet")

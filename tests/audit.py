#!/usr/bin/env python3
"""Checks runs of tumblenet from `trajectory.npz` and the scene file alone; shares no code with the program.

    audit.py check SCENE.json DIR      one run whose results are in DIR
    audit.py all PROGRAM [DIR]         built-in scenes under every pair, run for a short time and checked

Needs numpy. Everything is worked out anew: masses by Eq. 3.2, stiffness by Eq. 3.1, inertia from the parts
of the shape, energy, momentum, angular momentum, depth of knots in parts, knots that went through plates.

What must hold, and where:
- energy of net and target never rises above an earlier minimum by more than 1e-2 of the launch energy:
  without effects that put energy in, and with a target that is not driven;
- momentum to 1e-9 and angular momentum to 1e-3 of their scale: without effects from outside, with a
  free target or none;
- no knot deeper in a part than 1e-3 of the target's thinnest part, beyond what a penalty force needs;
- no knot through a plate (a cuboid thinner than a tenth of its other sides) that it was not through at first.

Energy is summed at the frames; between them it may rise and fall unseen. Parts that are point clouds or
meshes are left out, and their target's energy and momentum with them: the report says so. So are energy and
momentum of a net of elements (`ancf`), whose cables have coordinates that no file holds.
Exit status: 0 all held, 1 something did not, 2 something could not be read.
"""
import json
import os
import pathlib
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parent.parent
PAIRS = ["joints+rapier", "joints+impulse", "joints+penalty", "explicit+impulse", "explicit+penalty"]
ENERGY, MOMENTUM, ANGULAR, DEPTH = 1e-2, 1e-9, 1e-3, 1e-3
PENALTY_DEPTH = 2e-2
# A cinch is drawn by the chaser's tether.
FROM_OUTSIDE = {"cinch", "orbit", "cabin", "tug", "gravity", "drag", "field", "profile"}
PUT_IN = FROM_OUTSIDE | {"closing", "chaser"}


def asset(kind, value):
    """A named asset or what stands inline."""
    if isinstance(value, str):
        return json.loads((ROOT / "assets" / kind / f"{value}.json").read_text())
    return value


class Net:
    """Masses [kg] and cables from the scene (Eq. 3.1, 3.2)."""

    def __init__(self, spec, ends):
        n_y, n_z = (m + 1 for m in spec["meshes"])
        middle = spec.get("middle_knots", 0)
        side = spec["mesh_length_m"]
        sides = [side, side] if np.isscalar(side) else side
        inner, edge = dict(spec["cable"]), dict(spec["cable"])
        edge.update({k: v for k, v in (spec.get("edge_cable") or {}).items() if v is not None})
        self.ends = np.asarray(ends)
        n_grid, pieces = n_y * n_z, middle + 1
        n_knots = n_grid + middle * (len(ends) // pieces)
        self.mass = np.zeros(n_knots)
        self.radius = np.zeros(n_knots)
        self.rest = np.zeros(len(ends))
        self.stiffness = np.zeros(len(ends))
        for line in range(len(ends) // pieces):
            first, last = ends[line * pieces][0], ends[line * pieces + middle][1]
            (row, column), (row_2, column_2) = divmod(first, n_z), divmod(last, n_z)
            along = 0 if row != row_2 else 1
            on_edge = column in (0, n_z - 1) if along == 0 else row in (0, n_y - 1)
            cable = edge if on_edge else inner
            material = asset("materials", cable["material"])
            area = np.pi / 4 * cable["diameter_m"] ** 2
            length = sides[along] / pieces
            for piece in range(pieces):
                index = line * pieces + piece
                self.rest[index] = length
                self.stiffness[index] = material["young_modulus_pa"] * area / length
                for knot in ends[index]:
                    self.mass[knot] += 0.5 * material["density_kg_m3"] * area * length
                    self.radius[knot] = max(self.radius[knot], cable["diameter_m"] / 2)
        self.bullets = [0, (n_y - 1) * n_z, n_y * n_z - 1, n_z - 1]
        self.mass[self.bullets] = spec["bullet_mass_kg"]

    def energy(self, knots, velocities):
        kinetic = 0.5 * (self.mass * (velocities**2).sum(-1)).sum(-1)
        across = knots[:, self.ends[:, 1]] - knots[:, self.ends[:, 0]]
        stretch = np.maximum(np.linalg.norm(across, axis=-1) - self.rest, 0)
        return kinetic + 0.5 * (self.stiffness * stretch**2).sum(-1)


def turn(degrees):
    """Turns about the body's own x, then y, then z."""
    a, b, c = np.radians(degrees)
    x = np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])
    y = np.array([[np.cos(b), 0, np.sin(b)], [0, 1, 0], [-np.sin(b), 0, np.cos(b)]])
    z = np.array([[np.cos(c), -np.sin(c), 0], [np.sin(c), np.cos(c), 0], [0, 0, 1]])
    return x @ y @ z


def matrices(q):
    """Rotation matrices [T, 3, 3] of quaternions (w, x, y, z)."""
    w, x, y, z = q.T
    rows = [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]
    return np.array(rows).transpose(2, 0, 1)


class Part:
    """A solid: volume, inertia over mass, signed distance of points in its own frame."""

    def __init__(self, spec):
        self.position = np.array(spec.get("position_m", [0, 0, 0]), float)
        self.turn = turn(spec.get("attitude_deg", [0, 0, 0]))
        self.mass = spec.get("mass_kg")
        self.half = None
        if "cuboid" in spec:
            self.half = np.array(spec["cuboid"], float) / 2
            a, b, c = 2 * self.half
            self.volume, self.thinnest = a * b * c, min(a, b, c)
            moments = np.array([b * b + c * c, a * a + c * c, a * a + b * b]) / 12
        elif "ball" in spec:
            self.ball = spec["ball"]["radius_m"]
            self.volume, self.thinnest = 4 / 3 * np.pi * self.ball**3, 2 * self.ball
            moments = np.full(3, 0.4 * self.ball**2)
        elif "cylinder" in spec:
            r, l = spec["cylinder"]["radius_m"], spec["cylinder"]["length_m"]
            self.cylinder = r, l
            self.volume, self.thinnest = np.pi * r * r * l, min(2 * r, l)
            across = r * r / 4 + l * l / 12
            moments = np.array([across, r * r / 2, across])
        else:
            raise NotImplementedError("a part that is neither cuboid, ball nor cylinder")
        self.moments = np.diag(moments)

    def distance(self, points):
        if self.half is not None:
            q = np.abs(points) - self.half
            return np.linalg.norm(np.maximum(q, 0), axis=-1) + np.minimum(q.max(-1), 0)
        if hasattr(self, "ball"):
            return np.linalg.norm(points, axis=-1) - self.ball
        r, l = self.cylinder
        q = np.stack([np.hypot(points[..., 0], points[..., 2]) - r, np.abs(points[..., 1]) - l / 2], -1)
        return np.linalg.norm(np.maximum(q, 0), axis=-1) + np.minimum(q.max(-1), 0)


class Target:
    """Parts about their common centre of mass, mass and inertia."""

    def __init__(self, spec):
        shape = asset("shapes", spec["shape"])
        self.parts = [Part(part) for part in shape["parts"]]
        volume = sum(part.volume for part in self.parts)
        total = spec.get("mass_kg", shape.get("mass_kg", 1.0))
        own = sum(part.mass or 0 for part in self.parts)
        free = sum(part.volume for part in self.parts if part.mass is None)
        masses = [part.mass if part.mass is not None else (total - own) * part.volume / free for part in self.parts]
        self.mass = total if volume and free else own
        self.exact = all(part.mass is None for part in self.parts)
        masses = np.array(masses)
        self.centre = sum(m * part.position for m, part in zip(masses, self.parts)) / masses.sum()
        self.inertia = np.zeros((3, 3))
        for m, part in zip(masses, self.parts):
            d = part.position - self.centre
            self.inertia += m * (part.turn @ part.moments @ part.turn.T + d @ d * np.eye(3) - np.outer(d, d))
        self.inertia = np.array(spec.get("inertia_kg_m2", shape.get("inertia_kg_m2", self.inertia)), float)
        self.motion = spec.get("motion", "free")
        self.thinnest = min(part.thinnest for part in self.parts)

    def local(self, part, points, position, attitude):
        """Points [T, K, 3] of the local frame in the frame of a part."""
        body = np.einsum("tji,tkj->tki", attitude, points - position[:, None])
        return (body - (part.position - self.centre)) @ part.turn


def behind_plates(part, points):
    """Knots whose straight way from frame to frame leads through the middle plane of a plate, for good."""
    if part.half is None:
        return 0
    thin = int(np.argmin(part.half))
    others = [axis for axis in range(3) if axis != thin]
    if part.half[thin] > 0.1 * part.half[others].min():
        return 0
    height = points[..., thin]
    crosses = height[1:] * height[:-1] < 0
    share = height[:-1] / np.where(crosses, height[:-1] - height[1:], 1)
    at = points[:-1] + share[..., None] * (points[1:] - points[:-1])
    # One that rounds an edge between two frames crosses nearer to it than it moves.
    way = np.linalg.norm(points[1:] - points[:-1], axis=-1, keepdims=True)
    edge = part.half[others] - np.maximum(way, 0.05 * part.half[others])
    inside = (np.abs(at[..., others]) < edge).all(-1)
    # An even number of crossings leads back.
    return int(((crosses & inside).sum(0) % 2 == 1).sum())


def audit(scene, folder, contact):
    """What was found, and what of it does not hold."""
    run = np.load(folder / "trajectory.npz")
    knots, velocities = run["knots"], run["velocities"]
    net = Net(scene["net"], run["cables"].tolist())
    effects = {name for name, value in (scene.get("effects") or {}).items() if value is not None}
    if "closing" in effects and scene["effects"]["closing"]["layout"] == "cinch":
        effects.add("cinch")
    launch = net.energy(knots[:1], velocities[:1])[0] or 1.0
    momentum = (net.mass[:, None] * velocities).sum(1)
    scale = np.linalg.norm(momentum[0]) or 1.0
    turning = np.cross(knots, net.mass[:, None] * velocities).sum(1)
    energy = net.energy(knots, velocities)
    found, faults, left_out = {}, [], []
    spec = scene.get("target")
    free = True
    arm = 0.5 * np.sqrt(np.prod(scene["net"]["meshes"])) * np.max(scene["net"]["mesh_length_m"])
    if spec:
        try:
            target = Target(spec)
        except NotImplementedError as reason:
            target = None
            left_out.append(str(reason))
        if target:
            position, attitude = run["target_position"], matrices(run["target_attitude"])
            arm = np.linalg.norm(position[0])
            free = target.motion == "free"
            if free:
                rate = run["target_rate"]
                inertia = attitude @ target.inertia @ attitude.transpose(0, 2, 1)
                own = np.einsum("tij,tj->ti", inertia, rate)
                speed = run["target_velocity"]
                energy = energy + 0.5 * target.mass * (speed**2).sum(-1) + 0.5 * (rate * own).sum(-1)
                momentum = momentum + target.mass * speed
                turning = turning + target.mass * np.cross(position, speed) + own
            depth, behind = 0.0, 0
            for part in target.parts:
                points = target.local(part, knots, position, attitude)
                # The ball of a knot may be in the part by no more than its surface.
                depth = max(depth, float((net.radius - part.distance(points)).max()))
                behind += behind_plates(part, points)
            touched = int((np.abs(run["contact_impulses"]).sum((0, 2)) > 0).sum())
            found["touched"], found["depth_m"], found["behind_plates"] = touched, depth, behind
            allowed = (PENALTY_DEPTH if contact == "penalty" else DEPTH) * target.thinnest + 1e-6
            if depth > allowed:
                faults.append(f"a knot is {depth:.2e} m deep, at most {allowed:.2e} m is allowed")
            if behind:
                faults.append(f"{behind} knots are behind a plate")
        free = free and target is not None
    if json.loads((folder / "summary.json").read_text())["solver"]["cables"] == "ancf":
        left_out.append("energy and momentum: elements have coordinates that no file holds")
        return found, faults, left_out
    rise = float((energy - np.minimum.accumulate(energy)).max() / launch)
    found["energy_rise"] = rise
    driven = spec and spec.get("motion") == "spinning"
    if not effects & PUT_IN and not driven and not left_out and not rise <= ENERGY:
        faults.append(f"energy rises by {rise:.2e} of the launch energy, at most {ENERGY:g} is allowed")
    if free and not effects & FROM_OUTSIDE and "chaser" not in effects:
        lost = float(np.abs(momentum - momentum[0]).max() / scale)
        turned = float(np.abs(turning - turning[0]).max() / (scale * arm + np.linalg.norm(turning[0])))
        found["momentum"], found["angular_momentum"] = lost, turned
        if not lost <= MOMENTUM:
            faults.append(f"momentum changes by {lost:.2e}, at most {MOMENTUM:g} is allowed")
        if not turned <= ANGULAR:
            faults.append(f"angular momentum changes by {turned:.2e}, at most {ANGULAR:g} is allowed")
    return found, faults, left_out


# A coarse net, nearly open and near: the same bodies, spins and effects in a hundredth of the time.
NEAR = ["net.meshes=[4,4]", "net.mesh_length_m=0.16", "net.fold.ratio=0.8", "target.distance_m=0.2",
        "launch.angle_deg=10", "duration_s=0.3"]
SCENES = [
    ("deployment-kevlar", ["net.meshes=[6,6]", "duration_s=0.6"]),
    ("deployment-kevlar", ["net.cable.damping_ratio=0", "net.meshes=[5,5]", "duration_s=0.6"]),
    *((name, NEAR) for name in [
        "cubesat-free", "cubesat-spin-x-0.5", "cubesat-spin-x-1.0", "cubesat-spin-x-1.5", "cubesat-spin-x-2.0",
        "cubesat-spin-x-2.0-tube", "cubesat-spin-x-2.0-cinch", "cubesat-spin-x-2.0-interlaced", "cubesat-spin-x-2.0-free",
        "cubesat-spin-z-2.0", "cubesat-spin-z-2.0-tube", "cubesat-chaser", "cubesat-orbit-700km", "cube-fixed",
        "ball-fixed", "cylinder-fixed", "envisat-mockup-fixed", "envisat-mockup-cabin"]),
]


# What is known not to hold, by the words of its fault.
KNOWN = {
    ("ball-fixed", "joints+penalty"): (
        "the method created",
        "a plane stands for the ball between two detections, and the bullet is 0.2 mm deeper in the next one"),
}


def changed(scene, changes):
    """The scene with values set by path, as `--set` does."""
    scene = json.loads(json.dumps(scene))
    for path, value in (change.split("=", 1) for change in changes):
        *way, key = path.split(".")
        at = scene
        for step in way:
            at = at.setdefault(step, {})
        try:
            at[key] = json.loads(value)
        except ValueError:
            at[key] = value
        if at[key] is None:
            del at[key]
    return scene


def one(program, name, changes, pair, folder):
    """Runs a scene under a pair and audits it; the faults."""
    cables, contact = pair.split("+")
    scene = json.loads((ROOT / "scenarios" / f"{name}.json").read_text())
    scene = changed(scene, [*changes, f"solver.cables={cables}", f"solver.contact={contact}", "expect=null"])
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "scene.json").write_text(json.dumps(scene))
    arguments = [str(program), "run", str(folder / "scene.json"), "--out", str(folder)]
    done = subprocess.run(arguments, capture_output=True, text=True)
    if done.returncode == 0:
        found, faults, left_out = audit(scene, folder, contact)
    else:
        found, faults, left_out = {}, [f"exit status {done.returncode}: {done.stderr.strip()[:300]}"], []
    words, reason = KNOWN.get((name, pair), (None, None))
    if words is None:
        return found, faults, left_out
    if any(words in fault for fault in faults):
        return found, [], [*left_out, f"known: {reason}"]
    return found, faults, [*left_out, f"not found this time, though known: {reason}"]


def main(arguments):
    if len(arguments) == 3 and arguments[0] == "check":
        folder = pathlib.Path(arguments[2])
        contact = json.loads((folder / "summary.json").read_text())["solver"]["contact"]
        results = [(arguments[1], audit(json.loads(pathlib.Path(arguments[1]).read_text()), folder, contact))]
    elif len(arguments) in (2, 3) and arguments[0] == "all":
        results = []
        with tempfile.TemporaryDirectory() as scratch, ThreadPoolExecutor(os.cpu_count()) as threads:
            folder = pathlib.Path(arguments[2] if len(arguments) == 3 else scratch)
            runs = [(f"{number} {name} {pair}", name, changes, pair)
                    for number, (name, changes) in enumerate(SCENES) for pair in PAIRS]
            waiting = [(title, threads.submit(one, arguments[1], name, changes, pair, folder / title.replace(" ", "-")))
                       for title, name, changes, pair in runs]
            for title, outcome in waiting:
                results.append((title, outcome.result()))
                report(*results[-1])
        bad = sum(bool(faults) for _, (_, faults, _) in results)
        print(f"{len(results)} runs, {bad} with a fault")
        return 1 if bad else 0
    else:
        print(__doc__, file=sys.stderr)
        return 2
    for result in results:
        report(*result)
    return 1 if any(faults for _, (_, faults, _) in results) else 0


def report(name, outcome):
    found, faults, left_out = outcome
    numbers = "  ".join(f"{key} {value:.2g}" for key, value in found.items())
    print(f"{name}: {numbers}" + "".join(f"\n  left out: {reason}" for reason in left_out)
          + "".join(f"\n  FAULT: {fault}" for fault in faults), flush=True)


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1:]))
    except (OSError, KeyError, ValueError) as error:
        print(f"audit: {error!r}", file=sys.stderr)
        sys.exit(2)

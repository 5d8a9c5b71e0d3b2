#!/usr/bin/env python3
"""The captures of the source watched on, as a table: `python3 benches/findings.py target/release/tumblenet`.

Every capture scene at the source's time, and on until its verdict is decided, at most ten times as long: touching with knots
alone as in the source, with friction, with whole cables, and with both. A row that is there already is not run again.
"""

import argparse
import json
import subprocess
import sys
from pathlib import Path

# The time at which the source judges, members a row by pair, and what the source says of the scene (True: captured).
FAMILIES = {
    "cubesat": (3.0, {"explicit+impulse": 8, "joints+rapier": 4}),
    "stage": (10.0, {"explicit+impulse": 4, "joints+rapier": 1}),
    "envisat": (15.0, {"explicit+impulse": 2, "joints+rapier": 1}),
}
SOURCE = {
    "cubesat-free": True, "cubesat-spin-x-1.0": True, "cubesat-spin-x-1.5": True, "cubesat-spin-x-2.0": False,
    "cubesat-spin-x-2.0-tube": True, "cubesat-spin-z-2.0-tube": True,
    "stage-free": True, "stage-spin-x-0.1": True, "stage-spin-x-0.4": True, "stage-spin-x-0.7": False,
    "stage-spin-z-0.1": True, "stage-spin-z-0.4": True, "stage-spin-z-0.7": False,
    "stage-spin-x-1.1-tube": True, "stage-spin-z-1.1-tube": True,
    "envisat-free": True, "envisat-spin-x-0.1": True, "envisat-spin-x-1.0": True, "envisat-spin-x-0.5-tube": True,
}
CONTACTS = {
    "knots": [],
    "knots, friction 0.3": ["effects.friction={\"coefficient\":0.3}"],
    "whole cables": ["effects.cable_contact={}"],
    "whole cables, friction 0.3": ["effects.cable_contact={}", "effects.friction={\"coefficient\":0.3}"],
}
LEFT_OUT = ("cabin", "mockup", "orbit", "chaser", "settled")


def scenes():
    """Names of the built-in scenes that are captures of the source's targets."""
    names = sorted(path.stem for path in (Path(__file__).parent.parent / "scenarios").glob("*.json"))
    return [name for name in names if name.split("-")[0] in FAMILIES and not any(word in name for word in LEFT_OUT)]


def members(program, out, scene, pair, contact, count, more):
    """Captures of the members of one ensemble, run unless they are in `out`; none: it was refused or failed."""
    if not (out / "ensemble.json").exists():
        cables, answer = pair.split("+")
        changes = ["expect=null", "output.sample_s=0.05", f"solver.cables={cables}", f"solver.contact={answer}", *CONTACTS[contact]]
        settings = [word for change in changes for word in ("--set", change)]
        command = [program, "run", scene, "--ensemble", str(count), "--seed", "5", "--quiet", "--out", str(out), *settings, *more]
        done = subprocess.run(command, capture_output=True, text=True)
        if not (out / "ensemble.json").exists():
            print(f"{scene} {pair} {contact}: {done.stderr.strip()}", file=sys.stderr)
            return None
    ensemble = json.loads((out / "ensemble.json").read_text())
    # A program that was stopped, or another one, may have left members of its own.
    newest = max((out / "members").iterdir(), key=lambda folder: folder.stat().st_mtime)
    found = [json.loads(path.read_text()) for path in sorted(newest.glob("*.json"))]
    if ensemble["failures"]:
        print(f"{scene} {pair} {contact}: {ensemble['failures']}", file=sys.stderr)
    return [one["outcome"]["Ok"] for one in found if "Ok" in one["outcome"]]


def spread(values, digits=1):
    """The least and the largest of `values`, as text."""
    values = sorted(value for value in values if value is not None)
    if not values:
        return "–"
    low, high = (f"{value:.{digits}f}" for value in (values[0], values[-1]))
    return low if low == high else f"{low} to {high}"


def row(program, folder, scene, pair, contact):
    """A line of the table."""
    time, counts = FAMILIES[scene.split("-")[0]]
    at = folder / f"{scene} {pair} {contact}".replace(" ", "_").replace(",", "")
    first = members(program, at / "source", scene, pair, contact, counts[pair], ["--set", f"duration_s={time}"])
    last = members(program, at / "long", scene, pair, contact, counts[pair], ["--until", "settled", "--at-most", f"{10 * time}"])
    if not first or not last:
        return None
    captures = [summary["capture"] for summary in last]
    held = sum(capture["captured"] for capture in captures)
    settled = [capture["settled_at_s"] for capture in captures if capture["verdict"] == "held_settled"]
    says = {True: "yes", False: "no", None: "–"}[SOURCE.get(scene)]
    cells = [
        f"`{scene}`", says, f"`{pair}`", contact,
        f"{sum(summary['capture']['captured'] for summary in first)} of {len(first)}",
        f"{held} of {len(last)}",
        spread([capture.get("first_lost_at_s") for capture in captures]),
        f"{len(settled)}: {spread(settled)}" if settled else "–",
        spread([summary["contact"]["cables_inside"] for summary in last], 0),
        spread([capture["gather"] for capture in captures], 2),
        f"{max(summary['conservation']['energy_created'] for summary in first + last):.0e}",
    ]
    return "| " + " | ".join(cells) + " |"


def thread_of(scene):
    """How the mouth is closed in a scene, by what its name ends in."""
    ending = scene.split("-")[-1]
    if ending == "free" and scene.count("-") > 1:
        return "from bullet to bullet"
    return "along the edges" if ending in ("tube", "cinch", "interlaced") else "none"


def sums(text):
    """The rows of tables in `text`, summed up by target, pair, contact and thread, as a table."""
    found = {}
    for line in text.splitlines():
        cells = [cell.strip(" `") for cell in line.strip("|").split("|")]
        if len(cells) != 11 or cells[0].split("-")[0] not in FAMILIES:
            continue
        scene, _, pair, contact, first, last, _, settled, _, _, created = cells
        key = (list(FAMILIES).index(scene.split("-")[0]), pair, list(CONTACTS).index(contact), thread_of(scene))
        of_row = [int(number) for cell in (first, last) for number in cell.split(" of ")] + [int(settled.split(":")[0]) if ":" in settled else 0]
        counts, most = found.get(key, ([0] * 5, 0.0))
        found[key] = ([one + other for one, other in zip(counts, of_row)], max(most, float(created)))
    print("| target | pair | contact | thread | held at the source's time | held at the end | settled | energy created, at most |")
    print("|---" * 8 + "|")
    for (target, pair, contact, thread), ((first, of_first, last, of_last, settled), created) in sorted(found.items()):
        cells = [list(FAMILIES)[target], f"`{pair}`", list(CONTACTS)[contact], thread, f"{first} of {of_first}", f"{last} of {of_last}", str(settled)]
        print("| " + " | ".join([*cells, f"{created:.0e}"]) + " |")


def main():
    """Runs what is asked for, and prints the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("--out", type=Path, default=Path("results/findings"))
    parser.add_argument("--pair", choices=["explicit+impulse", "joints+rapier"], action="append")
    parser.add_argument("--contact", choices=list(CONTACTS), action="append")
    parser.add_argument("--scene", default="", help="how the scenes' names begin")
    parser.add_argument("--sum", type=Path, metavar="ROWS", help="sum up the rows of that file instead")
    asked = parser.parse_args()
    if asked.sum:
        sums(asked.sum.read_text())
        return
    print("| scene | source | pair | contact | held at the source's time | held at the end | first lost, s | settled, at s "
          "| cables inside at the end | gather at the end | energy created, at most |")
    print("|---" * 11 + "|")
    for contact in asked.contact or CONTACTS:
        for pair in asked.pair or ["explicit+impulse", "joints+rapier"]:
            for scene in scenes():
                if scene.startswith(asked.scene) and (line := row(asked.program, asked.out, scene, pair, contact)):
                    print(line, flush=True)


if __name__ == "__main__":
    main()

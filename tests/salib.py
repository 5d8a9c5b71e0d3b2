"""Total sensitivities of a sweep beside those of SALib, which shares no code with ours: `salib.py DIR`.

DIR is the folder of a sweep of design "saltelli" that is finished and of which `tumblenet sensitivity` has written what it
found. Both estimate totals by Jansen's sum over the variance of A and B, so that they agree to rounding.
"""

import csv
import json
import math
import sys
from pathlib import Path

import numpy
from SALib.analyze import sobol


def main(folder: Path) -> None:
    found = json.loads((folder / "sensitivity.json").read_text())
    with open(folder / "table.csv", newline="") as file:
        rows = sorted(csv.DictReader(file), key=lambda row: int(row["member"]))
    n_inputs = len(found["inputs"])
    problem = {"num_vars": n_inputs, "names": found["inputs"], "bounds": [[0, 1]] * n_inputs}
    compared, worst = 0, 0.0
    for name, ours in found["scalars"].items():
        blocks = numpy.array([float(row[name] or "nan") for row in rows]).reshape(-1, n_inputs + 2)
        if ours["blocks"] < len(blocks):
            continue
        # Ours: A, B, A with one input after the other from B. SALib's: A, those, B.
        ordered = blocks[:, [0, *range(2, n_inputs + 2), 1]].ravel()
        theirs = sobol.analyze(problem, ordered, calc_second_order=False, num_resamples=2)["ST"]
        for mine, other in zip(ours["inputs"], theirs, strict=True):
            apart = abs(mine["total"]["value"] - other)
            if not apart <= 1e-6 * max(1.0, abs(other)):
                sys.exit(f"{name}: {mine['total']['value']} and {other} by SALib")
            compared, worst = compared + 1, max(worst, apart)
    if compared < 10 or math.isnan(worst):
        sys.exit(f"only {compared} totals could be compared")
    print(f"{compared} totals of {n_inputs} inputs: at most {worst:.1e} from those of SALib")


main(Path(sys.argv[1]))

"""A sweep as tasks of a real HyperQueue on this machine: `python .ci/hq.py PROGRAM`, with its wheel from PyPI.

Every part is a task as `sweep template hq` writes it. One is killed, most are run a second time beside, what is missing is
run again, and the merged table must be the bytes of a sweep that ran alone. Its journal, by which a server that died goes
on, is no part of the wheel.
"""

import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from hyperqueue import Job, LocalCluster
from hyperqueue.cluster import WorkerConfig

PARTS = 7
STUDY = {
    "title": "array", "scene": "cubesat-free", "solver": "explicit+impulse", "members": 2,
    "parameters": [{"path": "launch.speed_m_s", "uniform": [1.9, 2.1]}],
    "design": {"kind": "sobol", "points": 14},
}  # fmt: skip


def main(program: str) -> None:
    os.chdir(tempfile.mkdtemp())
    Path("study.json").write_text(json.dumps(STUDY))
    call = lambda *arguments: subprocess.run([program, *arguments], check=True, capture_output=True, text=True).stdout
    call("sweep", "study.json", "--out", "alone", "--quiet")

    def parts(numbers: list[int]) -> Job:
        job = Job(max_fails=PARTS)
        for number in numbers:
            shard = f"{number}/{PARTS}"
            job.program(
                [program, "sweep", "study.json", "--out", "shared", "--shard", shard, "--jobs", "1", "--quiet"],
                cwd=os.getcwd(),
            )
        return job

    def numbers(text: str) -> list[int]:
        ends = [part.split("-") for part in text.strip().split(",") if part]
        return [number for end in ends for number in range(int(end[0]), int(end[-1]) + 1)]

    with LocalCluster(worker_config=WorkerConfig(cores=2)) as cluster:
        client = cluster.client()
        jobs = [client.submit(parts(list(range(first, PARTS + 1)))) for first in (1, 4)]
        while not list(Path("shared").glob("rows/*/*.csv")):
            time.sleep(0.05)
        running = subprocess.run(["pgrep", "-f", "sweep study.json --out shared"], capture_output=True, text=True)
        killed = running.stdout.split()[:1]
        for pid in killed:
            os.kill(int(pid), signal.SIGKILL)
        client.wait_for_jobs(jobs, raise_on_error=False)
        missing = numbers(call("sweep", "missing", "shared", "--shards", str(PARTS)))
        print(f"killed {len(killed)} of the tasks; parts missing then: {missing or 'none'}")
        if missing:
            client.wait_for_jobs([client.submit(parts(missing))])
    call("sweep", "merge", "shared")
    alone, shared = (Path(folder, "table.csv").read_bytes() for folder in ("alone", "shared"))
    if alone != shared:
        sys.exit("the table of the tasks is not that of a sweep alone")
    print(f"the table of tasks that were killed is that of a sweep alone: {len(alone.splitlines())} lines")


main(str(Path(sys.argv[1]).resolve()))

"""The table of a sweep as one Parquet file, from its folder or from those of its shards.

    python python/examples/sweep_to_parquet.py OUT.parquet DIR...

A row a member: number, point, seed, inputs, verdict, times, every number of its summary, and why it failed if it did. The file's
metadata has the study, the scene with its defaults, versions and the command, as JSON. Needs polars.
"""

import json
import sys
from pathlib import Path

import polars


def main(out: str, *folders: str) -> None:
    plans = [json.loads((Path(folder) / "study.json").read_text()) for folder in folders]
    if len({plan["key"] for plan in plans}) != 1:
        raise SystemExit("these are not shards of one study by one program")
    texts = {name: polars.String for name in ("verdict", "reason", "failure")}
    tables = [polars.read_csv(Path(folder) / "table.csv", infer_schema_length=None, schema_overrides=texts) for folder in folders]
    # A column that no row of a shard fills is not in its table; a member may have run in two.
    table = polars.concat(tables, how="diagonal_relaxed").unique("member").sort("member")
    metadata = {name: json.dumps(plans[0][name]) for name in ("study", "scene", "scene_hash", "provenance")}
    table.write_parquet(out, compression="snappy", metadata=metadata)


if __name__ == "__main__":
    main(*sys.argv[1:])

"""The recordings of a fleet, on all cores or on a cluster, as `vn100 archive` measures them.

    python fleet_dask.py captures/ -o rows.jsonl                  # processes of this machine
    python fleet_dask.py captures/ -o rows.jsonl --scheduler tcp://host:8786

One function is mapped over the captures; its rows are written in their order, as they are known. A
capture whose worker dies is measured by another one. Workers must see the files under the same paths.
On SLURM or Kubernetes start a scheduler with dask-jobqueue or dask-kubernetes and name it.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

import vn100
from dask.distributed import Client, LocalCluster


def rows_of(files: list[str]) -> list[str]:
    """Of a capture, or of the parts of one."""
    return vn100.archive_rows(*files)


def fleet(captures: list[list[str]], client: Client) -> Iterator[str]:
    """The rows of all captures, in the order of the captures."""
    for future in client.map(rows_of, captures, pure=False):
        yield from future.result()
        future.release()


def main() -> None:
    parser = argparse.ArgumentParser(description="Measures every capture below a folder")
    parser.add_argument("folder", help="captures are found as by `vn100 archive FOLDER`")
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--scheduler", help="of a cluster, as tcp://host:8786")
    parser.add_argument("--workers", type=int, help="processes on this machine")
    args = parser.parse_args()
    captures = vn100.captures(args.folder)
    with args.output.open("w") as output:
        if args.scheduler:
            with Client(args.scheduler) as client:
                output.writelines(fleet(captures, client))
        else:
            with (
                LocalCluster(n_workers=args.workers, threads_per_worker=1, processes=True, dashboard_address=None) as cluster,
                Client(cluster) as client,
            ):
                output.writelines(fleet(captures, client))


if __name__ == "__main__":
    main()

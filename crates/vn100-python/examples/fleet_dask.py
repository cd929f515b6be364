"""The recordings of a fleet, on all cores or on a cluster, as `vn100 archive` measures them.

    python fleet_dask.py captures/ -o fleet.json                  # processes of this machine
    python fleet_dask.py captures/ -o fleet.json --scheduler tcp://host:8786

Files are mapped to states, states are folded: the result does not depend on which worker
read which file. Workers must see the files under the same paths. On SLURM or Kubernetes start a
scheduler with dask-jobqueue or dask-kubernetes and name it.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import dask.bag
import vn100
from dask.distributed import Client, LocalCluster

ENDINGS = {".bag", ".bin", ".csv", ".db3", ".log", ".mcap", ".raw", ".tsv", ".txt", ".vnimu", ".vnymr"}


def state_of(path: str) -> vn100.State:
    """A broken file is a row with its error."""
    try:
        return vn100.State.of_file(path, name=path)
    except (OSError, vn100.CaptureError) as error:
        return vn100.State.of_error(path, str(error))


def fleet(paths: list[str], client: Client) -> vn100.State:
    """The states of all files as one; the workers do all but the last fold."""
    bag = dask.bag.from_sequence(paths, npartitions=max(1, min(len(paths), 4 * len(client.nthreads()))))
    state: vn100.State = bag.map(state_of).reduction(merged, merged, split_every=8).compute(scheduler=client)
    return state


def merged(states: list[vn100.State]) -> vn100.State:
    return vn100.State.merged(*states)


def main() -> None:
    parser = argparse.ArgumentParser(description="Measures every capture below a folder")
    parser.add_argument("folder", type=Path)
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--scheduler", help="of a cluster, as tcp://host:8786")
    parser.add_argument("--workers", type=int, help="processes on this machine")
    args = parser.parse_args()
    paths = sorted(str(path) for path in args.folder.rglob("*") if path.suffix.lower() in ENDINGS)
    if args.scheduler:
        with Client(args.scheduler) as client:
            state = fleet(paths, client)
    else:
        with (
            LocalCluster(n_workers=args.workers, threads_per_worker=1, processes=True, dashboard_address=None) as cluster,
            Client(cluster) as client,
        ):
            state = fleet(paths, client)
    args.output.write_text(state.archive() + "\n")


if __name__ == "__main__":
    main()

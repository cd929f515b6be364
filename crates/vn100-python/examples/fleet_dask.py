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

def state_of(files: list[str]) -> vn100.State:
    """Of a file, or of the parts of a recording; a broken one is a row with its error."""
    try:
        return vn100.State.of_file(*files)
    except OSError as error:
        return vn100.State.of_error(files[0], error.strerror or str(error))
    except vn100.CaptureError as error:
        return vn100.State.of_error(files[0], str(error))


def fleet(captures: list[list[str]], client: Client) -> vn100.State:
    """The states of all captures as one; the workers do all but the last fold."""
    bag = dask.bag.from_sequence(captures, npartitions=max(1, min(len(captures), 4 * len(client.nthreads()))))
    state: vn100.State = bag.map(state_of).reduction(merged, merged, split_every=8).compute(scheduler=client)
    return state


def merged(states: list[vn100.State]) -> vn100.State:
    return vn100.State.merged(*states)


def main() -> None:
    parser = argparse.ArgumentParser(description="Measures every capture below a folder")
    parser.add_argument("folder", help="captures are found as by `vn100 archive FOLDER`")
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--scheduler", help="of a cluster, as tcp://host:8786")
    parser.add_argument("--workers", type=int, help="processes on this machine")
    args = parser.parse_args()
    captures = vn100.captures(args.folder)
    if args.scheduler:
        with Client(args.scheduler) as client:
            state = fleet(captures, client)
    else:
        with (
            LocalCluster(n_workers=args.workers, threads_per_worker=1, processes=True, dashboard_address=None) as cluster,
            Client(cluster) as client,
        ):
            state = fleet(captures, client)
    args.output.write_text(state.archive() + "\n")


if __name__ == "__main__":
    main()

# SPDX-License-Identifier: Apache-2.0
# The chain over 100 records on a Dask cluster. Here the cluster is two processes on this machine; a scheduler that runs
# elsewhere is Client("tcp://host:8786"). Killed and started again, the ensemble continues where it was.

# %% Do the stated 95 % intervals hold the truth in 95 % of the runs?
import sys

import kalfem as kf
from dask.distributed import Client, LocalCluster


def main(records):
    grid = {"simulate.seed": range(1, records + 1), "simulate.duration": "4 s", "estimate.settle": "1 s"}
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
        runs = kf.map("examples/chain/chain.yaml", grid, executor=client.get_executor(), folder="ensemble")
    for failure in runs.failures:
        print(f"seed {failure.settings['simulate.seed']}: {failure}")
    for name in ["suspension.mu_k1", "suspension.mu_c1"]:
        found = [run.parameters[name] for run in runs if run and run.usable]
        inside = sum(each.interval[0] <= each.truth <= each.interval[1] for each in found)
        print(f"{name}: the 95 % interval holds the truth in {inside} of {len(found)} runs")
    runs.to_pandas().to_csv("ensemble.csv", index=False)


if __name__ == "__main__":  # Dask's processes import this file
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 100)

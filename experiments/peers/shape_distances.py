"""Distances between point clouds by Python Optimal Transport and SciPy: the clouds that `experiments metrics` hands over, one row a pair.

    pip install pot==0.9.7.post1 scipy==1.17.1
    python3 shape_distances.py SCENE.json     # prints JSON lines

SCENE.json: pairs, each of a (N, 3) and b (M, 3) [m] and epsilon [m]. Seconds are wall time.
"""
import json
import sys
import time
import warnings

import numpy as np
import ot
from scipy.optimize import linear_sum_assignment
from scipy.spatial import cKDTree


def timed(call):
    start = time.perf_counter()
    return call(), time.perf_counter() - start


def chamfer(a, b):
    return float(cKDTree(b).query(a)[0].mean() + cKDTree(a).query(b)[0].mean())


def assignment(a, b):
    cost = ot.dist(a, b, metric="euclidean")
    rows, columns = linear_sum_assignment(cost)
    return float(cost[rows, columns].mean())


def exact(a, b):
    return float(ot.emd2([], [], ot.dist(a, b, metric="euclidean"), numItermax=10_000_000))


def entropic(a, b, epsilon):
    """Σ π|a − b| + ε KL(π | α ⊗ β), and its first part, which is what ot.sinkhorn2 returns."""
    cost = ot.dist(a, b, metric="euclidean")
    plan = ot.sinkhorn([], [], cost, epsilon, method="sinkhorn_log", numItermax=100_000, stopThr=1e-11)
    carried = float(np.sum(plan * cost))
    mass = plan[plan > 0]
    return carried + epsilon * float(np.sum(mass * np.log(mass * plan.size))), carried


def run(pair):
    a, b, epsilon = np.array(pair["a"]), np.array(pair["b"]), pair["epsilon"]
    row = {"chamfer": chamfer(a, b)}
    row["emd"], row["emd_seconds"] = timed(lambda: exact(a, b))
    if len(a) == len(b):
        row["assignment"], row["assignment_seconds"] = timed(lambda: assignment(a, b))
    (row["entropic"], row["carried"]), row["entropic_seconds"] = timed(lambda: entropic(a, b, epsilon))
    row["divergence"] = row["entropic"] - 0.5 * (entropic(a, a, epsilon)[0] + entropic(b, b, epsilon)[0])
    row["versions"] = f"pot {ot.__version__}"
    return row


if __name__ == "__main__":
    # A plan that did not converge is no peer.
    warnings.simplefilter("error")
    with open(sys.argv[1]) as file:
        scene = json.load(file)
    for pair in scene["pairs"]:
        print(json.dumps(run(pair)), flush=True)

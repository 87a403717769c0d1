"""Our network in PyTorch and JAX: the graphs and weights that `experiments network_speed` hands over, one row a graph and a variant.

    pip install torch==2.15.0 jax==0.10.2 safetensors==0.8.0
    python3 message_passing.py SCENE.json     # prints JSON lines

SCENE.json: framework (torch or jax), rounds of message passing, seconds a measurement takes at least, and graphs, each of variants
and a folder with nodes, features, window, receivers, senders, cotangent, output (.npy), weights and gradient (.safetensors; by the
names our weight files use); the last of each are our results, which the rows' gaps are relative to. Milliseconds are CPU time of the
whole process, which has one thread to compute with, for a call, after one that is not counted.
"""
import json
import os
import sys
import time

os.environ["OMP_NUM_THREADS"] = "1"
os.environ["XLA_FLAGS"] = "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1"

import numpy as np
from safetensors.numpy import load_file

MEAN = 0.6772654  # of (x + √(x² + 1))/2 over a normal x
SCALE = 0.2
ARRAYS = ["nodes", "features", "window", "receivers", "senders", "cotangent", "output"]


def milliseconds(call, seconds):
    call()
    used, calls = 0.0, 0
    while used < seconds:
        before = time.process_time()
        call()
        used += time.process_time() - before
        calls += 1
    return 1e3 * used / calls


def gap(a, b):
    return float(np.abs(np.asarray(a) - b).max() / np.abs(b).max())


class Torch:
    def __init__(self, graph, weights, rounds):
        import torch

        torch.set_num_threads(1)
        self.torch, self.rounds = torch, rounds
        self.name = f"torch {torch.__version__}"
        self.graph = {k: torch.from_numpy(v) for k, v in graph.items()}
        self.graph["scaled"] = SCALE * self.graph["window"][:, None]
        self.weights = {k: torch.from_numpy(v).requires_grad_() for k, v in weights.items()}

    def passes(self, variant):
        torch, weights = self.torch, self.weights
        aggregate = self.written if variant == "written" else self.split
        run = lambda: self.network(aggregate)
        if variant == "compiled":
            run = torch.compile(run)

        def forward():
            with torch.no_grad():
                return run()

        def both():
            return torch.autograd.grad(run(), list(weights.values()), self.graph["cotangent"])

        return forward, lambda: dict(zip(weights, both()))

    def product(self):
        """GFLOP/s of a matrix product the size of a layer over many edges."""
        a, b = self.torch.rand(4096, 128), self.torch.rand(128, 128)
        return 2e-6 * a.numel() * 128 / milliseconds(lambda: a @ b, 0.2)

    def active(self, x):
        # The fastest of five ways to write it, measured forward and back.
        return self.torch.add(x, x.square().add_(1).sqrt_()).mul_(0.5).sub_(MEAN)

    def layer(self, name, x):
        return self.torch.addmm(self.weights[f"{name}.bias"], x, self.weights[f"{name}.weight"])

    def perceptron(self, name, x):
        return self.layer(f"{name}.last", self.active(self.layer(f"{name}.first", x)))

    def network(self, aggregate):
        h = self.perceptron("node", self.graph["nodes"])
        for r in range(self.rounds):
            h = h + self.perceptron(f"round.{r}.update", self.torch.cat([h, aggregate(h, f"round.{r}.edge.particle")], 1))
        return self.perceptron("decoder", h)

    def summed(self, h, messages):
        return self.torch.zeros_like(h).index_add(0, self.graph["receivers"], messages * self.graph["scaled"])

    def written(self, h, name):
        ends = [h.index_select(0, self.graph[end]) for end in ("receivers", "senders")]
        z = self.active(self.layer(f"{name}.first", self.torch.cat([*ends, self.graph["features"]], 1)))
        return self.summed(h, self.active(self.layer(f"{name}.hidden", z)) @ self.weights[f"{name}.last.weight"])

    def split(self, h, name):
        torch, width = self.torch, h.shape[1]
        receiver, sender, edge = self.weights[f"{name}.first.weight"].split([width, width, self.graph["features"].shape[1]])
        received = torch.addmm(self.weights[f"{name}.first.bias"], h, receiver).index_select(0, self.graph["receivers"])
        ends = received + (h @ sender).index_select(0, self.graph["senders"])
        z = self.active(torch.addmm(ends, self.graph["features"], edge))
        return self.summed(h, self.active(self.layer(f"{name}.hidden", z))) @ self.weights[f"{name}.last.weight"]


class Jax:
    def __init__(self, graph, weights, rounds):
        import jax

        self.jax, self.rounds = jax, rounds
        self.name = f"jax {jax.__version__}"
        self.graph = {k: jax.numpy.asarray(v) for k, v in graph.items()}
        self.weights = {k: jax.numpy.asarray(v) for k, v in weights.items()}

    def passes(self, variant):
        assert variant == "split"
        jax = self.jax
        loss = lambda weights, graph: jax.numpy.vdot(self.network(weights, graph), graph["cotangent"])
        forward, both = jax.jit(self.network), jax.jit(jax.value_and_grad(loss))
        call = lambda f: jax.block_until_ready(f(self.weights, self.graph))
        return lambda: call(forward), lambda: call(both)[1]

    def product(self):
        return None

    def network(self, weights, graph):
        jax, np = self.jax, self.jax.numpy
        active = lambda x: 0.5 * (x + np.sqrt(x * x + 1)) - MEAN
        layer = lambda name, x: x @ weights[f"{name}.weight"] + weights[f"{name}.bias"]
        perceptron = lambda name, x: layer(f"{name}.last", active(layer(f"{name}.first", x)))
        # Told what it could not know: that every index is there, and which ones are sorted.
        at = lambda x, end: x.at[graph[end]].get(mode="promise_in_bounds", indices_are_sorted=end == "receivers")
        h = perceptron("node", graph["nodes"])
        count, width = h.shape
        for r in range(self.rounds):
            name = f"round.{r}.edge.particle"
            receiver, sender, edge = np.split(weights[f"{name}.first.weight"], [width, 2 * width])
            received = h @ receiver + weights[f"{name}.first.bias"]
            z = active(at(received, "receivers") + at(h @ sender, "senders") + graph["features"] @ edge)
            z = active(layer(f"{name}.hidden", z)) * (SCALE * graph["window"][:, None])
            sums = jax.ops.segment_sum(z, graph["receivers"], count, indices_are_sorted=True, mode="promise_in_bounds")
            aggregate = sums @ weights[f"{name}.last.weight"]
            h = h + perceptron(f"round.{r}.update", np.concatenate([h, aggregate], 1))
        return perceptron("decoder", h)


def rows(scene):
    for job in scene["graphs"]:
        folder = job["folder"]
        graph = {name: np.load(os.path.join(folder, f"{name}.npy")) for name in ARRAYS}
        ours, (weights, gradient) = graph.pop("output"), (
            load_file(os.path.join(folder, f"{name}.safetensors")) for name in ("weights", "gradient")
        )
        peer = {"torch": Torch, "jax": Jax}[scene["framework"]](graph, weights, scene["rounds"])
        for variant in job["variants"]:
            forward, both = peer.passes(variant)
            theirs = both()
            yield {
                "engine": peer.name,
                "variant": f"{scene['framework']} {variant}",
                "forward_ms": milliseconds(forward, scene["seconds"]),
                "training_ms": milliseconds(both, scene["seconds"]),
                "gap": gap(forward(), ours),
                "gradient_gap": max(gap(theirs[name], gradient[name]) for name in gradient),
                "product_gflops": peer.product(),
            }


if __name__ == "__main__":
    with open(sys.argv[1]) as file:
        scene = json.load(file)
    for row in rows(scene):
        print(json.dumps(row), flush=True)

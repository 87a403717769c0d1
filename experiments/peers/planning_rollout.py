"""A network of RoboCook's kind and size (Li et al. 2019, Shi et al. 2023) in PyTorch, with gathers along a list of edges where the
published code multiplies by dense matrices: rollouts, and their gradient by the tool's motion.

    pip install torch==2.15.0
    python3 planning_rollout.py SCENE.json     # prints JSON lines

SCENE.json: particles (N, 3) and tool (T, 3) at the start, fingers (samples of each part), receivers and senders of the edges, which
are kept, paths (rollouts, steps + 1, parts, 3), width and rounds. Prints CPU seconds of the whole process, which has one thread to
compute with, for all rollouts as one batch: forward, and with the gradient, after one call that is not counted. No neighbours are looked for.
"""
import json
import os
import sys
import time

os.environ["OMP_NUM_THREADS"] = "1"

import torch

torch.set_num_threads(1)


def perceptron(inputs, width, outputs):
    layers = [torch.nn.Linear(inputs, width), torch.nn.Linear(width, width), torch.nn.Linear(width, outputs)]
    return torch.nn.Sequential(layers[0], torch.nn.ReLU(), layers[1], torch.nn.ReLU(), layers[2])


class Network(torch.nn.Module):
    """Encoders of particles and relations, rounds of propagation with shared weights, a predictor of displacements."""

    def __init__(self, width, rounds):
        super().__init__()
        self.rounds = rounds
        self.particle, self.relation = perceptron(6, width, width), perceptron(15, width, width)
        self.along, self.at = torch.nn.Linear(3 * width, width), torch.nn.Linear(2 * width, width)
        self.predictor = perceptron(width, width, 3)

    def forward(self, nodes, offsets, receivers, senders):
        ends = [nodes.index_select(0, end) for end in (receivers, senders)]
        node = torch.relu(self.particle(nodes))
        edge = torch.relu(self.relation(torch.cat([*ends, offsets], 1)))
        effect = node
        for _ in range(self.rounds):
            ends = [effect.index_select(0, end) for end in (receivers, senders)]
            said = torch.relu(self.along(torch.cat([edge, *ends], 1)))
            heard = torch.zeros_like(effect).index_add(0, receivers, said)
            effect = torch.relu(self.at(torch.cat([node, heard], 1)) + effect)
        return self.predictor(effect)


def main(scene):
    dough, tool = (torch.tensor(scene[key], dtype=torch.float32) for key in ("particles", "tool"))
    paths = torch.tensor(scene["paths"], dtype=torch.float32)
    batch, count, particles = len(paths), len(dough) + len(tool), len(dough)
    ends = [torch.tensor(scene[key]) for key in ("receivers", "senders")]
    shift = count * torch.arange(batch)[:, None]
    receivers, senders = ((end[None] + shift).reshape(-1) for end in ends)
    finger = torch.repeat_interleave(torch.arange(len(scene["fingers"])), torch.tensor(scene["fingers"]))
    kind = torch.zeros(batch, count, 2)
    kind[:, :particles, 0], kind[:, particles:, 1] = 1, 1

    def rollout(network, paths, dtype):
        x = torch.cat([dough, tool]).expand(batch, -1, -1)
        last = torch.zeros_like(x)
        cost = 0
        for t in range(paths.shape[1] - 1):
            pushed = (paths[:, t + 1] - paths[:, t])[:, finger]
            u = torch.cat([torch.zeros(batch, particles, 3), pushed], 1)
            nodes = torch.cat([(last + u) / 0.002, kind, x[..., 2:] / 0.02], 2).reshape(-1, 6)
            flat = (x + u).reshape(-1, 3)
            offsets = (flat.index_select(0, receivers) - flat.index_select(0, senders)) / 0.02
            out = network(nodes.to(dtype), offsets.to(dtype), receivers, senders).float().reshape(batch, count, 3)
            moved = torch.cat([0.002 * out[:, :particles], pushed], 1)
            last, x = torch.cat([moved[:, :particles], torch.zeros_like(pushed)], 1), x + moved
            cost = cost + x[:, :particles].square().sum()
        return cost

    def seconds(call):
        call()
        before = time.process_time()
        for _ in range(scene["repeats"]):
            call()
        return (time.process_time() - before) / scene["repeats"]

    torch.manual_seed(0)
    network = Network(scene["width"], scene["rounds"])
    weights = sum(w.numel() for w in network.parameters())
    name = f"torch {torch.__version__}"

    def forward(network, dtype):
        with torch.no_grad():
            return rollout(network, paths, dtype)

    def gradient(network, dtype):
        given = paths.clone().requires_grad_()
        return torch.autograd.grad(rollout(network, given, dtype), given)

    for w in network.parameters():
        w.requires_grad_(False)
    for variant, dtype in [("float32", torch.float32), ("bfloat16", torch.bfloat16)]:
        network = network.to(dtype)
        passes = {key: seconds(lambda: run(network, dtype)) for key, run in [("forward", forward), ("gradient", gradient)]}
        print(json.dumps({"engine": name, "weights": weights, "variant": variant, **passes}), flush=True)


if __name__ == "__main__":
    with open(sys.argv[1]) as file:
        main(json.load(file))

"""MLS-MPM in three dimensions in Taichi: the block of points that `experiments mpm_speed` hands over, one row a variant.

    pip install taichi==1.7.4             # for Python 3.7 to 3.13
    python3 taichi_mpm.py SCENE.json      # prints JSON lines

SCENE.json: positions (N, 3) [m], cell [m], dt [s], steps, density [kg/m³], young [Pa], poisson, yield [Pa],
gravity [m/s²], variants: `example`, the weakly compressible fluid of Taichi's own `mpm3d`, and `dough`, the Hencky elasticity with
von Mises flow of ours by Taichi's singular value decomposition. Single precision, one thread; seconds are CPU time of the process
after a call that is not counted. The table, z = 0, lets slide.
"""
import json
import os
import sys
import time

# Taichi greets on standard output, where only rows belong.
ROWS = os.fdopen(os.dup(1), "w")
os.dup2(2, 1)

import numpy as np
import taichi as ti


def simulation(scene, variant):
    ti.init(arch=ti.cpu, cpu_max_num_threads=1, default_fp=ti.f32, random_seed=0, log_level=ti.ERROR)
    start = np.array(scene["positions"], dtype=np.float64)
    cell, dt, gravity = scene["cell"], scene["dt"], scene["gravity"]
    count, young, nu, density = len(start), scene["young"], scene["poisson"], scene["density"]
    mu, lam = young / (2 * (1 + nu)), young * nu / ((1 + nu) * (1 - 2 * nu))
    limit = scene["yield"] / (2 * mu)
    margin = 4
    low = np.floor(start.min(0) / cell) * cell - margin * cell
    low[2] = -margin * cell
    size = tuple(int(n) for n in np.ceil((start.max(0) - low) / cell) + margin)
    # As in the example, all points weigh the same; the volume is that of the mass at the density.
    volume = (cell / 2) ** 3
    mass = volume * density
    inverse = 1 / cell

    x = ti.Vector.field(3, float, count)
    v = ti.Vector.field(3, float, count)
    C = ti.Matrix.field(3, 3, float, count)
    F = ti.Matrix.field(3, 3, float, count)
    J = ti.field(float, count)
    grid_v = ti.Vector.field(3, float, size)
    grid_m = ti.field(float, size)

    @ti.func
    def stress(p):
        # Kirchhoff's.
        result = ti.Matrix.zero(float, 3, 3)
        if ti.static(variant == "example"):
            J[p] *= 1 + dt * C[p].trace()
            result = ti.Matrix.identity(float, 3) * (lam * (J[p] - 1))
        else:
            F[p] = (ti.Matrix.identity(float, 3) + dt * C[p]) @ F[p]
            U, S, V = ti.svd(F[p])
            e = ti.Vector([ti.log(ti.max(S[0, 0], 0.05)), ti.log(ti.max(S[1, 1], 0.05)), ti.log(ti.max(S[2, 2], 0.05))])
            shear = e - e.sum() / 3
            norm = shear.norm()
            if norm > limit:
                e -= (1 - limit / norm) * shear
                kept = ti.Matrix([[ti.exp(e[0]), 0, 0], [0, ti.exp(e[1]), 0], [0, 0, ti.exp(e[2])]])
                F[p] = U @ kept @ V.transpose()
            t = 2 * mu * e + lam * e.sum()
            result = U @ ti.Matrix([[t[0], 0, 0], [0, t[1], 0], [0, 0, t[2]]]) @ U.transpose()
        return result

    @ti.kernel
    def step():
        for I in ti.grouped(grid_m):
            grid_v[I] = ti.zero(grid_v[I])
            grid_m[I] = 0
        ti.loop_config(block_dim=256)
        for p in x:
            Xp = x[p] * inverse
            base = int(Xp - 0.5)
            fx = Xp - base
            w = [0.5 * (1.5 - fx) ** 2, 0.75 - (fx - 1) ** 2, 0.5 * (fx - 0.5) ** 2]
            affine = -dt * 4 * inverse * inverse * volume * stress(p) + mass * C[p]
            for offset in ti.static(ti.grouped(ti.ndrange(3, 3, 3))):
                dpos = (offset - fx) * cell
                weight = 1.0
                for i in ti.static(range(3)):
                    weight *= w[offset[i]][i]
                grid_v[base + offset] += weight * (mass * v[p] + affine @ dpos)
                grid_m[base + offset] += weight * mass
        for I in ti.grouped(grid_m):
            if grid_m[I] > 0:
                grid_v[I] /= grid_m[I]
                grid_v[I][2] -= dt * gravity
                if I[2] <= margin and grid_v[I][2] < 0:
                    grid_v[I][2] = 0
                # The example's own walls, which these points do not come to.
                for axis in ti.static(range(3)):
                    if I[axis] < 3 and grid_v[I][axis] < 0:
                        grid_v[I][axis] = 0
                    if I[axis] > size[axis] - 3 and grid_v[I][axis] > 0:
                        grid_v[I][axis] = 0
        ti.loop_config(block_dim=256)
        for p in x:
            Xp = x[p] * inverse
            base = int(Xp - 0.5)
            fx = Xp - base
            w = [0.5 * (1.5 - fx) ** 2, 0.75 - (fx - 1) ** 2, 0.5 * (fx - 0.5) ** 2]
            new_v = ti.zero(v[p])
            new_C = ti.zero(C[p])
            for offset in ti.static(ti.grouped(ti.ndrange(3, 3, 3))):
                dpos = (offset - fx) * cell
                weight = 1.0
                for i in ti.static(range(3)):
                    weight *= w[offset[i]][i]
                g = grid_v[base + offset]
                new_v += weight * g
                new_C += 4 * weight * g.outer_product(dpos) * inverse * inverse
            v[p] = new_v
            x[p] += dt * v[p]
            C[p] = new_C

    def reset():
        x.from_numpy((start - low).astype(np.float32))
        v.fill(0)
        C.fill(0)
        F.from_numpy(np.tile(np.eye(3, dtype=np.float32), (count, 1, 1)))
        J.fill(1)

    return step, reset, lambda: x.to_numpy() + low


def run(scene, variant):
    step, reset, positions = simulation(scene, variant)
    reset()
    step()
    ti.sync()
    reset()
    before = time.process_time()
    for _ in range(scene["steps"]):
        step()
    ti.sync()
    used = time.process_time() - before
    version = ".".join(str(n) for n in ti.__version__)
    return {"engine": f"taichi {version}", "variant": variant, "cpu_seconds": used, "positions": positions().tolist()}


if __name__ == "__main__":
    with open(sys.argv[1]) as file:
        scene = json.load(file)
    for variant in scene["variants"]:
        print(json.dumps(run(scene, variant)), file=ROWS, flush=True)

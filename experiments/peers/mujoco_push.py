"""Free balls pushed by a board in MuJoCo: the scene that `experiments speed` hands over, one row a solver.

    pip install mujoco==4.0.0
    python3 mujoco_push.py SCENE.json     # prints JSON lines

SCENE.json: positions (N, 3) [m], radius [m], density [kg/m³], friction, board {half, start} [m], speed [m/s] along x, dt [s],
steps (physics steps in all), chunk (steps a call), solvers.
"""
import json
import sys
import time

import mujoco
import numpy as np


def model(scene, solver):
    board = scene["board"]
    numbers = lambda values: " ".join(repr(float(v)) for v in values)
    balls = "".join(
        f'<body pos="{numbers(p)}"><freejoint/><geom type="sphere" size="{scene["radius"]}"/></body>'
        for p in scene["positions"]
    )
    text = f"""<mujoco>
      <option timestep="{scene["dt"]}" gravity="0 0 -9.81" solver="{solver}"/>
      <default><geom density="{scene["density"]}" friction="{scene["friction"]} 0 0"/></default>
      <worldbody>
        <geom type="plane" size="0 0 1"/>
        <body pos="{numbers(board["start"])}" gravcomp="1">
          <joint name="board" type="slide" axis="1 0 0"/>
          <geom type="box" size="{numbers(board["half"])}" mass="1000" contype="2" conaffinity="1"/>
        </body>
        {balls}
      </worldbody>
    </mujoco>"""
    return mujoco.MjModel.from_xml_string(text)


def run(scene, solver):
    m = model(scene, solver)
    d = mujoco.MjData(m)
    mujoco.mj_forward(m, d)
    joint = m.joint("board")
    start = d.xpos[2:].copy()
    contacts, used = [], 0.0
    for _ in range(scene["steps"] // scene["chunk"]):
        d.qvel[joint.dofadr[0]] = scene["speed"]
        before = time.process_time()
        mujoco.mj_step(m, d, scene["chunk"])
        used += time.process_time() - before
        contacts.append(int(d.ncon))
    moved = (d.xpos[2:] - start)[:, 0]
    return {
        "engine": f"mujoco {mujoco.__version__} {solver}",
        "cpu_seconds": used,
        "contacts": float(np.mean(contacts)),
        "moved": float(moved.mean()),
        "board": float(d.qpos[joint.qposadr[0]]),
        "positions": d.xpos[2:].tolist(),
    }


if __name__ == "__main__":
    with open(sys.argv[1]) as file:
        scene = json.load(file)
    for solver in scene["solvers"]:
        print(json.dumps(run(scene, solver)), flush=True)

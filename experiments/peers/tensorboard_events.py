"""The curves of a training or identification as TensorBoard itself reads them, one row a point.

    pip install tensorboard==2.21.0
    python3 tensorboard_events.py FOLDER     # prints JSON lines: tag, step, value

FOLDER: what a run left, with its event file; TensorBoard checks the sums of every record. With `--check` it prints how many points
there are instead, and fails unless they are those of metrics.jsonl in single precision, none missing and none besides.
"""
import ctypes
import json
import sys
from pathlib import Path

from tensorboard.backend.event_processing.event_accumulator import SCALARS, EventAccumulator


def rows(folder):
    # Nothing is thinned out: without this TensorBoard keeps ten thousand points a curve.
    events = EventAccumulator(str(folder), size_guidance={SCALARS: 0})
    events.Reload()
    for tag in events.Tags()[SCALARS]:
        for point in events.Scalars(tag):
            yield {"tag": tag, "step": point.step, "value": point.value}


def numbers(tag, value):
    """The numbers below a key, a table's called table/key."""
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from numbers(f"{tag}/{key}", inner)
    elif isinstance(value, (int, float)) and not isinstance(value, bool):
        yield tag, ctypes.c_float(value).value


def written(folder):
    for text in (folder / "metrics.jsonl").read_text().splitlines():
        line = json.loads(text)
        step = line.pop("step")
        for key, value in line.items():
            for tag, number in numbers(key, value):
                yield tag, step, number


def main():
    words = sys.argv[1:]
    check = "--check" in words
    (folder,) = [Path(word) for word in words if word != "--check"]
    read = list(rows(folder))
    if not check:
        for row in read:
            print(json.dumps(row))
        return
    both = [sorted((row["tag"], row["step"], row["value"]) for row in read), sorted(written(folder))]
    if both[0] != both[1] or not both[0]:
        odd = sorted(set(both[0]) ^ set(both[1]))
        sys.exit(f"{len(both[0])} points in the events, {len(both[1])} in metrics.jsonl; the first that differ: {odd[:4]}")
    print(json.dumps({"points": len(read), "tags": len({row["tag"] for row in read})}))


main()

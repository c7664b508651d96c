"""Reads the points, writes the cost: the squared distance of the camber from a parabola."""

import json
from pathlib import Path

lines = Path("points.csv").read_text(encoding="utf-8").splitlines()
points = [[float(word) for word in line.split(",")] for line in lines]
pairs = list(zip(points, reversed(points), strict=True))
gaps = [0.5 * (a[1] + b[1]) - 0.08 * a[0] * (1 - a[0]) for a, b in pairs]
cost = sum(gap * gap for gap in gaps) / len(gaps)
Path("result.json").write_text(json.dumps({"value": cost}), encoding="utf-8")

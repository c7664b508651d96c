"""The keys of case files, table by table; ``resources/cases/README.md`` says what they mean."""

from __future__ import annotations

from ffdstudio.optimize.cases.tables import Key, flag, number, several, text, whole, word, words
from ffdstudio.optimize.catalog.indicators import INDICATORS
from ffdstudio.optimize.catalog.methods import METHODS
from ffdstudio.optimize.catalog.metrics import METRICS

Keys = dict[str, Key]
TABLES = (
    "shape", "lattice", "variables", "objective", "constraints", "method", "refinement", "budget",
)  # fmt: skip
COUNT = whole(least=1)
PROCESSES = whole(least=1, most=256) | 1
CORNER = several(number(), 2, 3)
INDEX = several(whole(least=0), 1, 3)

SHAPE: Keys = {
    "source": text(),
    "points": whole(least=5, most=20001) | 161,
    "marker": text() | "",
    "mesh": text() | "",
    "trailing_edge": word(("match", "keep")) | "match",
}
LATTICE: Keys = {
    "shape": several(whole(least=2, most=1000), 1, 3),
    "degrees": several(whole(least=1, most=20), 1, 3) | None,
    "lower": CORNER | None,
    "upper": CORNER | None,
    "margin": number(least=0) | 0.01,
}
VARIABLES: Keys = {
    "directions": words(("x", "y", "z")) | None,
    "frozen": whole(least=0) | 0,
    "fixed": several(INDEX, 0, plural="control points, each as its indices [i, j, ...]") | [],
    "linked": words(("i", "j", "k"), least=0) | [],
    "mirror": word(("i", "j", "k")) | None,
    "mirror_normal": several(number(), 3, 3) | [0.0, 1.0, 0.0],
    "weights": several(number(above=0), 2, 2) | None,
}
WEIGHTS = several(number(least=0)) | None
DEFORMED: Keys = {
    "shape": several(whole(least=2, most=1000), 3, 3),
    "degrees": several(whole(least=1, most=20), 3, 3) | None,
    "moves": several(several(number(), 6, 6), plural="moves [i, j, k, dx, dy, dz]"),
}
OBJECTIVES: dict[str, Keys] = {
    "contour": {"target": text()},
    "surface": {"target": text(), "deformed": Key("a table", lambda v: isinstance(v, dict)) | None},
    "flow": {
        "angles": several(number(least=-90, most=90)),
        "target": text() | "",
        "pressures": several(text()) | None,
        "lift": several(number()) | None,
        "moment": several(number()) | None,
        "pressure_weights": WEIGHTS,
        "lift_weights": WEIGHTS,
        "moment_weights": WEIGHTS,
    },
    "function": {"name": text(), "gradient": flag() | False, "processes": PROCESSES},
    "program": {
        "command": several(text()),
        "sensitivity": flag() | False,
        "time_limit": number(above=0) | 3600.0,
        "processes": PROCESSES,
    },
    "neuralfoil": {
        "angle": number(least=-90, most=90),
        "reynolds": number(above=0),
        "lift": number(),
        "weight": number(least=0) | 1.0,
    },
}
ANGLE: Keys = {"angle": number(least=-90, most=90)}
LIMITS: Keys = {"lower": number() | None, "upper": number() | None, "equal": number() | None}
CONSTRAINTS: dict[str, Keys] = {
    "lift": ANGLE,
    "moment": ANGLE,
    "thickness": {"at": several(number(least=0, most=1))},
    "max-thickness": {},
    "area": {},
    "volume": {},
    "nose-radius": {},
    "displacement": {"direction": word(("x", "y", "z"))},
}
METHOD: Keys = {
    "name": word([kind.kind() for kind in METHODS]) | "lbfgs",
    "metric": word([one.name for one in METRICS]) | "h1",
    "carry_memory": flag() | True,
    "penalty": number(above=0) | 1e3,
}
REFINEMENT: Keys = {
    "indicator": word([one.name for one in INDICATORS]) | "gain",
    "directions": words(("i", "j", "k")) | ["i"],
    "variables": COUNT,
    "positions": COUNT | 5,
    "insertions": COUNT | 1,
    "row_wise": flag() | False,
    "iterations": COUNT | None,
    "slope": number(above=0) | None,
    "share": number(above=0) | None,
    "relocate": flag() | False,
    "coarsen": number(least=0) | None,
}
BUDGET: Keys = {
    "evaluations": COUNT | None,
    "iterations": COUNT | None,
    "tolerance": number(least=0) | None,
}

"""``ffdstudio info``: what a file holds."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from ffdstudio.cli.output import emit, sized
from ffdstudio.engine import Lattice
from ffdstudio.exchange import read_lattice_file
from ffdstudio.exchange.registry import is_lattice_file
from ffdstudio.files import read_bytes
from ffdstudio.meshes import Mesh, coverage, read_mesh
from ffdstudio.project.checks.freezing import face_name


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("file", metavar="FILE", help="mesh, lattice or project")
    parser.add_argument("--json", action="store_true", help="print one JSON object")


def run(args: argparse.Namespace) -> int:
    """Describe the file."""
    if args.file.lower().endswith(".ffdproj"):
        result = of_project(args.file)
    elif is_lattice_file(args.file):
        result = of_lattice(args.file)
    else:
        result = of_mesh(args.file)
    emit(result, "\n".join(_lines(result)), args.json)
    return 0


def of_mesh(path: str) -> dict[str, Any]:
    """Describe a mesh, and the lattices embedded in its file."""
    mesh: Mesh = read_mesh(path)
    seen = coverage(mesh)
    return {
        "format": mesh.format,
        "dimension": mesh.dimension,
        "nodes": len(mesh.points),
        "cells": mesh.counts,
        "unchecked": seen.unchecked,
        "markers": mesh.marker_counts,
        "bounds": mesh.bounds,
        "lattices": _embedded(path),
    }


def of_lattice(path: str) -> dict[str, Any]:
    """Describe a lattice file."""
    content = read_lattice_file(path)
    return {
        "format": content.format,
        **_lattice(content.rest),
        "deformed": content.rest != content.current,
        "frozen": content.frozen,
        "open_faces": [face_name(face) for face in content.open_faces],
        "units": content.units,
        "blocks": content.blocks,
        "notes": content.notes,
    }


def of_project(path: str) -> dict[str, Any]:
    """Describe a project file, and what is wrong with its meshes."""
    from ffdstudio.project import Project

    project = Project.open(path)
    return {
        "format": "ffdstudio-project",
        "bodies": {body.name: str(body.path) for body in project.bodies},
        "lattices": {record.name: _lattice(record.rest) for record in project.lattices},
        "sections": list(project.sections),
        "problems": project.problems,
    }


def _embedded(path: str) -> list[dict[str, Any]]:
    if Path(path).suffix.lower() != ".su2":
        return []
    from ffdstudio.exchange import su2

    boxes = su2.lattices(read_bytes(path), path)
    return [
        {"tag": tag, **(_lattice(box) if isinstance(box, Lattice) else {"broken": str(box)})}
        for tag, box in boxes
    ]


def _lattice(lattice: Lattice) -> dict[str, Any]:
    flat = lattice.control_points.reshape(-1, 3)
    return {
        "dimension": lattice.dimension,
        "shape": lattice.shape,
        "degrees": lattice.degrees,
        "bounds": [flat.min(axis=0), flat.max(axis=0)],
    }


def _lines(result: dict[str, Any]) -> list[str]:
    width = max(map(len, result))
    return [f"{key:<{width}}  {_shown(key, value)}" for key, value in result.items()]


def _shown(key: str, value: Any) -> str:
    if key == "bounds":
        return "  to  ".join("(" + ", ".join(f"{x:g}" for x in corner) + ")" for corner in value)
    if key == "shape":
        return sized(value)
    if isinstance(value, dict):
        return ", ".join(f"{k} {_shown(k, v)}" for k, v in value.items()) or "none"
    if isinstance(value, list | tuple):
        return ", ".join(_shown("", item) for item in value) or "none"
    return str(value)

"""Lattices that close on themselves, in a document and its files."""

import json

import numpy as np

from ffdstudio import Lattice, write_lattice
from ffdstudio.optimize.runs.record import pack, unpack
from ffdstudio.project.checks.deformation_warnings import parted_seams
from ffdstudio.project.commands import FreezeLayers, InsertKnots, MovePoints
from ffdstudio.project.document import Document
from ffdstudio.project.files.command_codec import READERS, lattice_out


def test_a_ring_is_opened_edited_refined_saved_and_reopened(tmp_path):
    path = tmp_path / "ring.lattice.json"
    write_lattice(path, Lattice.cylinder((0.4, 1.1), shape=(6, 9)), frozen=1)
    document = Document()
    document.import_lattice(path)
    item = document.model.lattices[0]
    assert item.frozen_mask.all(axis=1).tolist() == [True, *[False] * 4, True]
    moved = item.rest.control_points[1:3, 0] + 0.03
    document.do(MovePoints(item.key, ((1, 0), (2, 0)), tuple(map(tuple, moved.tolist()))))
    document.do(InsertKnots(item.key, 1, (0.0, 0.1)))
    document.do(FreezeLayers(item.key, 2))
    document.undo()
    now = document.model.lattices[0]
    assert now.rest.periodic == (False, True)
    u = np.random.default_rng(0).uniform(*now.rest.domain.T, (200, 2))
    assert np.abs(now.rest.evaluate(u) - item.rest.evaluate(u)).max() < 1e-14
    document.save(tmp_path / "ring.ffdproj")
    again = Document()
    again.open(tmp_path / "ring.ffdproj")
    stored = again.model.lattices[0]
    assert stored.rest == now.rest
    assert stored.current == now.current
    assert stored.deformed
    assert (stored.frozen, stored.open_faces) == (1, ((1, 0), (1, 1)))


def test_journals_and_records_of_studies_say_all_of_a_ring():
    ring = Lattice.cylinder((0.4, 1.1), heights=(0, 1), shape=(4, 9, 3))
    turned = ring.moved(ring.control_points + 0.1, np.full(ring.shape, 2.0))
    for lattice in (ring, turned, ring.clamped()):
        assert READERS["Lattice"](json.loads(json.dumps(lattice_out(lattice)))) == lattice
        assert unpack(json.loads(json.dumps(pack(lattice)))) == lattice


def test_the_ends_of_a_clamped_ring_that_move_apart_are_told():
    ring = Lattice.cylinder((0.4, 1.1), heights=(0, 1), shape=(4, 9, 3))
    for lattice, column, said in [(ring.clamped(), 0, True), (ring.clamped(), 4, False),
                                  (ring, 0, False), (ring, 8, False)]:  # fmt: skip
        net = lattice.control_points.copy()
        net[:, column] += 0.05
        told = parted_seams(lattice, lattice.moved(net))
        assert bool(told) == said
    both = ring.clamped().control_points.copy()
    both[:, [0, -1]] += 0.05
    assert parted_seams(ring.clamped(), ring.clamped().moved(both)) == []
    box = Lattice.box([0, 0], [1, 1], shape=(4, 4))
    assert parted_seams(box, box.moved(box.control_points**2)) == []

"""Sections of any length and place are told in chords."""

import numpy as np

from ffdstudio.meshes.airfoil import naca4
from ffdstudio.optimize.geometry.chord import Chord


def test_a_chord_of_one_stays_exactly_one():
    contour = naca4("0012", points=41)
    assert Chord.of(contour) == Chord(0.0, 0.0, 1.0)


def test_a_moved_and_scaled_section_is_told_in_chords():
    contour = np.column_stack([naca4("2412", points=41), np.zeros(81)])
    chord = Chord.of(3 * contour + [5, 1, 0])
    assert np.allclose(chord.local(3 * contour + [5, 1, 0])[:, 0].max(), 1)
    assert np.allclose(chord.world(chord.local(contour)), contour)

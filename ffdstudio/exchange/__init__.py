"""Lattice files, ours and those of other tools, and what is lost on the way."""

from ffdstudio.exchange.latticefile import Exactness, LatticeFile
from ffdstudio.exchange.registry import read_lattice, read_lattice_file, write_lattice

__all__ = ["Exactness", "LatticeFile", "read_lattice", "read_lattice_file", "write_lattice"]

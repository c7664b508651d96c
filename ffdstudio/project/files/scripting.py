"""`Project`: a project file in the hands of a script."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, Self

from ffdstudio.engine import Lattice
from ffdstudio.errors import InputError
from ffdstudio.meshes import Mesh, read_mesh
from ffdstudio.paths import as_path
from ffdstudio.project.files import references
from ffdstudio.project.files.records import BodyRecord, LatticeRecord, ProjectFile
from ffdstudio.project.files.storage import read_project, write_project


class Project:
    """Bodies, lattices and everything else that one ``*.ffdproj`` file holds.

    Attributes
    ----------
    file : ProjectFile
        The stored form, free to be changed before `save`.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "wing.ffdproj"
    >>> project = Project()
    >>> _ = project.add_lattice("box", Lattice.box([0, 0, 0], [1, 1, 1], shape=(4, 3, 2)))
    >>> project.save(path)
    >>> Project.open(path).lattices[0].rest
    Lattice(4x3x2, degrees=(3, 2, 1))
    """

    def __init__(self, file: ProjectFile | None = None) -> None:
        self.file = file if file is not None else ProjectFile()

    @classmethod
    def open(cls, path: str | os.PathLike[str]) -> Self:
        """Read a project file; see `problems` for what is wrong with its meshes.

        Raises
        ------
        InputError
            If it cannot be read, is damaged or was written by a newer version.

        Examples
        --------
        >>> Project.open("nowhere.ffdproj")
        Traceback (most recent call last):
            ...
        ffdstudio.errors.InputError: cannot read 'nowhere.ffdproj': no such file or directory
        """
        return cls(read_project(as_path(path)))

    def save(self, path: str | os.PathLike[str], pack_meshes: bool = False) -> None:
        """Write the project file atomically; with `pack_meshes` the meshes travel inside.

        Examples
        --------
        >>> import tempfile
        >>> from ffdstudio.samples import sample
        >>> path = Path(tempfile.mkdtemp()) / "foil.ffdproj"
        >>> project = Project()
        >>> _ = project.add_mesh(sample("naca0012.dat"))
        >>> project.save(path, pack_meshes=True)
        >>> len(Project.open(path).mesh("naca0012").points)
        161
        """
        write_project(as_path(path), self.file, pack_meshes)

    @property
    def bodies(self) -> list[BodyRecord]:
        """The meshes of the project.

        Examples
        --------
        >>> project = Project()
        >>> _ = project.add_mesh("wing.su2")
        >>> [body.name for body in project.bodies]
        ['wing']
        """
        return self.file.bodies

    @property
    def lattices(self) -> list[LatticeRecord]:
        """The lattices of the project.

        Examples
        --------
        >>> project = Project()
        >>> _ = project.add_lattice("box", Lattice.box([0, 0], [1, 1], shape=(4, 4)), frozen=1)
        >>> [(record.name, record.frozen) for record in project.lattices]
        [('box', 1)]
        """
        return self.file.lattices

    @property
    def sections(self) -> dict[str, Any]:
        """Saved shapes, studies, journal and other open-ended parts by name.

        Examples
        --------
        >>> project = Project()
        >>> project.sections["notes"] = {"author": "Ada"}
        >>> list(project.sections)
        ['notes']
        """
        return self.file.sections

    @property
    def problems(self) -> list[str]:
        """Sentences about meshes that were missing or changed when the project was opened.

        Examples
        --------
        >>> Project().problems
        []
        """
        return self.file.problems

    def add_mesh(self, path: str | os.PathLike[str], name: str | None = None) -> BodyRecord:
        """Refer to a mesh file under a name, by default the file's.

        Examples
        --------
        >>> Project().add_mesh("meshes/wing.su2", "left wing").name
        'left wing'
        """
        given = as_path(path)
        body = BodyRecord(name or given.stem, Path(os.path.realpath(given)))
        self._check_free(body.name, self.bodies)
        self.bodies.append(body)
        return body

    def add_lattice(
        self, name: str, rest: Lattice, current: Lattice | None = None, frozen: int = 0
    ) -> LatticeRecord:
        """Add a lattice at rest, and as deformed if that differs.

        Examples
        --------
        >>> box = Lattice.box([0, 0], [1, 1], shape=(4, 4))
        >>> record = Project().add_lattice("box", box, box.moved(box.control_points + 0.5))
        >>> record.current.control_points[0, 0]
        array([0.5, 0.5, 0.5])
        """
        record = LatticeRecord(name, rest, current if current is not None else rest, frozen)
        if not rest.same_space(record.current):
            raise InputError(f'the lattice "{name}" and its deformed form do not fit together')
        self._check_free(name, self.lattices)
        self.lattices.append(record)
        return record

    def mesh(self, name: str) -> Mesh:
        """Read the mesh of a body, from the disk or out of the project file.

        Examples
        --------
        >>> from ffdstudio.samples import sample
        >>> project = Project()
        >>> _ = project.add_mesh(sample("naca0012.dat"))
        >>> project.mesh("naca0012")
        <Mesh of 161 nodes, 160 line>
        """
        for body in self.bodies:
            if body.name == name:
                with references.on_disk(body) as path:
                    return read_mesh(path)
        raise InputError(f'the project has no body "{name}"')

    @staticmethod
    def _check_free(name: str, records: list[Any]) -> None:
        if any(record.name == name for record in records):
            raise InputError(f'the project already has a "{name}"')

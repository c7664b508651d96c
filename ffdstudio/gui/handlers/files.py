"""Files in and out: what the File menu does."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from pathlib import Path

from PySide6.QtWidgets import QMenu

from ffdstudio.exchange.morphed import has_boxes
from ffdstudio.gui.dialogs.ask import Question
from ffdstudio.gui.dialogs.waiting import wait_for
from ffdstudio.gui.jobs import Job
from ffdstudio.gui.start import examples
from ffdstudio.gui.studio import Studio
from ffdstudio.meshes.formats import suffix_of
from ffdstudio.project.commands import TreatBoxes
from ffdstudio.project.document import Document
from ffdstudio.project.files.exporting import overwrites
from ffdstudio.project.model import Body
from ffdstudio.project.view.volume import DeformedVolume

PROJECT = ".ffdproj"
PROJECT_FILTER = f"FFD Studio project (*{PROJECT})"
JOURNAL_FILTER = "Journal (*.journal)"
PICTURE_FILTER = "Picture (*.png *.jpg *.webp)"


def open_filters() -> str:
    """Filters of the open dialog: all that is known first, then one by one, then anything."""
    from ffdstudio.exchange.registry import FORMATS as LATTICES
    from ffdstudio.meshes.formats import FORMATS as MESHES

    rows = [("Projects", [PROJECT])]
    rows += [(row.title, list(row.suffixes)) for row in MESHES if row.suffixes]
    rows.append(("Compressed meshes", [f"{s}.gz" for row in MESHES for s in row.suffixes]))
    rows += [(row.title, list(row.suffixes)) for row in LATTICES]
    every = sorted({suffix for _, suffixes in rows for suffix in suffixes})
    lines = [("All known files", every), *rows, ("All files", [""])]
    return ";;".join(
        f"{title} ({' '.join('*' + s for s in suffixes)})" for title, suffixes in lines
    )


def lattice_filters() -> str:
    """Filters for writing a lattice, ours first."""
    from ffdstudio.exchange.registry import FORMATS

    return ";;".join(f"{row.title} ({' '.join('*' + s for s in row.suffixes)})" for row in FORMATS)


class FileHandler:
    """Opens, saves and exports."""

    def __init__(
        self, studio: Studio, picture: Callable[[Path], None], close: Callable[[], bool]
    ) -> None:
        self._studio = studio
        self._picture = picture
        self._close = close
        self.chosen_body: Callable[[], Body | None] = lambda: None
        self.show_inverted: Callable[[str], None] = lambda key: None
        self.may_stop: Callable[[], bool] = lambda: True  # asks if a study is under way
        studio.document.may_replace = self.may_discard
        studio.document.may_overwrite = self.may_overwrite

    @property
    def _document(self) -> Document:
        return self._studio.document

    # ---- in ---------------------------------------------------------------------------------

    def open(self) -> None:
        """Ask for files and open them."""
        paths = self._studio.asker.open_paths("Open", open_filters(), self._folder())
        self.open_paths(paths)

    def open_folder(self) -> None:
        """Ask for a folder that is a mesh, such as a case of OpenFOAM, and open it."""
        path = self._studio.asker.open_folder("Open case folder", self._folder())
        if path is not None:
            self.open_paths([path])

    def open_paths(self, paths: Iterable[Path]) -> None:
        """Open projects, lattices and meshes, each by its name."""
        for path in paths:
            self._open_one(Path(os.path.abspath(path)))  # noqa: PTH100 - keeps symbolic links

    def _open_one(self, path: Path) -> None:
        name = path.name.lower()
        if name.endswith(PROJECT):
            if self.may_discard():
                self._document.open(path)
            else:
                return
        elif is_lattice(name):
            self._document.import_lattice(path)
        else:
            self._document.open_mesh(path)
        self._studio.settings.put("folder", str(path.parent))
        self._studio.said.emit(f"Opening {path.name} …")

    def remember(self, path: Path) -> None:
        """Put a file among the recent ones: it was opened, or a project saved."""
        self._studio.settings.remember(path)

    def fill_recent(self, menu: QMenu) -> None:
        """List recent files in a menu."""
        menu.clear()
        for path in self._studio.settings.recent():
            self._offer(menu, path.name, str(path), path)
        menu.addSeparator()
        menu.addAction("Forget these").triggered.connect(self._studio.settings.forget_recent)

    def fill_examples(self, menu: QMenu) -> None:
        """List the samples that come with the program in a menu."""
        menu.clear()
        for example in examples():
            self._offer(menu, f"{example.title}: {example.text}", str(example.path), example.path)

    def _offer(self, menu: QMenu, text: str, tip: str, path: Path) -> None:
        action = menu.addAction(text.replace("&", "&&"))
        action.setStatusTip(tip)
        action.triggered.connect(lambda: self.open_paths([path]))

    def new(self) -> None:
        """Start afresh."""
        if self.may_discard():
            self._document.clear()

    # ---- out --------------------------------------------------------------------------------

    def save(self) -> None:
        """Save under the project's name; ask for one if there is none."""
        if self._document.path is None:
            self.save_as()
        else:
            self._document.save(self._document.path)

    def save_as(self, pack: bool = False) -> None:
        """Save under a name to be asked for."""
        suggestion = self._document.path or self._suggest(PROJECT)
        path = self._studio.asker.save_path("Save project", PROJECT_FILTER, suggestion)
        if path is not None:
            self._document.save(path, pack_meshes=pack)
            self._studio.settings.put("folder", str(path.parent))

    def save_packed(self) -> None:
        """Save with the meshes inside."""
        self.save_as(pack=True)

    def export_mesh(self) -> None:
        """Write a deformed body: the chosen one, or the only one."""
        body = self.chosen_body() or self._document.model.bodies[0]
        if not self._confirmed(body):
            return
        source = Path(body.path)
        suffix = suffix_of(source)
        stem = source.name[: len(source.name) - len(suffix)]
        suggestion = source.with_name(f"{stem}_deformed{source.name[len(stem) :]}")
        filters = f"As it came (*{suffix});;" + open_filters().split(";;", 2)[2]
        path = self._studio.asker.save_path(f"Export {body.name}", filters, suggestion)
        if path is not None and self._may_replace(path):
            self._document.export_mesh(body.key, path)

    def _may_replace(self, path: Path) -> bool:
        """Ask before a mesh is written over one that the project was opened from."""
        bodies = self._document.model.bodies
        owner = next((body for body in bodies if overwrites(body, path)), None)
        if owner is None:
            return True
        question = Question(
            "The undeformed mesh",
            f"{path.name} is the file that {owner.name} was opened from.",
            "The project deforms that mesh: once it is replaced, opening the project would "
            "deform it a second time.",
            (("other", "Choose &another name…"), ("replace", "&Replace it"), ("cancel", "Cancel")),
        )
        answer = self._studio.asker.choose(question)
        if answer == "other":
            self.export_mesh()
        return answer == "replace"

    def _confirmed(self, body: Body) -> bool:
        """Ask before anything is written that a solver will not take, and for FFD boxes."""
        if self._document.volume(body.key) is None:
            self._document.check()
            wait_for(
                self._studio.jobs,
                lambda job: job.key == f"volume {body.key}",
                f"Checking the cells of {body.name} …",
                self._studio.asker.parent,
            )
        volume = self._document.volume(body.key)
        if volume is None and self._studio.asker.choose(_unchecked(body)) != "export":
            return False
        if volume is not None and volume.inverted and not self._takes_inverted(body, volume):
            return False
        if volume is not None and volume.broken and not self._takes_broken(body, volume):
            return False
        return self._boxes_chosen(body)

    def _takes_broken(self, body: Body, volume: DeformedVolume) -> bool:
        question = Question(
            "Boundaries",
            f"Boundaries of {body.name} are not what they were.",
            ".\n".join(volume.broken) + ".\n\nA solver may refuse this mesh, or compute something "
            "else. A lattice that begins at the plane keeps it.",
            (("export", "&Export all the same"), ("cancel", "&Do not export")),
        )
        return self._studio.asker.choose(question) == "export"

    def _boxes_chosen(self, body: Body) -> bool:
        """Ask what becomes of FFD boxes in the file; the choice is a command of the document."""
        if not has_boxes(body.mesh):
            return True
        answers = {
            "update": "&Update them",
            "strip": "&Leave them out",
            "keep": "&Keep them as they are",
        }
        order = sorted(answers, key=lambda key: key != body.boxes)  # the last choice first
        question = Question(
            "FFD boxes",
            f"The file of {body.name} holds FFD boxes.",
            "Updated, they follow the shape. Kept as they are, SU2_DEF would move the shape back.",
            (*((key, answers[key]) for key in order), ("cancel", "Cancel")),
        )
        answer = self._studio.asker.choose(question)
        if answer not in answers:
            return False
        return answer == body.boxes or self._studio.do(TreatBoxes(body.key, answer))

    def _takes_inverted(self, body: Body, volume: DeformedVolume) -> bool:
        question = Question(
            "Inverted cells",
            f"{volume.inverted} cells of {body.name} are inside out.",
            "A solver will refuse this mesh. Undo the last edits, or export it all the same.",
            (
                ("show", "&Show the cells"),
                ("export", "&Export all the same"),
                ("cancel", "&Do not export"),
            ),
        )
        answer = self._studio.asker.choose(question)
        if answer == "show":
            self.show_inverted(body.key)
        return answer == "export"

    def export_lattice(self) -> None:
        """Write the active lattice."""
        item = self._document.model.active_lattice
        if item is None:
            return
        suggestion = self._folder() / f"{item.name}.lattice.json"
        path = self._studio.asker.save_path(f"Export {item.name}", lattice_filters(), suggestion)
        if path is not None:
            self._document.export_lattice(item.key, path)

    def export_picture(self) -> None:
        """Write what the viewport shows."""
        path = self._studio.asker.save_path("Export picture", PICTURE_FILTER, self._suggest(".png"))
        if path is not None:
            done = self._studio.attempt(
                "Export picture", lambda: self._picture(path), self.export_picture
            )
            if done:
                self._studio.say(f"{path} written")

    def export_journal(self) -> None:
        """Write the journal."""
        target = self._suggest(".journal")
        path = self._studio.asker.save_path("Export journal", JOURNAL_FILTER, target)
        if path is not None:
            save = lambda: self._document.journal.save(path)  # noqa: E731
            if self._studio.attempt("Export journal", save, self.export_journal):
                self._studio.say(f"{path} written: repeat it with  ffdstudio replay {path.name}")

    def quit(self) -> None:
        """Close the window."""
        self._close()

    # ---- questions --------------------------------------------------------------------------

    def may_discard(self) -> bool:
        """Ask what to do with unsaved changes; whether they may go, because saved or unwanted."""
        if not self.may_stop():
            return False
        self._studio.jobs.finish(_writes)
        if not self._document.modified:
            return True
        name = self._document.path.name if self._document.path else "this project"
        question = Question(
            "Unsaved changes",
            f"Save the changes in {name}?",
            "They will be lost otherwise.",
            (("save", "&Save"), ("discard", "&Discard"), ("cancel", "Cancel")),
        )
        answer = self._studio.asker.choose(question)
        if answer == "save":
            self.save()
            self._studio.jobs.finish(_writes)
            return not self._document.modified
        return answer == "discard"

    def may_overwrite(self, path: Path) -> bool:
        """Ask before a project is saved over what somebody else has made of its file."""
        question = Question(
            "Changed by another program",
            f"{path.name} has changed since it was opened here.",
            "Another window or program has written it. Replacing it loses what was saved there; "
            "under another name both are kept.",
            (
                ("other", "Save under &another name…"),
                ("replace", "&Replace it"),
                ("cancel", "Cancel"),
            ),
        )
        answer = self._studio.asker.choose(question)
        if answer == "other":
            self.save_as()
        return answer == "replace"

    def _folder(self) -> Path:
        return Path(self._studio.settings.text("folder", str(Path.home())))

    def _suggest(self, suffix: str) -> Path:
        if self._document.path is not None:
            return self._document.path.with_suffix(suffix)
        bodies = self._document.model.bodies
        return self._folder() / ((bodies[0].name if bodies else "project") + suffix)


def _unchecked(body: Body) -> Question:
    return Question(
        "Cells not checked",
        f"It is not known whether cells of {body.name} are inside out.",
        "A solver refuses a mesh with such cells. Export again to check them first.",
        (("export", "&Export unchecked"), ("cancel", "&Do not export")),
    )


def _writes(job: Job) -> bool:
    """Whether a job writes what the user has asked for."""
    return job.label.startswith(("Saving", "Exporting"))


def is_lattice(name: str) -> bool:
    """Whether a file's name says that it holds a lattice, PLOT3D's names among them."""
    from ffdstudio.exchange.registry import is_lattice_file

    return is_lattice_file(name)

"""Every edit as a value: named, undoable, and sayable in one line of the journal.

A command is a frozen dataclass of plain values. `apply` makes the next model and touches
nothing else; `label` is what the history shows. What is not in its fields, or in the model
before, has no influence: that is what makes a replay give the same bytes.
"""

from ffdstudio.project.commands.base import Command
from ffdstudio.project.commands.iterate import UseIterate
from ffdstudio.project.commands.net import (
    ElevateDegree,
    FreezeLayers,
    InsertKnots,
    MovePoints,
    RemoveKnots,
    ResetPoints,
    SetWeights,
)
from ffdstudio.project.commands.scene import (
    Activate,
    AddLattice,
    Colour,
    CreateBox,
    Enable,
    Follow,
    Isolate,
    OpenMesh,
    Refit,
    Remove,
    Rename,
    Show,
    ShowMarkers,
    TreatBoxes,
)
from ffdstudio.project.commands.shapes import BlendShapes, RemoveShape, SaveShape
from ffdstudio.project.commands.showing import IsolateMarker, ShowAll
from ffdstudio.project.commands.studies import (
    AddStudy,
    DuplicateStudy,
    RemoveStudy,
    RenameStudy,
)

COMMANDS: dict[str, type[Command]] = {
    command.verb: command
    for command in (
        Activate,
        AddLattice,
        AddStudy,
        BlendShapes,
        Colour,
        CreateBox,
        DuplicateStudy,
        ElevateDegree,
        Enable,
        Follow,
        FreezeLayers,
        InsertKnots,
        Isolate,
        IsolateMarker,
        MovePoints,
        OpenMesh,
        Refit,
        Remove,
        RemoveKnots,
        RemoveShape,
        RemoveStudy,
        Rename,
        RenameStudy,
        ResetPoints,
        SaveShape,
        SetWeights,
        Show,
        ShowAll,
        ShowMarkers,
        TreatBoxes,
        UseIterate,
    )
}
"""All commands by their word in the journal."""

__all__ = [
    "COMMANDS",
    "Activate",
    "AddLattice",
    "AddStudy",
    "BlendShapes",
    "Colour",
    "Command",
    "CreateBox",
    "DuplicateStudy",
    "ElevateDegree",
    "Enable",
    "Follow",
    "FreezeLayers",
    "InsertKnots",
    "Isolate",
    "IsolateMarker",
    "MovePoints",
    "OpenMesh",
    "Refit",
    "Remove",
    "RemoveKnots",
    "RemoveShape",
    "RemoveStudy",
    "Rename",
    "RenameStudy",
    "ResetPoints",
    "SaveShape",
    "SetWeights",
    "Show",
    "ShowAll",
    "ShowMarkers",
    "TreatBoxes",
    "UseIterate",
]

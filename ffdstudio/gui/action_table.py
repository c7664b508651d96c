# ruff: noqa: E501 - a table is read best with one row a line
"""Everything that can be done, in one table.

Menus, toolbar, shortcuts, tooltips, status line, command palette and shortcut sheet are all
made from it. A row's name is ``handler.method``: "file.open" calls `open` of the handler
"file". `needs` names the condition under which it is enabled (see `conditions`).
"""

from __future__ import annotations

from dataclasses import dataclass

FILE, EDIT, SELECT, LATTICE, VIEW, HELP = "&File", "&Edit", "&Select", "&Lattice", "&View", "&Help"
QUALITY = "&Quality"
STUDY = "St&udy"
MENUS = (FILE, EDIT, SELECT, LATTICE, QUALITY, STUDY, VIEW, HELP)


@dataclass(frozen=True)
class ActionRow:
    """One action. `check` makes it a switch; rows of one `group` exclude each other."""

    name: str
    text: str
    menu: str
    tip: str
    keys: tuple[str, ...] = ()
    icon: str = ""
    needs: str = ""
    toolbar: bool = False
    check: bool = False
    group: str = ""
    line_before: bool = False
    submenu: str = ""

    @property
    def plain(self) -> str:
        """Text without the mnemonic's mark."""
        return self.text.replace("&", "")


# fmt: off
ROWS: tuple[ActionRow, ...] = (
    ActionRow("file.open", "&Open…", FILE, "Open meshes, lattices or a project", ("Ctrl+O",), "folder-open-outline", toolbar=True),
    ActionRow("file.open_folder", "Open case &folder…", FILE, "Open a mesh that is a folder, such as a case of OpenFOAM", ("Ctrl+Shift+O",), "folder-outline"),
    ActionRow("file.new", "&New project", FILE, "Close everything and start afresh", ("Ctrl+N",), "file-outline", "anything"),
    ActionRow("file.save", "&Save", FILE, "Save the project", ("Ctrl+S",), "content-save-outline", "anything", toolbar=True, line_before=True),
    ActionRow("file.save_as", "Save &as…", FILE, "Save the project under another name", ("Ctrl+Shift+S",), "content-save-edit-outline", "anything"),
    ActionRow("file.save_packed", "Save &packed…", FILE, "Save a project that carries its meshes", (), "package-variant-closed", "anything"),
    ActionRow("file.export_mesh", "&Export mesh…", FILE, "Write the deformed mesh: its own file with new coordinates", ("Ctrl+E",), "export-variant", "body", toolbar=True, line_before=True),
    ActionRow("file.export_lattice", "Export &lattice…", FILE, "Write the active lattice, at rest and as it is now", ("Ctrl+Shift+E",), "vector-polyline", "lattice"),
    ActionRow("file.export_picture", "Export p&icture…", FILE, "Write what the viewport shows", ("Ctrl+Shift+I",), "image-outline", "anything"),
    ActionRow("file.export_journal", "Export &journal…", FILE, "Write every edit as lines that `ffdstudio replay` repeats", (), "script-text-outline", "anything"),
    ActionRow("file.quit", "&Quit", FILE, "Close the window", ("Ctrl+Q",), "exit-to-app", line_before=True),
    ActionRow("edit.undo", "&Undo", EDIT, "Take back the last edit", ("Ctrl+Z",), "undo", "undo", toolbar=True),
    ActionRow("edit.redo", "&Redo", EDIT, "Do again what was taken back", ("Ctrl+Shift+Z", "Ctrl+Y"), "redo", "redo", toolbar=True),
    ActionRow("edit.move_mode", "&Move points", EDIT, "Drag control points: X, Y, Z lock an axis; with Shift, a plane", ("M",), "cursor-move", "lattice", toolbar=True, check=True, group="mode", line_before=True),
    ActionRow("edit.rotate_mode", "Ro&tate points", EDIT, "Drag turns the selected points about their centre", ("R",), "rotate-3d-variant", "lattice", toolbar=True, check=True, group="mode"),
    ActionRow("edit.scale_mode", "&Scale points", EDIT, "Drag scales the selected points about their centre", ("S",), "arrow-expand-all", "lattice", toolbar=True, check=True, group="mode"),
    ActionRow("edit.skin_mode", "Drag the s&kin", EDIT, "Drag a point of the mesh; the lattice follows by the smallest move, selected control points are held", ("P",), "gesture-tap-hold", "lattice", toolbar=True, check=True, group="mode"),
    ActionRow("edit.soft", "S&oft selection", EDIT, "Points near the selected ones follow; the wheel changes the radius during a drag", ("O",), "blur", "lattice", check=True),
    ActionRow("edit.mirror_off", "&Off", EDIT, "Move the selected points only", (), "", "lattice", check=True, group="mirror", submenu="S&ymmetry"),
    ActionRow("edit.mirror_x", "About x = 0", EDIT, "Points opposite the plane x = 0 follow as a mirror image", (), "", "lattice", check=True, group="mirror", submenu="S&ymmetry"),
    ActionRow("edit.mirror_y", "About y = 0", EDIT, "Points opposite the plane y = 0 follow as a mirror image", (), "", "lattice", check=True, group="mirror", submenu="S&ymmetry"),
    ActionRow("edit.mirror_z", "About z = 0", EDIT, "Points opposite the plane z = 0 follow as a mirror image", (), "", "lattice", check=True, group="mirror", submenu="S&ymmetry"),
    ActionRow("edit.transform", "Transform by &numbers…", EDIT, "Move, rotate or scale the selected points by typed values", ("Ctrl+T",), "numeric", "selection"),
    ActionRow("edit.reset_selected", "Reset s&elected points", EDIT, "Put the selected points and their weights back to rest", ("Backspace",), "restore", "selection", line_before=True),
    ActionRow("edit.reset_weights", "Reset &weights of selected points", EDIT, "Set the weights of the selected points to 1", (), "weight", "selection"),
    ActionRow("edit.reset_all", "Reset &all points", EDIT, "Put all points of the active lattice back to rest", ("Ctrl+Backspace",), "backup-restore", "lattice"),
    ActionRow("select.box_mode", "Rubber &band", SELECT, "Select points by drawing a rectangle; Shift adds", ("B",), "select-drag", "lattice", toolbar=True, check=True, group="mode"),
    ActionRow("select.all", "&All", SELECT, "Select all points that are not frozen", ("Ctrl+A", "A"), "select-all", "lattice", line_before=True),
    ActionRow("select.none", "&None", SELECT, "Select nothing", ("Ctrl+D",), "select-off", "selection"),
    ActionRow("select.invert", "In&vert", SELECT, "Select what is not selected", ("Ctrl+I",), "select-inverse", "lattice"),
    ActionRow("select.grow", "&Grow", SELECT, "Add the neighbours of the selected points", ("+", "Ctrl++"), "arrow-expand", "selection"),
    ActionRow("select.row_i", "Row along &i", SELECT, "Select the rows along i through the selected points", ("I",), "", "selection", line_before=True),
    ActionRow("select.row_j", "Row along &j", SELECT, "Select the rows along j through the selected points", ("J",), "", "selection"),
    ActionRow("select.row_k", "Row along &k", SELECT, "Select the rows along k through the selected points", ("K",), "", "volume selection"),
    ActionRow("select.plane_i", "Plane of equal i", SELECT, "Select the planes of equal i through the selected points", ("Shift+I",), "", "selection", line_before=True),
    ActionRow("select.plane_j", "Plane of equal j", SELECT, "Select the planes of equal j through the selected points", ("Shift+J",), "", "selection"),
    ActionRow("select.plane_k", "Plane of equal k", SELECT, "Select the planes of equal k through the selected points", ("Shift+K",), "", "volume selection"),
    ActionRow("lattice.new", "&New lattice…", LATTICE, "Build a lattice around the meshes, a marker or typed bounds", ("Ctrl+L",), "grid", "body", toolbar=True),
    ActionRow("lattice.load", "&Load lattice…", LATTICE, "Add a lattice from a file", ("Ctrl+Shift+L",), "vector-polyline-plus", ""),
    ActionRow("lattice.refit", "&Fit anew…", LATTICE, "Change bounds, counts and degrees of an undeformed lattice", (), "resize", "box lattice"),
    ActionRow("lattice.insert_knot", "Insert a kn&ot…", LATTICE, "More control points where they are needed; the shape stays", ("Ctrl+K",), "plus-box-outline", "lattice", line_before=True),
    ActionRow("lattice.elevate_i", "Raise degree in &i", LATTICE, "One degree more along i; the shape stays", (), "", "lattice"),
    ActionRow("lattice.elevate_j", "Raise degree in &j", LATTICE, "One degree more along j; the shape stays", (), "", "lattice"),
    ActionRow("lattice.elevate_k", "Raise degree in &k", LATTICE, "One degree more along k; the shape stays", (), "", "volume lattice"),
    ActionRow("lattice.next", "Edit ne&xt lattice", LATTICE, "Make the next lattice the active one", ("Ctrl+Tab",), "", "lattices", line_before=True),
    ActionRow("lattice.toggle", "S&witch on or off", LATTICE, "Let the active lattice deform, or not", (), "power", "lattice"),
    ActionRow("lattice.remove", "&Remove lattice", LATTICE, "Remove the active lattice", (), "trash-can-outline", "lattice"),
    ActionRow("quality.show", "&Show quality", QUALITY, "Show the panel of measures, limits and worst cells", ("Q",), "chart-histogram", "body", toolbar=True, line_before=True),
    ActionRow("quality.colour", "&Colour by measure", QUALITY, "Colour the meshes by the measure of the quality panel", ("Shift+Q",), "palette-outline", "body", check=True),
    ActionRow("quality.worst", "Fly to &worst cell", QUALITY, "Fly to the worst cell; again: to the next one", ("W",), "target", "body"),
    ActionRow("quality.guard_stop", "Sto&p drags at the limit", QUALITY, "A drag ends before the first cell breaks the limit", (), "hand-back-left-outline", "body", check=True, group="guard", line_before=True),
    ActionRow("quality.guard_warn", "W&arn at the limit", QUALITY, "The picture says when a drag has passed the limit", (), "alert-outline", "body", check=True, group="guard"),
    ActionRow("quality.guard_free", "&Free drags", QUALITY, "Drags are not guarded", (), "lock-open-variant-outline", "body", check=True, group="guard"),
    ActionRow("study.setup", "&Set up…", STUDY, "Objective, variables, method and refinement of a study", ("Ctrl+U",), "chart-bell-curve-cumulative", "", toolbar=True, line_before=True),
    ActionRow("study.start", "S&tart", STUDY, "Begin the study that the Study panel describes", ("F5",), "play", "study idle"),
    ActionRow("study.pause", "&Pause or go on", STUDY, "Wait at the next iterate, or go on", ("F6",), "pause", "study alive"),
    ActionRow("study.step", "St&ep", STUDY, "One iterate, then wait", ("F7",), "step-forward", "body"),
    ActionRow("study.stop", "St&op", STUDY, "End the study; what was reached is kept", ("Shift+F5",), "stop", "study alive"),
    ActionRow("study.use", "&Use this iterate", STUDY, "Make the lattice what is shown, as an edit", ("Ctrl+Return",), "check", "study shown", line_before=True),
    ActionRow("study.release", "Put &back", STUDY, "Show the lattice as it is in the document again", (), "keyboard-return", "study shown"),
    ActionRow("study.convergence_plot", "&Convergence and timeline", STUDY, "Live plots of all studies, and a slider through the iterates", ("Ctrl+Shift+C",), "chart-line", "", line_before=True),
    ActionRow("study.airfoil", "&Airfoil view", STUDY, "Section, error along the chord, curvature and pressure, live", ("Ctrl+Shift+A",), "airplane", ""),
    ActionRow("study.refine", "&Refine here", STUDY, "The indicator per knot interval; a click inserts the knot", ("Ctrl+Shift+K",), "poll", "lattice"),
    ActionRow("study.load_case", "&Load case…", STUDY, "Fill the form from a case file; its mesh is opened", (), "folder-open-outline", "", line_before=True),
    ActionRow("study.save_case", "Sa&ve as case file…", STUDY, "Write what the form says, for ffdstudio optimize", (), "content-save-outline", "body"),
    ActionRow("study.export", "E&xport convergence…", STUDY, "Write the plot as PNG or SVG, or the figures as CSV", (), "export", "study any", line_before=True),
    ActionRow("view.fit", "&Fit shape", VIEW, "Show the shape and its lattices, without the far field", ("F",), "fit-to-page-outline", "anything", toolbar=True),
    ActionRow("view.fit_all", "Fit e&verything", VIEW, "Show everything, the far field as well", ("Ctrl+F",), "", "anything"),
    ActionRow("view.home", "&Home view", VIEW, "Look as at the beginning", ("Home",), "home-outline", "anything", toolbar=True),
    ActionRow("view.keep", "&Keep this view", VIEW, "Remember where the viewer stands", ("Ctrl+Shift+V",), "", "anything"),
    ActionRow("view.recall", "&Next kept view", VIEW, "Go through the views that were kept", ("Shift+V",), "", "anything"),
    ActionRow("view.fit_selected", "Fit &selection", VIEW, "Come close to the selected points", ("Shift+F",), "image-filter-center-focus", "selection"),
    ActionRow("view.plus_x", "From +&X", VIEW, "Look along -x", ("1",), "", "volume scene", submenu="&Side"),
    ActionRow("view.minus_x", "From -X", VIEW, "Look along +x", ("Ctrl+1",), "", "volume scene", submenu="&Side"),
    ActionRow("view.plus_y", "From +&Y", VIEW, "Look along -y", ("2",), "", "volume scene", submenu="&Side"),
    ActionRow("view.minus_y", "From -Y", VIEW, "Look along +y", ("Ctrl+2",), "", "volume scene", submenu="&Side"),
    ActionRow("view.plus_z", "From +&Z", VIEW, "Look along -z", ("3",), "", "anything", submenu="&Side"),
    ActionRow("view.minus_z", "From -Z", VIEW, "Look along +z", ("Ctrl+3",), "", "volume scene", submenu="&Side"),
    ActionRow("view.corner", "From a &corner", VIEW, "Look from a corner", ("0",), "axis-arrow", "volume scene", toolbar=True, submenu="&Side"),
    ActionRow("view.parallel", "&Parallel projection", VIEW, "Equal lengths look equally long at any distance", ("5",), "cube-outline", "volume scene", toolbar=True, check=True),
    ActionRow("view.ghost", "&Undeformed shape", VIEW, "Show where the meshes were, as a ghost", ("G",), "ghost-outline", "body", toolbar=True, check=True, line_before=True),
    ActionRow("view.look_shaded", "&Shaded", VIEW, "Light and soft bands that move when a slope changes", (), "", "body", check=True, group="look", submenu="&Colour by"),
    ActionRow("view.look_matte", "&Matte", VIEW, "Plain light, without the soft bands that show slopes", (), "", "volume scene", check=True, group="look", submenu="&Colour by"),
    ActionRow("view.look_displacement", "&Displacement", VIEW, "Colour by how far each point has moved, live", ("D",), "", "body", check=True, group="look", submenu="&Colour by"),
    ActionRow("view.look_curvature", "&Curvature", VIEW, "Colour by mean curvature: bumps and hollows", (), "", "volume scene", check=True, group="look", submenu="&Colour by"),
    ActionRow("view.look_reflection", "&Reflection lines", VIEW, "Stripes that break where a surface is not smooth", ("V",), "", "volume scene", check=True, group="look", submenu="&Colour by"),
    ActionRow("view.outer", "&Outer boundaries", VIEW, "Show the far field and symmetry planes around the walls", ("H",), "border-outside", "volume body", check=True),
    ActionRow("view.edges", "Mesh &edges", VIEW, "Show the edges of the cells", ("E",), "triangle-outline", "body", check=True),
    ActionRow("view.inside", "Points &inside", VIEW, "Show the mesh points inside the active lattice", ("N",), "dots-hexagon", "lattice", check=True),
    ActionRow("view.net", "&Lattices", VIEW, "Show the control nets", ("L",), "grid", "lattice", check=True),
    ActionRow("view.section", "Se&ction plane", VIEW, "Cut a volume mesh open along a plane", ("C",), "circle-half-full", "volume body", toolbar=True, check=True),
    ActionRow("view.slices", "Section curves", VIEW, "Curves of a section before and now, with chord, thickness, camber and twist, live", ("Shift+C",), "chart-bell-curve", "volume scene"),
    ActionRow("view.isolate", "Isolate &body", VIEW, "Show the chosen body alone", ("Shift+H",), "eye-outline", "bodies", line_before=True),
    ActionRow("view.show_all", "Show &all", VIEW, "Show all bodies, markers and lattices", ("Ctrl+H",), "eye-check-outline", "anything"),
    ActionRow("view.light", "&Light", VIEW, "Dark on light", (), "", "", check=True, group="theme", submenu="&Theme"),
    ActionRow("view.dark", "&Dark", VIEW, "Light on dark", (), "", "", check=True, group="theme", submenu="&Theme"),
    ActionRow("view.reset_layout", "&Reset layout", VIEW, "Put panels and toolbar back where they were at first", (), "view-dashboard-outline", ""),
    ActionRow("help.palette", "&Command palette…", HELP, "Find any command by a few letters", ("Ctrl+Shift+P",), "magnify", toolbar=True),
    ActionRow("help.shortcuts", "&Shortcuts", HELP, "All keys and mouse moves on one sheet", ("F1",), "keyboard-outline"),
    ActionRow("help.log", "Show &log", HELP, "What the program wrote down about errors", (), "text-box-outline"),
    ActionRow("help.about", "&About", HELP, "Version and licence", (), "information-outline"),
)
# fmt: on

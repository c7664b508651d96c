"""From the command to the sample on the screen, against an empty window with a viewport.

Both are whole processes, started by turns and timed from process start to the first picture
that shows the sample (or the empty viewport). The target is at most 1.5 times.

    xvfb-run -a -s "-screen 0 1600x1200x24" python benchmarks/bench_startup.py [repetitions]
"""

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

SAMPLE = Path(__file__).parents[1] / "sample_meshes" / "wing_skin.vtu"

EMPTY = """
import sys, time
from PySide6.QtWidgets import QApplication, QMainWindow
app = QApplication([])
from pyvistaqt import QtInteractor
class View(QtInteractor):
    def paintGL(self):
        super().paintGL()
        print(time.time(), flush=True)
        import os; os._exit(0)
window = QMainWindow()
view = View(window, auto_update=False)
window.setCentralWidget(view)
window.resize(1280, 800)
window.show()
app.exec()
"""

OURS = """
import os, sys, time
from ffdstudio.gui import viewport
class View(viewport.Viewport):
    def paintGL(self):
        super().paintGL()
        if self.renderer.VisibleActorCount() > 0:
            print(time.time(), flush=True)
            os._exit(0)
viewport.Viewport = View
sys.argv = ["ffdstudio", sys.argv[1]]
from ffdstudio.__main__ import main
main()
"""


def seconds(*command: str) -> float:
    """Time from process start to the moment that the process prints."""
    with tempfile.TemporaryDirectory() as folder:  # no settings or autosaves of the user's
        places = {f"XDG_{name}_HOME": folder for name in ("CONFIG", "STATE", "DATA")}
        whole = [sys.executable, "-c", *command]
        start = time.time()
        done = subprocess.run(
            whole, capture_output=True, text=True, check=True, timeout=120, env=os.environ | places
        )
    return float(done.stdout.split()[-1]) - start


if __name__ == "__main__":
    repetitions = int(sys.argv[1]) if len(sys.argv) > 1 else 5
    pairs = [(seconds(EMPTY), seconds(OURS, str(SAMPLE))) for _ in range(repetitions + 1)][1:]
    empty, ours = (min(times) for times in zip(*pairs, strict=True))
    print(f"empty window with a viewport  {empty:6.2f} s")
    print(f"window with {SAMPLE.name:16}  {ours:6.2f} s   ratio {ours / empty:.2f} (target 1.5)")

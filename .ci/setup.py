"""Get this checkout ready to run: ``python3 .ci/setup.py gui`` (or ``dev``, ``docs``, ``bench``).

1. It runs before anything is installed: the standard library only, and a syntax that an
   old Python can still read, so that it can say that it is too old.
2. System packages are found by what is missing, not by name of the distribution: every
   shared library that Qt and VTK load is tried, so nothing is installed that works already.
3. Debian's and Ubuntu's names are given in their old form; the releases whose packages end
   in t64 provide those names.
4. What was done is noted in .venv under a hash of pyproject.toml: a second call is quick.
"""

import ctypes
import hashlib
import importlib.util
import os
import shutil
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
VENV = os.path.join(ROOT, ".venv")
OLDEST = (3, 11)
INCLUDED = {
    "gui": ("gui", "dev"),
    "dev": ("dev",),
    "bench": ("bench",),
    "samples": ("samples",),
    "docs": ("docs", "dev"),
}

LIBRARIES = {
    "libEGL.so.1": "libegl1",
    "libGL.so.1": "libgl1",
    "libOpenGL.so.0": "libopengl0",
    "libX11.so.6": "libx11-6",
    "libX11-xcb.so.1": "libx11-xcb1",
    "libXcursor.so.1": "libxcursor1",
    "libXrender.so.1": "libxrender1",
    "libdbus-1.so.3": "libdbus-1-3",
    "libfontconfig.so.1": "libfontconfig1",
    "libfreetype.so.6": "libfreetype6",
    "libglib-2.0.so.0": "libglib2.0-0",
    "libwayland-client.so.0": "libwayland-client0",
    "libwayland-cursor.so.0": "libwayland-cursor0",
    "libwayland-egl.so.1": "libwayland-egl1",
    "libxcb-cursor.so.0": "libxcb-cursor0",
    "libxcb-icccm.so.4": "libxcb-icccm4",
    "libxcb-image.so.0": "libxcb-image0",
    "libxcb-keysyms.so.1": "libxcb-keysyms1",
    "libxcb-randr.so.0": "libxcb-randr0",
    "libxcb-render-util.so.0": "libxcb-render-util0",
    "libxcb-shape.so.0": "libxcb-shape0",
    "libxcb-shm.so.0": "libxcb-shm0",
    "libxcb-sync.so.1": "libxcb-sync1",
    "libxcb-xfixes.so.0": "libxcb-xfixes0",
    "libxcb-xkb.so.1": "libxcb-xkb1",
    "libxkbcommon.so.0": "libxkbcommon0",
    "libxkbcommon-x11.so.0": "libxkbcommon-x11-0",
}
GMSH_LIBRARIES = {
    "libGLU.so.1": "libglu1-mesa",
    "libXft.so.2": "libxft2",
    "libXinerama.so.1": "libxinerama1",
    "libXfixes.so.3": "libxfixes3",
    "libgomp.so.1": "libgomp1",
}
SCREEN_PROGRAMS = {"Xvfb": "xvfb", "xauth": "xauth"}
TEST_PROGRAMS = {"xdotool": "xdotool"}


def main(extra):
    os.environ.setdefault("PATH", os.defpath + ":/usr/sbin:/sbin:/usr/local/bin")
    os.chdir(ROOT)
    check_python()
    install_system_packages(missing_packages(extra))
    if is_ready(extra):
        return
    make_environment()
    pip = [os.path.join(VENV, "bin", "python"), "-m", "pip", "--disable-pip-version-check"]
    say("installing FFD Studio with its Python packages into .venv (some minutes the first time)")
    run([*pip, "install", "--quiet", "--editable", ".[%s]" % extra])
    with open(stamp(extra), "w") as stream:
        stream.write(fingerprint())


def check_python():
    if sys.version_info >= OLDEST:
        return
    for minor in range(20, OLDEST[1] - 1, -1):
        newer = shutil.which("python3.%d" % minor)
        if newer:
            os.execv(newer, [newer, *sys.argv])
    stop(
        "FFD Studio needs Python 3.%d or newer, and %s is %s. Install a newer one and name it: "
        "make PYTHON=python3.12 run" % (OLDEST[1], sys.executable, sys.version.split()[0])
    )


def missing_packages(extra):
    """Debian packages that would bring what cannot be found now."""
    if not sys.platform.startswith("linux"):
        return []
    libraries = dict(LIBRARIES, **(GMSH_LIBRARIES if extra in ("dev", "samples") else {}))
    missing = [package for name, package in libraries.items() if not can_load(name)]
    programs = {}
    if extra == "dev":
        programs = dict(TEST_PROGRAMS, **({} if os.environ.get("DISPLAY") else SCREEN_PROGRAMS))
    missing += [package for name, package in programs.items() if not shutil.which(name)]
    if not os.path.exists(VENV) and not importlib.util.find_spec("ensurepip"):
        missing.append("python3.%d-venv" % sys.version_info[1])
    return missing


def can_load(library):
    try:
        ctypes.CDLL(library)
    except OSError:
        return False
    return True


def install_system_packages(packages):
    if not packages:
        return
    command = ["apt-get", "install", "-y", "--no-install-recommends", *packages]
    if not shutil.which("apt-get"):
        stop("these system packages (Debian's names) are missing: " + " ".join(packages))
    say("system packages that are missing here, to be installed now: " + " ".join(packages))
    prefix = administrator(" ".join(command))
    wait = ["-o", "DPkg::Lock::Timeout=300"]
    run([*prefix, "apt-get", "update", "-qq"])
    run([*prefix, command[0], *wait, "-qq", *command[1:]])


def administrator(command):
    """How to become root here: not at all, through sudo, or a word to the user."""
    quiet = ["env", "DEBIAN_FRONTEND=noninteractive"]
    if os.geteuid() == 0:
        return quiet
    if shutil.which("sudo"):
        if interactive() or subprocess.call(["sudo", "-n", "true"]) == 0:
            return ["sudo", *quiet]
    return stop(
        "installing them takes root or sudo, and neither is to be had here. "
        "Ask your administrator to run this, then call make again:\n    " + command
    )


def make_environment():
    python = os.path.join(VENV, "bin", "python")
    works = os.path.exists(python) and subprocess.call([python, "-c", "import pip"]) == 0
    if works:
        return
    say("making a virtual environment in .venv with Python " + sys.version.split()[0])
    run([sys.executable, "-m", "venv", "--clear", VENV])


def is_ready(extra):
    """Whether this extra, or one that includes it, was installed from this pyproject.toml."""
    return any(read(stamp(name)) == fingerprint() for name in INCLUDED[extra])


def stamp(extra):
    return os.path.join(VENV, "installed-" + extra)


def fingerprint():
    """Changes with the dependencies, with Python, and when the checkout is moved."""
    facts = read("pyproject.toml") + sys.version + ROOT
    return hashlib.sha256(facts.encode()).hexdigest()


def read(path):
    try:
        with open(path, encoding="utf-8") as stream:
            return stream.read()
    except OSError:
        return ""


def run(command):
    code = subprocess.call(command, stdin=None if interactive() else subprocess.DEVNULL)
    if code:
        stop("this command failed: " + " ".join(command))


def interactive():
    return sys.stdin is not None and sys.stdin.isatty()


def say(text):
    print("ffdstudio setup: " + text, flush=True)


def stop(text):
    sys.exit("ffdstudio setup: " + text)


if __name__ == "__main__":
    if len(sys.argv) != 2 or sys.argv[1] not in INCLUDED:
        stop("usage: python3 .ci/setup.py {%s}" % ",".join(INCLUDED))
    main(sys.argv[1])

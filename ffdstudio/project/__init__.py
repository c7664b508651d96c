"""The project: what is stored, what can be done to it, and its history."""

from ffdstudio.project.files.scripting import Project

__all__ = ["Project"]

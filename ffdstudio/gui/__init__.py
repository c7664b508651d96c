"""The window: the only room that knows Qt."""

from ffdstudio.gui.quirks import keep_singletons

keep_singletons()

"""The verb that serves a local page."""

from ._studio import studio as studio

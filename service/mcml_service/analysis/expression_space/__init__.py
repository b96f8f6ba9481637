"""The space of facial expressions: a map of all frames, levels of detail, links, paths and their playback."""

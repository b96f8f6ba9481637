"""The content of thumbnails of clips."""

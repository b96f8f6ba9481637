"""The store as a whole: backups, room, checks, what is removed for good."""

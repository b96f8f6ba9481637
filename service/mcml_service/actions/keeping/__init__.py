"""The store as a whole: backups, disk space, checks, permanent deletion."""

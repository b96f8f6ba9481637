"""ASF and AMC: Acclaim's skeleton and motion, two files. Facts and sources: formats.md 2 and 3."""

"""ASF and AMC: Acclaim's skeleton and motion, two files. See docs/formats/asf-amc.md."""

"""Text of motion files: encodings, lines, tables, and numbers read and written exactly."""

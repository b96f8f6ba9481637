"""MCML, the Motion Capture Markup Language: documents, their elements and names."""

"""Lists of documents from memory: what they are narrowed, ordered and counted by, of all documents as columns."""

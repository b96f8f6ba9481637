"""Lists of documents from memory: values for filters, sort orders and counts of all documents, as columns."""

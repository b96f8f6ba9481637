"""XPath: text to tree to plan, and the projected document for what no plan expresses."""

"""XPath: from text to tree to plan; expressions without a plan use the projected document."""

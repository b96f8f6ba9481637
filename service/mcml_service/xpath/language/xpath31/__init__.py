"""XPath 3.1 as it is written: elementpath's parser, corrected, and what is known of an expression before its value."""

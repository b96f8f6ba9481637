"""XPath 3.1 evaluated as written: elementpath's parser, with corrections, and static facts about expressions."""

"""The command line: one file a verb, each parsing, calling and printing."""

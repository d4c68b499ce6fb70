"""Where measurement and truth meet: scores, reports and the command line."""

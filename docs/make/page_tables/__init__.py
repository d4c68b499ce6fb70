"""What the tables of each page hold: head and rows, from files in docs/measured."""

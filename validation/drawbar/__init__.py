"""The drawbar pull test of a vehicle on soil, beside what was published (the paper's section 4.1)."""

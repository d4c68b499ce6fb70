"""What is shown to a person: one figure of a measurement, or a film of it."""

"""The force of the soil on a wheel: what a law is, and the laws there are."""

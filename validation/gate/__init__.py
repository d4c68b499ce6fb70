"""A gate for flow methods: small footage, a baseline, and a verdict that a build can fail on."""

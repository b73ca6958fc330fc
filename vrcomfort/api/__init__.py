"""The Python API behind `import vrcomfort`: it wires the parts together, the command line parses.

The functions are read as `vrcomfort.simulate_study` and so on; nothing is loaded before that.
"""

"""Seventeen flights by MuJoCo with something acting from outside, and nothing said of it.

Every flight must end well: identified, with what acts named and its size right, or
refused with its cause. All of them take some minutes:

    .venv/bin/python -m pytest -m long -s tests/oracles/test_flights_in_mujoco.py

or, as a table and on other seeds than the tests' own,

    .venv/bin/python tests/oracles/test_flights_in_mujoco.py --seed 1
"""

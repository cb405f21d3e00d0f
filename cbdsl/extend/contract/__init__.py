"""Contract tests of installed extensions: ``pytest --pyargs cbdsl.extend -k NAME``.

The environment variable ``CBDSL_ROBOT`` names the robot for backends, by default Dexter.
"""

"""Decimal numbers in mesh files."""

#: Pattern of a decimal number below 1e30. Possessive quantifiers keep its time linear.
DECIMAL = r"[-+]?(?:\d++(?:\.\d*+)?|\.\d++)(?:[eE](?:-\d++|\+?(?=\d)0*+(?:[12]?\d)?(?!\d)))?+"

"""What a user can write down of a plant: equations, variables with units and ranges, tables.

plant           Plant, the value: M(x) x' = f(x, u, w), y = g(x, u, w), on a box
tokens          the text of an expression, cut into numbers, names and signs
expression      a whitelist grammar: text -> sympy; nothing in the text is executed
table_function  splines of one or two arguments as functions in sympy expressions
units           units as written -> dimensions and an exact factor to SI
dimensions      every equation, output and argument must fit by its units
coverage        the arguments of tables must stay inside them on the box
entries         what a plant file may contain; its JSON Schema
schema          prints that schema
csv_table       tables from CSV
table_entry     a table that a plant file names: its place, units and function
loader          TOML file -> Plant
blending_section    two actuators of a file that share one effort -> the plant behind their blend
design_settings, design_section    what is asked of a design; the section [design] of a file
"""

"""Models that exist elsewhere: in sympy, python-control, arrays, MATLAB, OpenFAST or ROSCO."""

"""Plants and turbines that exist elsewhere: sympy, python-control, arrays, MATLAB, OpenFAST, ROSCO."""

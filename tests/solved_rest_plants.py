"""Texts of plants whose rests are not decimals.

Sources: Seborg, Edgar, Mellichamp, Doyle, Process Dynamics and Control, example 2.5 (the stirred
tank, with the figures that are used in the literature); Khalil, Nonlinear Systems, exercise 1.18
(a ball under a magnet, the force proportional to (i/z)^2).  Both recalled.
"""

MAGNET = """
format = 1
kind = "plant"
name = "Ball under a magnet"
[states]
z = { unit = "mm", range = [8, 12], rest = "z0" }
v = { unit = "m/s", range = [-0.2, 0.2] }
i = { unit = "A", range = [0.6, 1.4], rest = "solve" }
[inputs]
u = { unit = "V", range = [0, 24], rest = "solve" }
[parameters]
m = { value = 50, unit = "g" }
g = { value = 9.81, unit = "m/s^2" }
c = { value = 5e-5, unit = "N m^2/A^2" }
R = { value = 10, unit = "Ohm" }
L = { value = 0.1, unit = "H" }
z0 = { value = 10, unit = "mm" }
[equations]
z = "v"
v = "g - c/m*(i/z)^2"
i = "(u - R*i)/L"
"""

TANK = """
format = 1
kind = "plant"
name = "Stirred tank"
[states]
C = { unit = "mol/L", range = [0.3, 0.7], rest = { near = 0.5 } }
T = { unit = "K", range = [340, 360], rest = { near = 350 } }
[inputs]
Tc = { unit = "K", range = [280, 320], rest = 300 }
[parameters]
q = { value = 100, unit = "L/min" }
V = { value = 100, unit = "L" }
Cf = { value = 1, unit = "mol/L" }
Tf = { value = 350, unit = "K" }
k0 = { value = 7.2e10, unit = "1/min" }
E = { value = 8750, unit = "K" }
rho = { value = 1000, unit = "g/L" }
cp = { value = 0.239, unit = "J/(g K)" }
dH = { value = -5e4, unit = "J/mol" }
UA = { value = 5e4, unit = "J/(min K)" }
[equations]
C = "q/V*(Cf - C) - k0*exp(-E/T)*C"
T = "q/V*(Tf - T) - dH/(rho*cp)*k0*exp(-E/T)*C + UA/(V*rho*cp)*(Tc - T)"
"""

FAN = """
format = 1
kind = "plant"
name = "Fan at 1500 rpm"
[states]
w = { unit = "rad/s", range = [100, 220], rest = "w0" }
i = { unit = "A", range = [-10, 30], rest = "solve" }
[inputs]
u = { unit = "V", range = [0, 300], rest = "solve" }
[parameters]
c = { value = "P/w0^3", source = "nominal load" }
w0 = "2*pi*n0"
n0 = { value = 1500, unit = "1/min" }
P = { value = 500, unit = "W" }
J = { value = 0.02, unit = "kg m^2" }
k = { value = 0.8, unit = "N m/A" }
R = { value = 2, unit = "Ohm" }
L = { value = 0.05, unit = "H" }
[equations]
w = "(k*i - c*w^2)/J"
i = "(u - R*i - k*w)/L"
"""

DISCRETE = """
format = 1
kind = "plant"
units = "unchecked"
sample_time = 0.1
[states]
q = { range = [0.1, 1.4], rest = "solve" }
[inputs]
u = { range = [0, 5], rest = 2 }
[equations]
q = "q + 0.1*(u - exp(q))"
"""

ARM = """
format = 1
kind = "plant"
units = "unchecked"
[states]
q = { range = [0.1, 1.2], rest = "solve" }
p = { range = [-1, 1], rest = "solve" }
[inputs]
u = { range = [0, 5], rest = 2 }
[equations]
q = "p"
p = "u - 3*sin(q) - p/2"
[mass]
p = { p = "1 + q^2/10" }
"""

PLANTS = {"magnet": MAGNET, "tank": TANK, "fan": FAN, "discrete": DISCRETE, "arm": ARM}

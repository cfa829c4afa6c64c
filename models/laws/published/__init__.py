"""The published multi-region laws (``paper`` and ``paper-two-integrators`` on the command line).

law               the law, read literally, and its nearest working reading
coupling_filter, reference_filter    torque and pitch control blended; a low-pass on the speed
regional_schedule     one region's scheduled gains
equilibrium, equilibrium_point    its equilibrium; that point as a value
one_integrator, two_integrators   the balances that give the point
linearisation     the law and its loop, linearised there
"""

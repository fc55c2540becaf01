#!/usr/bin/python3
"""Retreat of the bed [m] against time [s]: dP/dt = rho g (h + n R), u = P / (rho (h + n R)), dR/dt = k_d (f / 8 rho u^2 - tau_c) where positive."""
DENSITY, ALONG, DEPTH, POROSITY = 1000.0, 0.5, 0.06, 0.4  # kg/m3, m/s2, m, 1
FRICTION, CRITICAL, ERODIBILITY = 0.08, 2.0, 5e-4  # 1, Pa, m3/(N s)
STEP = 1e-4  # s

retreat = momentum = 0.0
for k in range(1, 35001):
    mass = DENSITY * (DEPTH + POROSITY * retreat)
    speed = momentum / mass
    retreat += STEP * ERODIBILITY * max(0.0, FRICTION / 8 * DENSITY * speed**2 - CRITICAL)
    momentum += STEP * mass * ALONG
    if k % 1000 == 0:
        print(f"{k * STEP:.1f} {retreat:.5f} {speed:.4f} {momentum:.3f}")

"""The standard contract: what each role gives. Written by `poretwin exchange-fields --python`."""

# name, unit, vector, mapping, mask; what a fluid gives whose water is particles, a solid, and a fluid whose water
# is a field (fluid.representation)
STANDARD: dict[str, list[tuple[str, str, bool, str, str]]] = {
    "fluid": [
        ("pore_pressure", "Pa", False, "consistent", ""),
        ("predicted_solid_velocity", "m/s", True, "consistent", "soil_fraction"),
        ("predicted_change", "m/s", True, "consistent", "soil_fraction"),
        ("drag_impulse", "N s", True, "conservative", ""),
        ("soil_fraction", "1", False, "consistent", ""),
        ("surface_gradient", "Pa/m", True, "consistent", "surface_share"),
        ("surface_share", "1", False, "consistent", ""),
        ("spreading_rate", "1/s", False, "consistent", "soil_fraction"),
    ],
    "solid": [
        ("solid_velocity", "m/s", True, "consistent", ""),
        ("mean_solid_velocity", "m/s", True, "consistent", ""),
        ("volumetric_strain_rate", "1/s", False, "consistent", ""),
        ("unbalanced_force", "N/m3", True, "consistent", ""),
        ("solid_volume_fraction", "1", False, "consistent", ""),
        ("grain_density", "kg/m3", False, "nearest", ""),
        ("constrained_modulus", "Pa", False, "nearest", ""),
        ("yielding", "1", False, "consistent", ""),
        ("hydraulic_conductivity", "m/s", False, "nearest", ""),
        ("forchheimer_coefficient", "s2/m2", False, "nearest", ""),
        ("returned_impulse", "N s", True, "conservative", ""),
    ],
    "field": [
        ("pore_pressure", "Pa", False, "consistent", ""),
        ("degree_of_saturation", "1", False, "consistent", ""),
    ],
}
